"""Straight lines of the TCP, as configurations that follow them without jumping."""

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.planning.kinematics.chain import Chain, is_solution

LARGEST_STEP = 0.6
"""[rad] Between two points of a straight leg no joint may turn further: that would be a flip."""


def pose_on_line(T_a: pin.SE3, T_b: pin.SE3, share: float) -> pin.SE3:
    """The pose at `share` 0..1 of the way: position straight, rotation about one fixed axis."""
    R = T_a.rotation @ pin.exp3(share * pin.log3(T_a.rotation.T @ T_b.rotation))
    return pin.SE3(R, (1 - share) * T_a.translation + share * T_b.translation)


def follow(
    chain: Chain, q_start: Floats, T_world_end: pin.SE3, points: int
) -> tuple[Floats, float]:
    """Configurations along the straight line from where `q_start` (n,) is to `T_world_end`.

    Returns:
        Configurations (m, n) [rad], first `q_start`, and the share of the line that was followed:
        1.0 and m = `points` when all of it was.
    """
    T_start = chain.pose(q_start)
    path = [np.asarray(q_start)]
    for k in range(1, points):
        share = k / (points - 1)
        T = pose_on_line(T_start, T_world_end, share)
        answers, residuals = chain.solve(T, path[-1][None], iterations=30)
        if not is_solution(residuals)[0] or np.abs(answers[0] - path[-1]).max() > LARGEST_STEP:
            return np.array(path), (k - 1) / (points - 1)
        path.append(answers[0])
    return np.array(path), 1.0
