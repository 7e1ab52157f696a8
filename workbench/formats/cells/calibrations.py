"""Calibrations in files: the record in a cell file, and a folder of scans with joint values."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

from workbench.formats.files.change_log import utc
from workbench.formats.files.toml_documents import numbers, text
from workbench.formats.files.toml_keys import Table, read_toml
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import is_file, write_whole
from workbench.model.calibration import BallPlate, CalibrationRecord
from workbench.model.cell import Arm, Cell
from workbench.model.derived.controller_axes import from_shown, shown_axes
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, own

POSES_FORMAT = "workbench-calibration/1"
CALIBRATION_FILE = "calibration.toml"

MOST_POSES = 60

MOST_SHOWN = 10_000.0
"""[deg, mm] Of an axis; offsets and couplings add to its limits, which are checked after."""

UPPER = np.triu_indices(6)

FILE_UNITS = np.array([0.001] * 3 + [np.pi / 180] * 3)
"""Millimetres and degrees, in metres and radians."""


@dataclass(frozen=True, slots=True, eq=False)
class ScannedPose:
    """A scan in a file and the arm's configuration `q` (n,) [rad], chain order."""

    scan: Path
    q: Floats

    def __post_init__(self) -> None:
        own(self, "q")


@dataclass(frozen=True, slots=True, eq=False)
class ScannedPoses:
    """What a folder of a calibration holds; `unit` is that of the scans."""

    arm: str
    plate: BallPlate
    unit: str
    poses: tuple[ScannedPose, ...]


def read_record(table: Table) -> CalibrationRecord:
    """The table `[scanner.calibration]` of a cell file: `at`, `by`, `poses`, `rms_mm`.

    And, where it says how sure it is, `sure_mm`, `sure_deg` and `covariance`: the upper triangle,
    row by row, of shifts x, y, z [mm] and turns about x, y, z [deg] along the world's axes.
    """
    text = table.text("at")
    try:
        at = datetime.fromisoformat(text)
    except ValueError:
        raise table.error("at", f"{text!r} is no time such as 2026-01-31T12:00:00Z") from None
    mm = table.number("sure_mm", 0.0, low=0, high=1000) if table.has("sure_mm") else None
    degrees = table.number("sure_deg", 0.0, low=0, high=180) if table.has("sure_deg") else None
    record = CalibrationRecord(
        float(round((at if at.tzinfo else at.replace(tzinfo=UTC)).timestamp())),
        table.text("by"),
        table.whole("poses", low=1, high=MOST_POSES),
        table.number("rms_mm", low=0, high=100) / 1000,
        None if mm is None else mm / 1000,
        None if degrees is None else float(np.deg2rad(degrees)),
        _covariance(table) if table.has("covariance") else None,
    )
    table.finish()
    return record


def _covariance(table: Table) -> Floats:
    given = np.zeros((6, 6))
    given[UPPER] = table.numbers("covariance", 21, low=-1e6, high=1e6)
    found = given + np.triu(given, 1).T
    deviations = np.sqrt(np.maximum(np.diag(found), 1e-12))
    # As correlations, since millimetres and degrees are of different size.
    if np.linalg.eigvalsh(found / np.outer(deviations, deviations))[0] < -1e-6:
        raise table.error("covariance", "is none: along some direction its variance is below zero")
    return found * np.outer(FILE_UNITS, FILE_UNITS)


def record_table(record: CalibrationRecord) -> dict[str, str | int | float | list[float]]:
    """What `read_record` reads."""
    rms = round(record.rms * 1000, 4)
    table: dict[str, str | int | float | list[float]] = {
        "at": utc(record.at),
        "by": record.by,
        "poses": record.poses,
        "rms_mm": rms,
    }
    if record.position_error is not None:
        table["sure_mm"] = round(record.position_error * 1000, 4)
    if record.angle_error is not None:
        table["sure_deg"] = round(float(np.rad2deg(record.angle_error)), 5)
    if record.covariance is not None:
        table["covariance"] = _covariance_numbers(record.covariance)
    return table


def _covariance_numbers(covariance: Floats) -> list[float]:
    """The 21 numbers of `covariance` in files, of one (6, 6) [m, rad]."""
    shown = covariance / np.outer(FILE_UNITS, FILE_UNITS)
    return [float(f"{value:.9g}") for value in shown[UPPER]]


def read_scanned_poses(folder: Path, cell: Cell) -> ScannedPoses:
    """The poses that `calibration.toml` in a folder lists; the scans are not read yet.

    Args:
        folder: holds `calibration.toml` with `format`, `arm` and `unit` of the scans (default:
            that of the cell's scanner).  A table `[plate]` has `ball_mm` (diameter), `sides_mm`
            (balls 1 to 2, 2 to 3, 3 to 1) and `stands` (whether no arm holds it).  Each pose has a
            table `[[pose]]`: `scan` is a file in this folder, `joints_deg` are in the
            controller's order and sense.
        cell: the cell of the arm, which holds the plate or carries the scanner.

    Raises:
        FileError: names file, key, value and what was expected.
    """
    table = read_toml(folder / CALIBRATION_FILE)
    table.text("format", among=(POSES_FORMAT,))
    carrier = cell.scanner.on_arm
    arms = tuple(arm.name for arm in cell.arms) if carrier is None else (carrier.arm,)
    arm = cell.arm(table.text("arm", among=arms))
    unit = table.text("unit", cell.scanner.unit, among=tuple(UNITS))
    plate = _plate(table.table("plate"), stands=carrier is not None)
    poses = tuple(_pose(pose, cell, arm) for pose in table.tables("pose"))
    if not 1 <= len(poses) <= MOST_POSES:
        raise table.error("pose", f"1 to {MOST_POSES} poses are expected, {len(poses)} are given")
    table.finish()
    return ScannedPoses(arm.name, plate, unit, poses)


def _plate(table: Table, *, stands: bool) -> BallPlate:
    if table.flag("stands", False) != stands:
        problem = (
            "an arm carries the scanner of this cell; stands = true is expected, and scans of a "
            "plate that no arm holds"
            if stands
            else "the scanner of this cell stands; scans of a plate that an arm holds are expected"
        )
        raise table.error("stands", problem)
    radius = table.number("ball_mm", low=4, high=400) / 2000
    sides = table.numbers("sides_mm", 3, low=4, high=2000) / 1000
    table.finish()
    try:
        return BallPlate(radius, sides)
    except InputError as error:
        raise table.error("sides_mm", str(error)) from None


def _pose(table: Table, cell: Cell, arm: Arm) -> ScannedPose:
    name = table.text("scan")
    scan = table.path.parent / name
    if not is_file(scan):
        raise table.error("scan", f"there is no file {name!r} in the folder of {CALIBRATION_FILE}")
    count = len(arm.joints)
    shown = table.numbers("joints_deg", count, low=-MOST_SHOWN, high=MOST_SHOWN)
    table.finish()
    q = from_shown(cell, arm, shown)
    lower, upper, _ = cell.robot.limits(arm.joints)
    if not np.all((q >= lower - 1e-3) & (q <= upper + 1e-3)):
        raise table.error("joints_deg", f"lies outside the limits of the {arm.name} arm")
    return ScannedPose(scan, q)


def write_scanned_poses(
    folder: Path, cell: Cell, arm: Arm, plate: BallPlate, poses: Sequence[ScannedPose]
) -> None:
    """Write `calibration.toml` for scans in metres that lie in the folder.

    Raises:
        FileError: it cannot be written.
    """
    sides = numbers(np.array(plate.sides) * 1000, 4)
    lines = [
        "# Scans of the reference plate, and where the arm stood for each.",
        f'format = "{POSES_FORMAT}"',
        f'arm = "{arm.name}"',
        'unit = "m"                # of the scans',
        "",
        "[plate]                   # three balls; any frame that holds them will do",
        f"ball_mm = {plate.radius * 2000:.10g}",
        f"sides_mm = {sides}   # 1 to 2, 2 to 3, 3 to 1: centres",
    ]
    if cell.scanner.on_arm is not None:
        lines.append("stands = true             # no arm holds it")
    for pose in poses:
        shown = numbers(shown_axes(cell, arm, pose.q), 4)
        lines += ["", "[[pose]]", f"scan = {text(pose.scan.name)}", f"joints_deg = {shown}"]
    write_whole(folder / CALIBRATION_FILE, ("\n".join(lines) + "\n").encode())
