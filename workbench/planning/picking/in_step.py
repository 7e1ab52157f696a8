"""Two arms as one: a motion of all joints that the controller has to run in step."""

from dataclasses import replace

import numpy as np

from workbench.model.candidate import Verdict
from workbench.model.geometry import Floats
from workbench.model.plan import ArmPlan, Leg, LegName
from workbench.planning.collision.legs import lead_of
from workbench.planning.collision.motion import walked
from workbench.planning.collision.world import World
from workbench.planning.kinematics.execution import timed
from workbench.planning.kinematics.quickness import Pace, pace_of
from workbench.planning.picking.route import MOTIONS
from workbench.planning.picking.search import curve_check, joint_weights, onward

ITERATIONS = 100
"""Of the search: the space of all joints is larger, and looks cost more in it."""


def in_step(
    world: World, plans: tuple[ArmPlan, ArmPlan], name: LegName, rng: np.random.Generator
) -> tuple[Leg, Leg] | None:
    """The leg `name` of both arms as one motion, in the phase that the world is in.

    Straight legs stay as they are; they must have as many waypoints.

    Returns:
        Both legs with the same times, or None when there is no such motion.
    """
    legs = (plans[0].leg(name), plans[1].leg(name))
    columns = np.concatenate([world.kinematics.columns[plan.arm] for plan in plans])
    base, policy = world.configuration({}), world.policy
    check = curve_check(world, columns, base)

    start, goal = (np.concatenate([leg.q[k] for leg in legs]) for k in (0, -1))
    for q in (start, goal):
        whole = base.copy()
        whole[columns] = q
        if world.contact(whole) is not None:
            return None
    lead = np.hstack([lead_of(leg, policy.straight_points) for leg in legs])
    if len(lead) > 1 and check(walked(lead, world.motion, policy.zone)) is not None:
        return None
    if MOTIONS[name] == "joint":
        chains = [world.chains[plan.arm] for plan in plans]
        limits = (
            np.concatenate([chain.lower for chain in chains]),
            np.concatenate([chain.upper for chain in chains]),
        )
        weights = np.concatenate([joint_weights(len(plan.joints), policy) for plan in plans])
        fewer = replace(policy, iterations=min(policy.iterations, ITERATIONS))
        with world.at_full_margins():
            path = onward(
                lead,
                goal,
                limits,
                weights,
                check,
                fewer,
                world.motion,
                rng,
                world.deadline,
                pace=_pace(world, plans),
            )
        if isinstance(path, Verdict):
            return None
    else:
        if len(legs[0].q) != len(legs[1].q):
            return None
        path = np.hstack([legs[0].q, legs[1].q])
        if check(walked(path, world.motion, policy.zone)) is not None:
            return None
    return _timed(world, plans, legs, path)


def _pace(world: World, plans: tuple[ArmPlan, ArmPlan]) -> Pace:
    """That of all joints."""
    paces = [pace_of(world.chains[plan.arm], world.policy.speed) for plan in plans]
    velocity = np.concatenate([pace.velocity for pace in paces])
    return Pace(velocity, np.concatenate([pace.acceleration for pace in paces]))


def _timed(
    world: World, plans: tuple[ArmPlan, ArmPlan], legs: tuple[Leg, Leg], path: Floats
) -> tuple[Leg, Leg]:
    pace = _pace(world, plans)
    times = timed(path, pace.velocity, pace.acceleration, world.policy.zone)
    count = len(plans[0].joints)
    return (
        replace(legs[0], q=path[:, :count], t=times),
        replace(legs[1], q=path[:, count:], t=times),
    )
