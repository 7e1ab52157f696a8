"""A scan of a scanner that nobody has prepared: what in it does not fit the cell, and the keys."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.clouds.scans import CLOUD_AXES, points_of, turned_to_camera
from workbench.formats.files.units import UNITS
from workbench.model.cell import ScannerMount
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, pose_from_rpy, shift_and_turn
from workbench.model.messages.calibration import FirstScanText
from workbench.model.messages.message import Message
from workbench.model.part import Bin, Part
from workbench.model.scan import Scan
from workbench.perception.bins.bin_fit import fit_bin
from workbench.perception.bins.bin_measure import measure_bin
from workbench.perception.bins.bin_search import FoundBin, find_bin
from workbench.perception.bins.lying import Lying, find_lying
from workbench.perception.scene.sensor import sensor_model

FITTING = 0.5
"""Share of the points that must lie where the scanner measures for a unit to be believed."""

BIN_OFF, BIN_TURNED = 0.003, float(np.deg2rad(1.0))
"""[m, rad] By which the bin may be off; more is said."""

NEAREST_RANGE, FARTHEST_RANGE, RANGE_SLACK = 0.15, 3.0, 0.2
"""[m] Where any scanner measures, and the share that is added around where one has measured."""

LEAST_RIM = 0.3
"""Of the bin's shorter side: what is narrower is no rim of any bin."""

SQUARE = 0.05
"""A bin whose sides differ by less looks alike after a quarter turn."""

TALLER = 0.01
"""[m] By which the walls may be higher than the cell has them; more is another bin."""

SIZE_OFF = 0.008
"""[m] By which the rim may be larger than the cell has it; more is another bin."""


@dataclass(frozen=True, slots=True, eq=False)
class FirstScan:
    """What a scan says of a scanner.

    `mount` is the cell's with what fits the scan better.  `fitting` is the share of the points
    that lie where the scanner measures, `noise` [m] their deviation at 1 m or None.  `found` is
    the bin, `bin` the cell's with the size that is seen where it is another one.  `shift` [m] and
    `turn` [rad] are how far the proposed pose is from the cell's.  `surface` is the bin without
    walls, as large as what lies there, where parts and no rim are seen.  `says` is what is not as
    the cell has it, one sentence each, with the key to change.
    """

    mount: ScannerMount
    fitting: float
    noise: float | None
    found: FoundBin
    bin: Bin
    shift: float
    turn: float
    says: tuple[Message, ...]
    surface: Bin | None = None


def largest_of(parts: Sequence[Part]) -> float:
    """Diameter of the largest of some parts [m]; 0 of none."""
    return max((part.mesh.diameter for part in parts), default=0.0)


def first_scan(
    path: Path, content: bytes, mount: ScannerMount, bin: Bin, *, largest: float = 0.0
) -> FirstScan:
    """Look at a scan as if nothing of its file were known.

    Args:
        path: of the file, for messages.
        content: of the file, PLY or PCD.
        mount: the scanner as the cell has it.
        bin: that it looks at.
        largest: [m] diameter of the largest part that may lie there; planes as small are no floor.

    Raises:
        FileError: it is no cloud, or an empty one.
        InputError: in no unit does it lie where the scanner measures, or its origin is at the
            floor.
    """
    stated, stated_bin, points = mount, bin, points_of(path, content)
    unit, axes, fitting = _guess(points, mount)
    if fitting < FITTING:
        mount, (unit, axes, fitting) = _anywhere(points, mount)
    if fitting < FITTING:
        raise InputError(
            FirstScanText.NO_FIT(
                path=str(path), share=fitting, near=f"{mount.near:g}", far=f"{mount.far:g}"
            )
        )
    scan = turned_to_camera(Scan(points * UNITS[unit], mount.T_world_scanner, path.name), axes)
    noise = sensor_model(scan.points).noise
    found, bin = _bin_in(scan, stated_bin)
    T_scanner_bin, lying = found.T_scanner_bin, None
    if T_scanner_bin is None and not _is_over_floor(scan, bin, noise):
        lying = find_lying(scan.points, largest)
        _check_height(path, lying)
        T_scanner_bin = None if lying is None else _bin_on(lying, bin)
    T_world_scanner = mount.T_world_scanner
    if T_scanner_bin is not None:
        length, width = bin.size[:2]
        count = 4 if abs(length - width) < SQUARE * length else 2
        Ts = [
            bin.T_world_bin
            * pose_from_rpy((0, 0, 0), (0, 0, 2 * np.pi * k / count))
            * T_scanner_bin.inverse()
            for k in range(count)
        ]
        T_world_scanner = min(Ts, key=lambda T: shift_and_turn(T.actInv(mount.T_world_scanner))[1])
    shift, turn = shift_and_turn(T_world_scanner.actInv(mount.T_world_scanner))
    proposed = replace(mount, unit=unit, cloud_axes=axes)
    if mount.calibration is None:
        proposed = replace(proposed, T_world_scanner=T_world_scanner)
    seen = replace(scan, T_world_scanner=T_world_scanner)
    surface = None if lying is None or mount.calibration else _surface(lying, bin)
    first = FirstScan(proposed, fitting, noise, found, bin, shift, turn, (), surface)
    return replace(first, says=tuple(_says(first, seen, stated, stated_bin, lying)))


def _bin_in(scan: Scan, bin: Bin) -> tuple[FoundBin, Bin]:
    """Where the cell's bin is seen; or, if it is not, another one that is, with its size."""
    found = find_bin(scan.points, bin)
    measured = measure_bin(scan.points) if bin.has_walls else None
    if measured is None:
        return found, bin
    is_cut = measured.height > bin.size[2] + TALLER
    if found.T_scanner_bin is not None and not is_cut:
        return found, bin
    other = _with_size(bin, measured.outside, measured.height)
    found = find_bin(scan.points, other)
    if found.T_scanner_bin is None or found.rim is None:
        return found, other
    # The rim as a whole is measured better than its highest ring alone.
    other = _with_size(bin, found.rim, measured.height)
    return find_bin(scan.points, other), other


def _with_size(bin: Bin, outside: tuple[float, float], height: float) -> Bin:
    """The bin with other sides [m] around its rim, the longer one as before, and height."""
    longer, shorter = np.array(outside) - 2 * bin.wall
    sides = (shorter, longer) if bin.size[0] < bin.size[1] else (longer, shorter)
    return replace(bin, size=np.round([*sides, height], 3))


def _guess(points: Floats, mount: ScannerMount) -> tuple[str, str, float]:
    """Unit and axes by which most points lie where the scanner measures; first those it has."""
    best = (mount.unit, mount.cloud_axes, 0.0)
    some = points[:: max(1, len(points) // 20_000)]
    for unit in (mount.unit, *UNITS):
        for axes in (mount.cloud_axes, *CLOUD_AXES):
            depth = some @ np.array(CLOUD_AXES[axes][2], dtype=float) * UNITS[unit]
            share = float(np.mean((depth > mount.near) & (depth < mount.far)))
            if share > best[2] + 0.05:
                best = unit, axes, share
    return best


def _anywhere(points: Floats, mount: ScannerMount) -> tuple[ScannerMount, tuple[str, str, float]]:
    """Unit and axes by which most points lie where any scanner measures, and a mount for these."""
    unit, axes, fitting = _guess(points, replace(mount, near=NEAREST_RANGE, far=FARTHEST_RANGE))
    depth = points @ np.array(CLOUD_AXES[axes][2], dtype=float) * UNITS[unit]
    before = depth[(depth > NEAREST_RANGE) & (depth < FARTHEST_RANGE)]
    if fitting < FITTING:
        return replace(mount, near=NEAREST_RANGE, far=FARTHEST_RANGE), (unit, axes, fitting)
    near, far = np.percentile(before, (1, 99)) * (1 - RANGE_SLACK, 1 + RANGE_SLACK)
    # To whole centimetres, as people write them.
    near, far = np.floor(near * 100) / 100, np.ceil(far * 100) / 100
    return replace(mount, near=float(near), far=float(far)), (unit, axes, fitting)


def _is_over_floor(scan: Scan, bin: Bin, noise: float | None) -> bool:
    """Whether the floor is seen where the cell has it."""
    T_bin_scanner = bin.T_world_bin.actInv(scan.T_world_scanner)
    return fit_bin(scan.points, T_bin_scanner, bin, noise=noise or 0.0).is_floor_seen


def _check_height(path: Path, lying: Lying | None) -> None:
    """Refuse a cloud of another frame than its scanner's: its origin is at the floor.

    Raises:
        InputError: a scanner there would measure nothing.
    """
    if lying is not None and lying.is_floor_seen:
        height = float(lying.T_scanner_region.inverse().translation[2])
        if height < NEAREST_RANGE:
            raise InputError(FirstScanText.AT_FLOOR(path=str(path), height=height))


def _is_across(lying: Lying, bin: Bin) -> bool:
    """Whether parts lie along the bin's shorter side, where x is as in the scanner's picture."""
    return bool((lying.size[0] > lying.size[1]) != (bin.size[0] > bin.size[1]))


def _bin_on(lying: Lying, bin: Bin) -> pin.SE3:
    """The bin in the middle of what lies on a floor, its longer side along the longer one."""
    yaw = np.pi / 2 if _is_across(lying, bin) else 0.0
    return lying.T_scanner_region * pose_from_rpy((0, 0, 0), (0, 0, yaw))


def _surface(lying: Lying, bin: Bin) -> Bin:
    """A floor without walls, of the size of what lies on it."""
    size = lying.size[[1, 0, 2]] if _is_across(lying, bin) else lying.size
    return replace(bin, size=size, has_walls=False)


def _says(
    first: FirstScan,
    scan: Scan,
    mount: ScannerMount,
    bin: Bin,
    lying: Lying | None,
) -> Iterator[Message]:
    proposed, found = first.mount, first.found
    if proposed.near != mount.near or proposed.far != mount.far:
        near, far = (f"{value * 1000:.0f}" for value in (proposed.near, proposed.far))
        yield FirstScanText.RANGE(near=near, far=far)
    if proposed.unit != mount.unit:
        yield FirstScanText.UNIT(unit=proposed.unit)
    if proposed.cloud_axes != mount.cloud_axes:
        yield FirstScanText.AXES(axes=proposed.cloud_axes, was=mount.cloud_axes)
    if lying is not None:
        length, width = map(float, np.sort(lying.size[:2])[::-1])
        if lying.is_floor_seen:
            yield FirstScanText.FLOOR_ALONE(length=length, width=width)
        else:
            yield FirstScanText.NO_FLOOR(length=length, width=width, below=lying.below)
        return
    if not bin.has_walls:
        yield FirstScanText.NO_WALLS()
        return
    if first.bin is not bin:
        yield FirstScanText.OTHER_BIN(seen=_millimetres(first.bin), wanted=_millimetres(bin))
        bin = first.bin
    if found.T_scanner_bin is None:
        if found.rim is None or min(found.rim) < LEAST_RIM * min(bin.size[:2]):
            yield FirstScanText.NO_BIN()
            return
        length, width = map(float, found.rim)
        yield FirstScanText.OTHER_RIM(length=length, width=width)
        return
    outer = np.sort(np.asarray(bin.size[:2]) + 2 * bin.wall)[::-1]
    if found.rim is not None and np.abs(np.array(found.rim) - outer).max() > SIZE_OFF:
        length, width = map(float, found.rim)
        wanted = {"wanted_length": float(outer[0]), "wanted_width": float(outer[1])}
        yield FirstScanText.RIM_SIZE(length=length, width=width, **wanted)
    seen = fit_bin(scan.points, bin.T_world_bin.actInv(scan.T_world_scanner), bin, noise=0.0)
    if seen.is_floor_seen and abs(seen.floor[0]) > BIN_OFF:
        depth = float(bin.size[2] - seen.floor[0])
        yield FirstScanText.FLOOR_DEPTH(depth=depth, wanted=float(bin.size[2]))
    if first.shift > BIN_OFF or first.turn > BIN_TURNED:
        is_new = mount.calibration is None
        off = FirstScanText.NOT_CALIBRATED if is_new else FirstScanText.OFF
        yield off(shift=first.shift, turn=first.turn)


def _millimetres(bin: Bin) -> str:
    return " x ".join(f"{1000 * side:.0f}" for side in bin.size)
