"""A lower bound of a plan's cycle time: that of the same parts without obstacles.

Between two stops of an arm each joint passes the ends of the linear motions.  It is never quicker
than alone, straight, at its limits of speed, acceleration and, where the cell states it, jerk.  For
the bound an arm stops only at the part, at the place and at home, and never waits for another.
"""

from collections.abc import Mapping, Sequence
from itertools import product

import numpy as np

from workbench.model.candidate import Pick
from workbench.model.geometry import Floats
from workbench.model.motion import LEG_NAMES
from workbench.model.plan import Plan
from workbench.planning.collision.world import World
from workbench.planning.kinematics.quickness import Pace
from workbench.planning.picking.put_down import home_of

STOPS = (0, 2, 5)
"""The legs before which an arm stands still: at home, at the part, and at the place."""


def least_cycle(world: World, plan: Plan, picks: Sequence[Pick]) -> float:
    """What no plan for the same parts can be quicker than [s], by any of the picks or as planned.

    Args:
        world: of the cell and the detections that the picks were made from.
        plan: whose parts are to be taken.
        picks: ways to take them, with any arm; those of other parts are left out.
    """
    parts = [arm_plan.detection for arm_plan in plan.arms]
    ways: dict[tuple[str, int], list[Floats]] = {}
    for arm_plan in plan.arms:
        ends = [arm_plan.legs[0].q[0], *(leg.q[-1] for leg in arm_plan.legs)]
        ways.setdefault((arm_plan.arm, arm_plan.detection), []).append(np.stack(ends))
    for pick in picks:
        if pick.candidate.detection in parts:
            arm = pick.candidate.arm
            home = home_of(world, world.arm(arm))
            ends = [home, pick.approach[0], pick.q_grasp, pick.extract[-1], *pick.place[[0, -1]]]
            ways.setdefault((arm, pick.candidate.detection), []).append(np.stack([*ends, home]))
    alone: dict[tuple[str, int], float] = {}
    for (name, part), some in ways.items():
        arm = world.arm(name)
        velocity = world.cell.robot.limits(arm.joints)[2] * world.policy.speed
        times = least_seconds(np.stack(some), velocity, arm.acceleration, arm.jerk)
        alone[name, part] = float(times.min())
    return share_work(alone, parts)


def least_seconds(
    ends: Floats, velocity: Floats, acceleration: Floats, jerk: Floats | None = None
) -> Floats:
    """What each of several ways takes at least (k,) [s].

    Args:
        ends: where the legs of a way begin and end (k, legs + 1, n) [rad], home first and last.
        velocity: largest joint speeds (n,) [rad/s], already scaled.
        acceleration: largest joint accelerations (n,) [rad/s2].
        jerk: largest joint jerks (n,) [rad/s3], where acceleration may not jump.
    """
    assert ends.shape[1] == len(LEG_NAMES) + 1
    far = np.add.reduceat(np.abs(np.diff(ends, axis=1)), STOPS, axis=1)
    return Pace(velocity, acceleration, jerk).seconds(far).sum(axis=1)


def share_work(alone: Mapping[tuple[str, int], float], parts: Sequence[int]) -> float:
    """What the busiest arm has to do at least [s], the parts being given to arms as is best.

    Args:
        alone: (arm, part) -> [s] that the arm takes for it; what is left out cannot be.
        parts: each of which an arm takes.

    Raises:
        ValueError: a part that no arm takes.
    """
    arms = {part: [arm for arm, other in alone if other == part] for part in parts}
    return min(
        max(
            sum(alone[arm, part] for arm, part in zip(chosen, parts, strict=True) if arm == busy)
            for busy in chosen
        )
        for chosen in product(*(arms[part] for part in parts))
    )
