"""The other ways in which an arm with a spare axis holds its tool at the same place."""

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.planning.kinematics.chain import Chain, is_solution

JOINT_STEP = 0.1
"""[rad] From one configuration to the next, in joint space."""

MOST_STEPS = 40
"""Configurations to either side: more than any arm's limits allow at this step."""

NUDGE = 1e-6
"""[rad] By which joints are moved to see how the tool follows."""


def self_motion(chain: Chain, q: Floats) -> Floats:
    """Configurations with the tool where it is at `q` (n,) [rad], from one end to the other.

    Returns:
        Shape (m, n), `q` among them; `q` alone for an arm of six axes or fewer.
    """
    start = np.asarray(q)
    if len(start) <= 6:
        return start[None]
    T = chain.pose(start)
    forward = _follow(chain, T, start, _null(chain, start))
    back = _follow(chain, T, start, -_null(chain, start))
    return np.array([*back[::-1], start, *forward])


def _follow(chain: Chain, T: pin.SE3, q: Floats, direction: Floats) -> list[Floats]:
    found: list[Floats] = []
    while len(found) < MOST_STEPS:
        wanted = np.clip(q + JOINT_STEP * direction, chain.lower, chain.upper)
        answers, residuals = chain.solve(T, wanted[None], iterations=20)
        moved = answers[0] - q
        if not is_solution(residuals)[0] or moved @ direction < JOINT_STEP / 2:
            break
        q = answers[0]
        found.append(q)
        null = _null(chain, q)
        direction = null if null @ direction >= 0 else -null
    return found


def _null(chain: Chain, q: Floats) -> Floats:
    """The joint motion (n,) of unit length that leaves the tool where it is."""
    T = chain.pose(q)
    columns = [
        pin.log6(T.actInv(chain.pose(q + NUDGE * unit))).vector / NUDGE for unit in np.eye(len(q))
    ]
    return np.linalg.svd(np.array(columns).T)[2][-1]
