"""The reduction of errors by one more pose of the plate."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.perception.calibration.plate_poses import Answer, PlatePose
from workbench.perception.calibration.sureness import best_fit, point_errors, weighed_slopes


def errors_with(
    poses: Sequence[PlatePose],
    answer: Answer,
    centres: Floats,
    Ts_world_flange: Sequence[pin.SE3],
    points: Floats,
) -> tuple[float, Floats]:
    """The largest of the errors of points as it is, and as it were with each pose of the flange.

    The errors of shifts and turns are taken as those of the poses before.

    Args:
        poses: that are used, of one arm.
        answer: their calibration's.
        centres: (3, 3) [m] of the balls in the plate's frame.
        Ts_world_flange: one more pose each, n of them.
        points: (k, 3) [m] in the world that matter, the corners of the bin.

    Returns:
        [m], and (n,) [m].
    """
    fit = best_fit(poses, answer, centres)
    X, Y = fit.answer
    origin = X.translation
    found: list[float] = []
    for T in Ts_world_flange:
        T_scanner_plate = X.actInv(T * Y)
        balls = centres @ T_scanner_plate.rotation.T + T_scanner_plate.translation
        rows = weighed_slopes(PlatePose("", T, balls, at=poses[0].at), fit, centres)
        found.append(float(point_errors(fit.covariance_with(rows), origin, points).max()))
    now = float(point_errors(fit.covariance, origin, points).max())
    return now, np.array(found)
