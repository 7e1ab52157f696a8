"""What recorded sessions say of the scanner's pose since it was calibrated, and the cell by it."""

from collections.abc import Iterator, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.app.core.command import Entry
from workbench.app.core.cycle.sending import LinkEnded
from workbench.app.core.state import State
from workbench.app.picking.pallets import at_rest
from workbench.app.records.replay import replay
from workbench.app.records.session_archive import open_journal
from workbench.app.records.sessions import cell_of
from workbench.model.calibration import CalibrationRecord
from workbench.model.cell import Cell
from workbench.model.derived.by_view import scans_by_view
from workbench.model.derived.scanner_poses import with_calibrated_scanner
from workbench.model.digest import digest_of
from workbench.model.errors import InputError, JournalError
from workbench.model.geometry import Floats
from workbench.model.scan import Detection
from workbench.perception.calibration.refinement import Drift, drift_of
from workbench.perception.calibration.things import (
    PutPart,
    ThingSighting,
    motion_of,
    moved_to,
    put_slopes,
    sight_things,
)
from workbench.planning.placing.budget import kept_by_grip
from workbench.planning.placing.sources import calibration_error
from workbench.plugins.progress import Report

CHECK_EVERY = 3600.0
"""[s] Scans that show no new part are checked so rarely: days count, not scans."""


@dataclass(frozen=True, slots=True, eq=False)
class RecordedDrift:
    """The `drift`, of how many `sessions` and `scans`, and `problems` of sessions left out."""

    drift: Drift
    sessions: int
    scans: int
    problems: tuple[str, ...]


def recorded_drift(folders: Sequence[Path], cell: Cell, report: Report) -> RecordedDrift:
    """What sessions say of the scanner of a cell.

    Counted are scans since its calibration that were taken while bin, fixtures and scanner stood in
    the cell where they stand in it now: what was moved there begins anew.  Of a scanner on an arm
    those from the chosen view count, where the robot may have drifted as well.

    Args:
        folders: of the sessions.
        cell: as it is now.
        report: called with the progress.

    Raises:
        InputError: the scanner was never calibrated, or a folder holds no session.
    """
    record = _record(cell)
    sightings: list[ThingSighting] = []
    problems: list[str] = []
    sessions = scans = 0
    for number, folder in enumerate(folders):
        report(number / len(folders), folder.name)
        try:
            with closing(open_journal(folder)) as journal:
                began_with = cell_of(journal)
                if began_with.name != cell.name:
                    continue
                found = list(of_session(replay(journal, began_with), cell, record.at))
        except JournalError as error:
            problems.append(f"{folder.name}: {error}")
            continue
        sessions, scans = sessions + 1, scans + len(found)
        sightings += [sighting for scan in found for sighting in scan]
    middle = cell.bin.T_world_bin.translation
    prior = calibration_error(cell.scanner, Detection("", pin.SE3(np.eye(3), middle)))
    distance = float(np.linalg.norm(cell.scanner.T_world_scanner.translation - middle))
    drift = drift_of(sightings, prior, distance)
    return RecordedDrift(drift, sessions, scans, tuple(problems))


def refined_cell(cell: Cell, drift: Drift, at: float, by: str) -> Cell:
    """The cell with the scanner pose that calibration, drift and placed parts give together.

    Args:
        cell: the cell of the recorded scans.
        drift: see `recorded_drift`.
        at: time of the change [s since the epoch].
        by: the person who accepts it.

    Raises:
        InputError: no record shows that the scanner has moved.
    """
    if drift.moved is None or drift.covariance is None:
        raise InputError("nothing recorded says that the scanner hangs elsewhere")
    middle = cell.bin.T_world_bin.translation
    T = motion_of(drift.moved, middle) * cell.scanner.T_world_scanner
    to_scanner = moved_to(T.translation - middle)
    covariance = to_scanner @ drift.covariance @ to_scanner.T
    record = replace(
        _record(cell),
        at=float(round(at)),
        by=by,
        position_error=_largest(covariance[:3, :3]),
        angle_error=_largest(covariance[3:, 3:]),
        covariance=covariance,
    )
    return with_calibrated_scanner(cell, T, record)


def _record(cell: Cell) -> CalibrationRecord:
    record = cell.scanner.calibration
    if record is None:
        raise InputError(
            f"cell {cell.name}: the scanner was never calibrated; drift is told since a calibration"
        )
    return record


def _largest(covariance: Floats) -> float:
    """Deviation in the direction of most."""
    return float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))


def of_session(
    states: Iterator[tuple[Entry, State]], cell: Cell, since: float
) -> Iterator[list[ThingSighting]]:
    """What each scan that counts shows.

    Args:
        states: of a session, as `replay` gives them.
        cell: as it is now.
        since: [s since the epoch] when its scanner was calibrated.
    """
    layout, before = _layout(cell), None
    parts = {part.name for part in cell.parts}
    kept: dict[bytes, Floats] = {}
    seen: set[bytes] = set()
    last = -np.inf
    for entry, state in states:
        if before is not None and isinstance(entry.command, LinkEnded):
            kept |= _errors_in_hands(before)
        is_new = state.scan is not None and (before is None or state.scan is not before.scan)
        before = state
        if state.scan is None or not is_new or entry.at <= since or _layout(state.cell) != layout:
            continue
        stands = [
            (detection, T, _key(detection.T_world_found))
            for detection, T in zip(state.placed, at_rest(state.cell, state.placed), strict=True)
            if detection.score > 0
            and detection.T_world_found is not None
            and detection.part in parts
        ]
        fresh = [stand for stand in stands if stand[2] in kept and stand[2] not in seen]
        if not fresh and entry.at - last < CHECK_EVERY:
            continue
        last = entry.at
        put_down = [_put_part(cell, *stand[:2], kept[stand[2]]) for stand in fresh]
        seen |= {stand[2] for stand in fresh}
        # Of a merged one what the view has seen that the scanner is at.
        yield sight_things(cell, scans_by_view(state.scan)[-1], put_down, at=entry.at)


def _layout(cell: Cell) -> str:
    return digest_of((cell.bin, cell.fixtures, cell.scanner.T_world_scanner))


def _key(T: pin.SE3 | None) -> bytes:
    """A part by where it was found."""
    return b"" if T is None else np.round(T.homogeneous, 9).tobytes()


def _errors_in_hands(state: State) -> dict[bytes, Floats]:
    """What the hands keep of the errors of the parts of the plan that has just ended.

    Not of parts that come from a station: there two grips have taken something out.
    """
    if state.plan is None:
        return {}
    found = [(arm, state.plan.detections[arm.detection]) for arm in state.plan.picks]
    return {
        _key(part.T_world_part): kept_by_grip(
            state.cell, detection.arm, part.part, part.T_world_part, detection.T_tcp_part.inverse()
        )
        for detection, part in found
        if part.roll_known and part.T_world_found is None
    }


def _put_part(cell: Cell, detection: Detection, T_world_rest: pin.SE3, keeps: Floats) -> PutPart:
    assert detection.T_world_found is not None
    middle = cell.bin.T_world_bin.translation
    slopes = put_slopes(middle, detection.T_world_found, detection.T_world_part, keeps)
    return PutPart(replace(detection, T_world_part=T_world_rest), slopes)
