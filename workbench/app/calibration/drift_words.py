"""What recorded scans say of the scanner since its calibration, for people."""

import numpy as np

from workbench.app.calibration.calibration import bin_corners
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.messages.calibration import DriftText
from workbench.model.messages.message import Message
from workbench.perception.calibration.drift import FEWEST_DAYS, PARTS_LABEL
from workbench.perception.calibration.refinement import Drift
from workbench.perception.calibration.sureness import point_errors


def drift_words(cell: Cell, drift: Drift) -> tuple[Message, ...]:
    """All of it, what matters most first.

    Args:
        cell: whose scanner it is.
        drift: what the scans show.
    """
    says: list[Message] = []
    for course in drift.courses:
        moved, noise = (at_corners(cell, value) for value in (course.change, course.deviation))
        if course.thing in drift.drifted and course.kind == "fixture":
            drifted = DriftText.DRIFTED(thing=course.thing, moved=moved, noise=noise)
            says.append(drifted)
        if course.kind == "bin" and drift.is_bin_off:
            says.append(DriftText.BIN_MOVED(moved=moved, noise=noise))
    if PARTS_LABEL in drift.drifted:
        says.append(DriftText.PARTS_ELSEWHERE(count=drift.parts))
    days = max((len(course.days) for course in drift.courses), default=0)
    if days < 2 * FEWEST_DAYS:
        says.append(DriftText.TOO_FEW_DAYS(days=days, fewest=2 * FEWEST_DAYS))
    elif not says:
        says.append(DriftText.NONE(days=days))
    if drift.open and days >= 2 * FEWEST_DAYS:
        says.append(DriftText.OPEN(axes=drift.open))
    if drift.moved is not None and drift.covariance is not None:
        middle = cell.bin.T_world_bin.translation
        corners = np.array(list(bin_corners(cell.bin).values()))
        sure = point_errors(drift.covariance, middle, corners).max()
        moved = at_corners(cell, drift.moved)
        says.append(DriftText.CORRECTED(moved=moved, error=sure))
    return tuple(says)


def at_corners(cell: Cell, motion: Floats) -> float:
    """How far a motion (6,) [m, rad] at the bin's middle moves its farthest corner [m].

    Where it is NaN nothing moves.
    """
    arms = np.array(list(bin_corners(cell.bin).values())) - cell.bin.T_world_bin.translation
    shift, turn = np.nan_to_num(motion[:3]), np.nan_to_num(motion[3:])
    return float(np.linalg.norm(shift + np.cross(turn, arms), axis=1).max())
