"""What recorded scans say of the scanner since its calibration, in sentences for people."""

import numpy as np

from workbench.app.calibration.calibration import bin_corners
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.perception.calibration.drift import FEWEST, PARTS
from workbench.perception.calibration.refinement import Drift
from workbench.perception.calibration.sureness import point_errors


def drift_words(cell: Cell, drift: Drift) -> tuple[str, ...]:
    """All of it, what matters most first.

    Args:
        cell: that it was told of.
        drift: what is to be said.
    """
    says: list[str] = []
    for course in drift.courses:
        moved, noise = (at_corners(cell, value) for value in (course.change, course.deviation))
        if course.thing in drift.drifted and course.kind == "fixture":
            says.append(
                f"the scanner has drifted since its calibration, as {course.thing} shows: "
                f"what lies at the corners of the bin is seen {moved:.2f} mm further off "
                f"(days by themselves differ by {noise:.2f} mm)"
            )
        if course.kind == "bin" and drift.is_bin_off:
            says.append(
                f"the bin is seen {moved:.2f} mm from where it was in the first days (days by "
                f"themselves differ by {noise:.2f} mm), and nothing else says that the scanner "
                "was moved: look which of the two it was"
            )
    if PARTS in drift.drifted:
        says.append(
            f"parts that the robot has put down, {drift.parts}, are seen elsewhere than it has put "
            "them, by more than the calibration leaves open"
        )
    days = max((len(course.days) for course in drift.courses), default=0)
    if days < 2 * FEWEST:
        says.append(f"there are scans of {days} days, {2 * FEWEST} are needed to compare them")
    elif not says:
        says.append(f"no drift shows in {days} days")
    if drift.open and days >= 2 * FEWEST:
        says.append(
            f"nothing but the bin tells {', '.join(drift.open)} (shifts along axes, turns about "
            "them): fixtures in view, or parts put down there and turned, would"
        )
    if drift.moved is not None and drift.covariance is not None:
        middle = cell.bin.T_world_bin.translation
        corners = np.array(list(bin_corners(cell.bin).values()))
        sure = point_errors(drift.covariance, middle, corners).max() * 1000
        moved = at_corners(cell, drift.moved)
        says.append(
            f"with the scanner moved by {moved:.2f} mm, as the corners of "
            f"the bin see it, what lies there is seen to {sure:.2f} mm or better (95 %)"
        )
    return tuple(says)


def at_corners(cell: Cell, motion: Floats) -> float:
    """How far a motion (6,) [m, rad] at the bin's middle moves its farthest corner [mm].

    Where it is NaN nothing moves.
    """
    arms = np.array(list(bin_corners(cell.bin).values())) - cell.bin.T_world_bin.translation
    shift, turn = np.nan_to_num(motion[:3]), np.nan_to_num(motion[3:])
    return float(np.linalg.norm(shift + np.cross(turn, arms), axis=1).max()) * 1000
