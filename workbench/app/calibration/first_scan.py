"""A scan of a scanner that nobody has prepared: what in it does not fit the cell, and the keys."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.clouds.scans import CLOUD_AXES, points_of, turned_to_camera
from workbench.formats.files.units import UNITS
from workbench.model.cell import IN_WORLD, ScannerMount
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, pose_from_rpy, shift_and_turn
from workbench.model.messages.calibration import FirstScanText
from workbench.model.messages.message import Message
from workbench.model.part import Bin, Part
from workbench.model.scan import Scan
from workbench.perception.bins.bin_fit import fit_bin
from workbench.perception.bins.bin_measure import measure_bin
from workbench.perception.bins.bin_search import FoundBin, find_bin
from workbench.perception.bins.lying import HIGHEST, Lying, find_lying
from workbench.perception.scene.sensor import sensor_model

FITTING = 0.5
"""Share of the points that must lie where the scanner measures for a unit to be believed."""

BIN_OFF, BIN_TURNED = 0.003, float(np.deg2rad(1.0))
"""[m, rad] By which the bin may be off; more is said."""

NEAREST_RANGE, FARTHEST_RANGE, RANGE_SLACK = 0.15, 3.0, 0.2
"""[m] Where any scanner measures, and the share that is added around where one has measured."""

WIDEST_VIEW = float(np.tan(np.deg2rad(75.0)))
"""No scanner sees farther aside than this share of the depth."""

LEAST_RIM = 0.3
"""Of the bin's shorter side: what is narrower is no rim of any bin."""

SQUARE = 0.05
"""A bin whose sides differ by less looks alike after a quarter turn."""

LEVEL = float(np.deg2rad(5.0))
"""[rad] By which a floor may lean in the frame of the cell."""

LOOKS_DOWN = pose_from_rpy((0, 0, 0), (np.pi, 0, 0)).rotation

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
        InputError: in no unit does it lie where the scanner measures; or its origin is at the
            floor, which is not level in it.
    """
    stated, stated_bin, points = mount, bin, points_of(path, content)
    mount, fitting = _in_range(path, points, _above(points, mount, largest) or mount)
    is_in_world = mount.cloud_axes == IN_WORLD
    metres = points * UNITS[mount.unit]
    scan = turned_to_camera(Scan(metres, mount.T_world_scanner, path.name), mount.cloud_axes)
    noise = sensor_model(scan.points).noise
    found, bin = _bin_in(scan, stated_bin)
    T_scanner_bin, lying = found.T_scanner_bin, None
    if T_scanner_bin is None and not _is_over_floor(scan, bin, noise, is_in_world):
        lying = find_lying(scan.points, largest)
        _check_height(path, lying)
        T_scanner_bin = None if lying is None else _bin_on(lying, bin)
    T_world_scanner = mount.T_world_scanner
    shift, turn = shift_and_turn(T_world_scanner.actInv(stated.T_world_scanner))
    if T_scanner_bin is not None:
        length, width = bin.size[:2]
        count = 4 if abs(length - width) < SQUARE * length else 2
        Ts = [
            T_scanner_bin * pose_from_rpy((0, 0, 0), (0, 0, 2 * np.pi * k / count))
            for k in range(count)
        ]
        if is_in_world:
            Ts_world_bin = [T_world_scanner * T for T in Ts]
            T_world_bin = _most_alike(Ts_world_bin, stated_bin.T_world_bin)
            shift, turn = shift_and_turn(T_world_bin.actInv(stated_bin.T_world_bin))
            bin = replace(bin, T_world_bin=T_world_bin)
        else:
            Ts_world_scanner = [bin.T_world_bin * T.inverse() for T in Ts]
            T_world_scanner = _most_alike(Ts_world_scanner, stated.T_world_scanner)
            shift, turn = shift_and_turn(T_world_scanner.actInv(stated.T_world_scanner))
    seen = replace(scan, T_world_scanner=T_world_scanner)
    if mount.calibration is None:
        mount = replace(mount, T_world_scanner=T_world_scanner)
    surface = None if lying is None or mount.calibration else _surface(lying, bin)
    first = FirstScan(mount, fitting, noise, found, bin, shift, turn, (), surface)
    return replace(first, says=tuple(_says(first, seen, stated, stated_bin, lying)))


def _most_alike(Ts: Sequence[pin.SE3], T: pin.SE3) -> pin.SE3:
    """Of some poses the one that is turned least against another."""
    return min(Ts, key=lambda each: shift_and_turn(each.actInv(T))[1])


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


def _in_range(path: Path, points: Floats, mount: ScannerMount) -> tuple[ScannerMount, float]:
    """The mount with the unit, axes and range that fit points best, and the share that fits.

    Raises:
        InputError: most of them lie where no scanner measures.
    """
    found, fitting = _guess(points, mount)
    if fitting < FITTING:
        mount = replace(mount, near=NEAREST_RANGE, far=FARTHEST_RANGE)
        found, fitting = _guess(points, mount)
        if fitting < FITTING:
            raise InputError(
                FirstScanText.NO_FIT(
                    path=str(path), share=fitting, near=f"{mount.near:g}", far=f"{mount.far:g}"
                )
            )
        depth = _before_scanner(points, found)[:, 2]
        before = depth[(depth > NEAREST_RANGE) & (depth < FARTHEST_RANGE)]
        near, far = np.percentile(before, (1, 99)) * (1 - RANGE_SLACK, 1 + RANGE_SLACK)
        # To whole centimetres, as people write them.
        near, far = np.floor(near * 100) / 100, np.ceil(far * 100) / 100
        found = replace(found, near=float(near), far=float(far))
    return found, fitting


def _guess(points: Floats, mount: ScannerMount) -> tuple[ScannerMount, float]:
    """The mount with unit and axes by which most points lie where it measures, and what share.

    First come those that it has.  Points that are stated to be in the frame of the cell stay so.
    """
    best, most = mount, 0.0
    some = points[:: max(1, len(points) // 20_000)]
    every = (IN_WORLD,) if mount.cloud_axes == IN_WORLD else (mount.cloud_axes, *CLOUD_AXES)
    for unit, axes in product((mount.unit, *UNITS), every):
        tried = replace(mount, unit=unit, cloud_axes=axes)
        at = _before_scanner(some, tried)
        depth, aside = at[:, 2], np.hypot(at[:, 0], at[:, 1])
        is_seen = (depth > mount.near) & (depth < mount.far) & (aside < WIDEST_VIEW * depth)
        share = float(np.mean(is_seen))
        if share > most + 0.05:
            best, most = tried, share
    return best, most


def _before_scanner(points: Floats, mount: ScannerMount) -> Floats:
    """The points (n, 3) of a file in the scanner's frame [m]."""
    scan = Scan(points * UNITS[mount.unit], mount.T_world_scanner, "")
    return turned_to_camera(scan, mount.cloud_axes).points


def _above(points: Floats, mount: ScannerMount, largest: float) -> ScannerMount | None:
    """A mount above points that are in the frame of the cell, looking down; None if they are not.

    They are where their floor is level and so near to the origin that no scanner can be there.

    Args:
        points: (n, 3) of a file.
        mount: the scanner as the cell has it.
        largest: see `first_scan`.
    """
    if mount.cloud_axes == IN_WORLD:
        return None
    height = max((mount.near + mount.far) / 2, 2 * NEAREST_RANGE)
    for unit in (mount.unit, *UNITS):
        low, middle, high = np.percentile(points, (5, 50, 95), axis=0) * UNITS[unit]
        if low[2] < -NEAREST_RANGE or high[2] > NEAREST_RANGE + HIGHEST:
            continue
        if not NEAREST_RANGE / 2 < np.linalg.norm((high - low)[:2]) < FARTHEST_RANGE:
            continue
        T = pin.SE3(LOOKS_DOWN, np.array([middle[0], middle[1], height]))
        tried = replace(mount, unit=unit, cloud_axes=IN_WORLD, T_world_scanner=T, calibration=None)
        lying = find_lying(_before_scanner(points, tried), largest)
        if lying is None or not lying.is_floor_seen:
            continue
        T_world_floor = T * lying.T_scanner_region
        is_level = T_world_floor.rotation[2, 2] > np.cos(LEVEL)
        if is_level and abs(T_world_floor.translation[2]) < NEAREST_RANGE:
            p = T_world_floor.translation + [0.0, 0.0, height]
            return replace(tried, T_world_scanner=pin.SE3(LOOKS_DOWN, p))
    return None


def _is_over_floor(scan: Scan, bin: Bin, noise: float | None, is_in_world: bool) -> bool:
    """Whether the floor is seen where the cell has it; in its frame, most of the points as well."""
    T_bin_scanner = bin.T_world_bin.actInv(scan.T_world_scanner)
    if is_in_world:
        middle = T_bin_scanner.act(np.median(scan.points, axis=0))
        if (np.abs(middle[:2]) > bin.size[:2] / 4).any():
            return False
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
    is_in_world = proposed.cloud_axes == IN_WORLD
    if is_in_world and mount.cloud_axes != IN_WORLD:
        T_bin_scanner = first.bin.T_world_bin.actInv(proposed.T_world_scanner)
        yield FirstScanText.IN_WORLD(above=float(T_bin_scanner.translation[2]))
    elif proposed.cloud_axes != mount.cloud_axes:
        yield FirstScanText.AXES(axes=proposed.cloud_axes, was=mount.cloud_axes)
    if lying is not None:
        length, width = map(float, np.sort(lying.size[:2])[::-1])
        if lying.is_floor_seen:
            yield FirstScanText.FLOOR_ALONE(length=length, width=width)
        else:
            yield FirstScanText.NO_FLOOR(length=length, width=width, below=lying.below)
        return
    if not bin.has_walls:
        if not is_in_world:
            yield FirstScanText.NO_WALLS()
        return
    if not np.array_equal(first.bin.size, bin.size):
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
        off = FirstScanText.OFF
        if is_in_world:
            off = FirstScanText.BIN_MOVED
        elif mount.calibration is None:
            off = FirstScanText.NOT_CALIBRATED
        yield off(shift=first.shift, turn=first.turn)


def _millimetres(bin: Bin) -> str:
    return " x ".join(f"{1000 * side:.0f}" for side in bin.size)
