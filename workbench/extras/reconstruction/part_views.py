"""Scans of one part from known poses: a folder with the scans and `views.toml`."""

from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.clouds.scans import CLOUD_AXES, read_cloud, turned_to_camera
from workbench.formats.files.toml_keys import Table, read_toml
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import is_file
from workbench.model.cell import Z_FORWARD
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import Floats, frozen, pose_from_matrix, put
from workbench.model.scan import Scan

VIEWS_FORMAT = "workbench-views/1"
VIEWS_FILE = "views.toml"

FEWEST_SCANS, MOST_SCANS = 3, 200
"""Scans in a folder."""

LARGEST_COORDINATE = 10_000.0
"""[mm] Of any coordinate."""


@dataclass(frozen=True, slots=True, eq=False)
class PartViews:
    """Scans whose world is the model's frame: `T_world_scanner` is where each was taken from.

    `low` and `high` (3,) [m] bound the region in which the part is, and nothing else.
    """

    scans: tuple[Scan, ...]
    low: Floats
    high: Floats

    def __post_init__(self) -> None:
        put(self, low=frozen(self.low), high=frozen(self.high))


def read_views(folder: Path) -> PartViews:
    """The scans that `views.toml` in a folder lists, each with its pose.

    The file holds `format`, `low_mm` and `high_mm` of the region, `unit` and `axes` of the scans
    (default: m and z_forward).  Each scan has a table `[[scan]]` with `file` in the same folder.
    A table `[turntable]` states `axis` and `point_mm` in the scanner's frame; then each scan has
    `angle_deg`, the rotation of the table about its axis.  Without a turntable each scan has
    `T_model_scanner`, the 16 numbers of a matrix row by row, with its translation in millimetres.

    Raises:
        FileError: names file, key, value and what was expected.
    """
    if not is_file(folder / VIEWS_FILE):
        raise FileError(folder, f"holds no {VIEWS_FILE}, which says where each scan was taken from")
    table = read_toml(folder / VIEWS_FILE)
    table.text("format", among=(VIEWS_FORMAT,))
    unit = table.text("unit", "m", among=tuple(UNITS))
    axes = table.text("axes", Z_FORWARD, among=tuple(CLOUD_AXES))
    low, high = (
        table.numbers(key, 3, low=-LARGEST_COORDINATE, high=LARGEST_COORDINATE)
        for key in ("low_mm", "high_mm")
    )
    if not np.all(high > low):
        raise table.error("high_mm", "each number must be larger than that of low_mm")
    T_scanner_table = _turntable(table.table("turntable")) if table.has("turntable") else None
    listed = tuple(table.tables("scan"))
    if not FEWEST_SCANS <= len(listed) <= MOST_SCANS:
        raise table.error(
            "scan", f"{FEWEST_SCANS} to {MOST_SCANS} scans are expected, {len(listed)} are given"
        )
    placed = [_read_view(scan_table, T_scanner_table) for scan_table in listed]
    paths = [path for path, _ in placed]
    for path in paths:
        if paths.count(path) > 1:
            raise table.error("scan", f"{path.name!r} is listed more than once")
    table.finish()
    scans = tuple(
        replace(turned_to_camera(read_cloud(path, T, unit=unit), axes), source=path.name)
        for path, T in placed
    )
    return PartViews(scans, low / 1000, high / 1000)


def _turntable(table: Table) -> pin.SE3:
    """`T_scanner_table`: z along the axis, the origin at the point, x beside the scanner's x."""
    axis = table.numbers("axis", 3, low=-1e6, high=1e6)
    point = table.numbers("point_mm", 3, low=-LARGEST_COORDINATE, high=LARGEST_COORDINATE) / 1000
    table.finish()
    length = float(np.linalg.norm(axis))
    if length < 1e-6:
        raise table.error("axis", "is no direction: all its numbers are zero")
    z = axis / length
    # Of the scanner's axes that which is least along the turntable's keeps the frame well defined.
    beside = np.eye(3)[0 if abs(z[0]) < 0.9 else 1]
    x = beside - (beside @ z) * z
    x /= np.linalg.norm(x)
    return pin.SE3(np.stack([x, np.cross(z, x), z], axis=1), point)


def _read_view(table: Table, T_scanner_table: pin.SE3 | None) -> tuple[Path, pin.SE3]:
    """The file of a scan, and `T_model_scanner`."""
    name = table.text("file")
    path = table.path.parent / name
    if not is_file(path):
        raise table.error("file", f"there is no file {name!r} in the folder of {VIEWS_FILE}")
    if T_scanner_table is None:
        matrix = table.numbers("T_model_scanner", 16, low=-1e6, high=1e6).reshape(4, 4)
        matrix[:3, 3] /= 1000
        try:
            T_model_scanner = pose_from_matrix(matrix)
        except InputError as error:
            raise table.error("T_model_scanner", str(error)) from None
    else:
        angle = np.deg2rad(table.number("angle_deg", low=-3600, high=3600))
        turned = pin.SE3(pin.exp3(np.array([0.0, 0.0, angle])), np.zeros(3))
        T_model_scanner = (T_scanner_table * turned).inverse()
    table.finish()
    return path, T_model_scanner
