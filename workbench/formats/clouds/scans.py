"""Point clouds in PLY and PCD files to scans, and scans to PLY files.

A scan of a cell's scanner comes in by `read_scan` or `parse_scan`, which go by the unit that the
cell file gives.  An organised PLY file carries the line `obj_info resolution <columns> <rows>` in
its header and the vertex property `pixel`, row * columns + column.  Photoneo files state image size
and camera pose in another way: see `photoneo`.
"""

import re
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np
import pinocchio as pin

from workbench.formats.clouds.colours import CHANNELS, of_channels, unless_all_alike
from workbench.formats.clouds.pcd import read_pcd
from workbench.formats.clouds.photoneo import camera_of
from workbench.formats.clouds.ply_header import PlyHeader, read_header
from workbench.formats.files.text_rows import read_rows
from workbench.formats.files.toml_keys import quote
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import MB, read_whole, write_whole
from workbench.model.cell import IN_WORLD, Z_FORWARD, ScannerMount
from workbench.model.errors import FileError
from workbench.model.geometry import Bools, Floats, transform
from workbench.model.messages.files import FileProblem
from workbench.model.scan import Scan

LARGEST_FILE = 512 * MB
MOST_POINTS = 10_000_000
"""More than the largest structured-light scanners deliver."""

MOST_PIXELS = 2**31 - 1
"""`Scan` counts pixels in 32 bits."""

NEAREST_POINT, FARTHEST_POINT = 0.005, 100.0
"""[m] A cloud of which every point is nearer, or one is further, was read in a wrong unit."""

RANGE_FACTOR = 6.0
"""By this factor a scan may lie nearer or further than the scanner measures: less than lies
between any two units."""

PLY_TYPES = {"<f8": "double", "<i4": "int", "u1": "uchar"}
"""NumPy's types of the properties that are written, and PLY's names of them."""

STRAY_SHARE = 0.05
"""Share of stray points, which do not show the unit."""

KEY = "`unit` in [scanner] of the cell file"

CLOUD_AXES: Mapping[str, tuple[tuple[int, int, int], ...]] = MappingProxyType(
    {
        Z_FORWARD: ((1, 0, 0), (0, 1, 0), (0, 0, 1)),
        "z_back": ((1, 0, 0), (0, -1, 0), (0, 0, -1)),
        "x_forward": ((0, -1, 0), (0, 0, -1), (1, 0, 0)),
    }
)
"""Rotations from the axes of a cloud to the scanner's frame, x right, y down, z forward.

`z_back` has x right and y up, as OpenGL and the viewers of Open3D and RealSense; `x_forward` has y
left and z up, as a link in ROS (REP 103).
"""

KNOWN_AXES = (*CLOUD_AXES, IN_WORLD)
"""What `cloud_axes` may be; with `IN_WORLD` the points are in the frame of the cell."""

_RESOLUTION = re.compile(r"resolution +([0-9]{1,6}) +([0-9]{1,6})")


def read_scan(path: str | Path, mount: ScannerMount, *, key: str = KEY) -> Scan:
    """A scan of a cell's scanner from a PLY or PCD file; see `parse_scan`.

    Raises:
        FileError: it cannot be read, or as `parse_scan` has it.
    """
    path = Path(path)
    return parse_scan(path, read_whole(path, LARGEST_FILE), mount, key=key)


def parse_scan(path: Path, content: bytes, mount: ScannerMount, *, key: str = KEY) -> Scan:
    """A scan of a cell's scanner from the content of a file, in the unit that the mount says.

    Args:
        path: of the file, for messages.
        content: of the file, points in the scanner's frame, or with the axes of `cloud_axes`.
        mount: where the scanner hangs, how far it measures, unit and axes of its files.
        key: which gives the unit, for messages.

    Raises:
        FileError: as `parse_cloud` has it, or next to nothing of it lies where the scanner can
            measure: its unit is another one; or nearly all of it behind it: other axes.
    """
    scan = parse_cloud(path, content, mount.T_world_scanner, unit=mount.unit, key=key)
    scan = turned_to_camera(scan, mount.cloud_axes)
    away = np.linalg.norm(scan.points, axis=1)
    nearest, farthest = (
        float(value) for value in np.quantile(away, (STRAY_SHARE, 1 - STRAY_SHARE))
    )
    if nearest > mount.far * RANGE_FACTOR or farthest < mount.near / RANGE_FACTOR:
        raise FileError(
            path,
            FileProblem.OUT_OF_RANGE(
                nearest=f"{nearest:.4g}",
                farthest=f"{farthest:.4g}",
                unit=mount.unit,
                key=key,
                near=f"{mount.near:g}",
                far=f"{mount.far:g}",
                units=UNITS,
            ),
        )
    if before(scan) < STRAY_SHARE:
        raise FileError(path, FileProblem.BEHIND(axes=mount.cloud_axes, known=KNOWN_AXES))
    return scan


def turned_to_camera(scan: Scan, axes: str) -> Scan:
    """A scan whose points have the axes of that name (`KNOWN_AXES`), in the scanner's frame."""
    if axes == Z_FORWARD:
        return scan
    if axes == IN_WORLD:
        T = scan.T_world_scanner
        return replace(scan, points=transform(T.inverse(), scan.points))
    return replace(scan, points=scan.points @ np.array(CLOUD_AXES[axes], dtype=float).T)


def before(scan: Scan) -> float:
    """The share of the points that lie before the scanner."""
    return float(np.mean(scan.points[:, 2] > 0))


def read_cloud(path: str | Path, T_world_scanner: pin.SE3, *, unit: str = "m") -> Scan:
    """A scan from a PLY or PCD file; see `parse_cloud`.

    Raises:
        FileError: it cannot be read, or as `parse_cloud` has it.
    """
    path = Path(path)
    return parse_cloud(path, read_whole(path, LARGEST_FILE), T_world_scanner, unit=unit)


def parse_cloud(
    path: Path, content: bytes, T_world_scanner: pin.SE3, *, unit: str = "m", key: str = ""
) -> Scan:
    """A scan from the content of a PLY or PCD file: where the points are, and their colours.

    Points that are not finite, and those at exactly (0, 0, 0), where many scanners put pixels
    without a measurement, are dropped.

    Args:
        path: of the file, for messages.
        content: of the file, points in the scanner's frame.
        T_world_scanner: where the scanner was.
        unit: of the file: mm, m or inch.
        key: which gives the unit, for messages.

    Raises:
        FileError: neither a PLY nor a PCD file, cut off, without points, or of another unit.
    """
    if unit not in UNITS:
        raise FileError(path, FileProblem.UNIT(unit=repr(unit), known=UNITS))
    rows = _rows(path, content)
    with np.errstate(over="ignore", invalid="ignore"):
        points = rows.points * UNITS[unit]
    measured = _select_measured(path, points)
    points = points[measured]
    _check_distance(path, points, unit, key)
    pixels = None
    if rows.resolution is not None:
        pixels = _pixels(path, rows, rows.resolution)[measured]
        if len(np.unique(pixels)) != len(pixels):
            raise FileError(path, "property pixel: two points claim the same pixel")
    colours = None if rows.colours is None else unless_all_alike(rows.colours[measured])
    return Scan(points, T_world_scanner, path.name, pixels, rows.resolution, colours=colours)


def points_of(path: Path, content: bytes) -> Floats:
    """The points (n, 3) of a PLY or PCD file, whatever their unit and axes.

    Raises:
        FileError: as `parse_cloud` has it, except for the unit.
    """
    points = _rows(path, content).points
    return np.array(points[_select_measured(path, points)], dtype=np.float64)


def _select_measured(path: Path, points: Floats) -> Bools:
    """Which points (n,) were measured, some at least."""
    measured: Bools = np.asarray(np.isfinite(points).all(axis=1) & points.any(axis=1))
    if not measured.any():
        raise FileError(path, FileProblem.EMPTY(count=len(points)))
    return measured


class Rows(NamedTuple):
    """The points of a file.

    `points` (n, 3) are in the file's unit.  Optional are `pixels` (n,) with the image size
    `resolution`, and `colours` (n, 3), 0..255.
    """

    points: Floats
    pixels: Floats | None
    resolution: tuple[int, int] | None
    colours: np.ndarray | None


def _rows(path: Path, content: bytes) -> Rows:
    if content[:3] == b"ply":
        return _ply(path, content)
    if b"FIELDS" not in content[:1024].upper():
        raise FileError(path, FileProblem.NO_CLOUD())
    points, resolution, colours = read_pcd(path, content, MOST_POINTS)
    return Rows(points, None, resolution, colours)


def _ply(path: Path, content: bytes) -> Rows:
    header = read_header(path, content)
    if header.count > MOST_POINTS:
        raise FileError(path, FileProblem.POINTS(count=header.count, most=MOST_POINTS))
    if header.count == 0:
        raise FileError(path, "is an empty cloud: it declares 0 points")
    has_pixels = "pixel" in header.names
    kinds = dict(header.properties)
    painted = {kinds[name] for name in CHANNELS if name in kinds}
    has_colours = len(painted) == 1 and set(CHANNELS) <= kinds.keys()
    names = (
        *("x", "y", "z"),
        *(CHANNELS if has_colours else ()),
        *(("pixel",) if has_pixels else ()),
    )
    columns = _ascii if header.encoding == "ascii" else _binary
    values, resolution = columns(path, content, header, names), _resolution(path, header.notes)
    points = values[:, :3]
    camera = camera_of(path, content, header)
    if camera is not None:
        points = camera.move_to_camera(points)
        resolution = resolution or camera.resolution
    return Rows(
        points,
        values[:, -1] if has_pixels else None,
        resolution,
        of_channels(values[:, 3:6], painted.pop()) if has_colours else None,
    )


def write_cloud(path: str | Path, scan: Scan, *, unit: str = "m", axes: str = Z_FORWARD) -> None:
    """Write the points of a scan in its own frame, or other axes of it, and a unit, binary.

    In metres no digit is lost.

    Raises:
        FileError: the file cannot be written.
    """
    fields = [("x", "<f8"), ("y", "<f8"), ("z", "<f8")]
    frame = "world" if axes == IN_WORLD else "scanner"
    header = ["ply", "format binary_little_endian 1.0", f"comment {unit}, {frame} frame"]
    if scan.resolution is not None and scan.pixels is not None:
        fields.append(("pixel", "<i4"))
        header.append("obj_info resolution {} {}".format(*scan.resolution))
    header.append(f"element vertex {len(scan.points)}")
    if scan.colours is not None:
        fields += [(name, "u1") for name in CHANNELS]
    header += [f"property {PLY_TYPES[kind]} {name}" for name, kind in fields]
    header.append("end_header\n")
    T = scan.T_world_scanner
    if axes == IN_WORLD:
        points = transform(T, scan.points)
    else:
        points = scan.points @ np.array(CLOUD_AXES[axes], dtype=float)
    rows: Any = np.empty(len(points), dtype=fields)
    for column, name in enumerate("xyz"):
        rows[name] = points[:, column] / UNITS[unit]
    if "pixel" in (rows.dtype.names or ()):
        rows["pixel"] = scan.pixels
    if scan.colours is not None:
        for name, column in zip(CHANNELS, scan.colours.T, strict=True):
            rows[name] = column
    write_whole(Path(path), "\n".join(header).encode("ascii") + rows.tobytes())


def _binary(path: Path, content: bytes, header: PlyHeader, names: tuple[str, ...]) -> Floats:
    order = "<" if header.encoding == "binary_little_endian" else ">"
    layout = np.dtype([(name, order + kind) for name, kind in header.properties])
    start = header.end + header.skip_bytes
    room = max(len(content) - start, 0) // layout.itemsize
    if room < header.count:
        detail = f"it declares {header.count} points and holds {room}"
        raise FileError(path, FileProblem.CUT_OFF(detail=detail))
    rows = np.frombuffer(content, layout, header.count, start)
    with np.errstate(invalid="ignore"):  # a NaN of the signalling kind, which is dropped later
        return np.column_stack([rows[name].astype(np.float64) for name in names])


def _ascii(path: Path, content: bytes, header: PlyHeader, names: tuple[str, ...]) -> Floats:
    columns = [header.names.index(name) for name in names]
    skip, count = header.skip_lines, header.count
    return read_rows(path, content, header.end, columns=columns, count=count, skip=skip)


def _check_distance(path: Path, points: Floats, unit: str, key: str) -> None:
    reach = float(np.abs(points).max())
    if not NEAREST_POINT <= reach <= FARTHEST_POINT:
        raise FileError(
            path,
            FileProblem.FAR(
                reach=f"{reach:.4g}",
                unit=f"{unit}{key and f' ({key})'}",
                near=f"{NEAREST_POINT:g}",
                far=f"{FARTHEST_POINT:g}",
                units=UNITS,
            ),
        )


def _resolution(path: Path, notes: tuple[str, ...]) -> tuple[int, int] | None:
    for note in notes:
        if note.startswith("resolution"):
            found = _RESOLUTION.fullmatch(note)
            if found is None:
                raise FileError(path, f"obj_info {quote(note)}: expected `resolution columns rows`")
            columns, rows = int(found[1]), int(found[2])
            if not 0 < columns * rows <= MOST_PIXELS:
                raise FileError(path, f"obj_info {note}: this is no size of an image")
            return columns, rows
    return None


def _pixels(path: Path, rows: Rows, resolution: tuple[int, int]) -> Floats:
    """Each point's pixel, shape (n,), whole numbers within the image."""
    size = resolution[0] * resolution[1]
    count = len(rows.points)
    if rows.pixels is not None:
        pixels = rows.pixels
    elif count == size:
        pixels = np.arange(size, dtype=np.float64)
    else:
        raise FileError(
            path,
            f"has a resolution of {resolution[0]} x {resolution[1]}, no property pixel, and "
            f"{count} points; one point for each pixel is expected then",
        )
    wrong = ~((pixels >= 0) & (pixels < size) & (np.floor(pixels) == pixels))
    if wrong.any():
        raise FileError(
            path, f"property pixel: {pixels[wrong][0]:g} is not a whole number below {size}"
        )
    return pixels
