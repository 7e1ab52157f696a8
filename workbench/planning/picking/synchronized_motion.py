"""Two arms as one: a motion of all joints that the controller has to run in step."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.model.candidate import Verdict
from workbench.model.derived.point_speeds import speeds_on
from workbench.model.geometry import Floats, Ints
from workbench.model.plan import ArmPlan, Leg, LegName
from workbench.planning.collision.legs import lead_of
from workbench.planning.collision.motion import RESOLUTION, bound_curves
from workbench.planning.collision.world import World
from workbench.planning.kinematics.execution import compute_times
from workbench.planning.kinematics.quickness import Pace, pace_of
from workbench.planning.kinematics.upright import Uprightness
from workbench.planning.picking.route import MOTIONS, hand_of, keep_upright
from workbench.planning.picking.search import PathQuery, curve_check, joint_weights, onward
from workbench.plugins.planner import Planner


def in_step(
    world: World, plans: tuple[ArmPlan, ArmPlan], name: LegName, rng: np.random.Generator
) -> tuple[Leg, Leg] | None:
    """The leg `name` of both arms as one motion, in the phase that the world is in.

    Straight legs stay as they are; they must have as many waypoints.

    Returns:
        Both legs with the same times, or None when there is no such motion.
    """
    legs = (plans[0].leg(name), plans[1].leg(name))
    arms = [plan.arm for plan in plans]
    columns, base, policy = columns_of(world, arms), world.configuration({}), world.policy
    check = curve_check(world, columns, base)

    start, goal = (np.concatenate([leg.q[k] for leg in legs]) for k in (0, -1))
    for q in (start, goal):
        whole = base.copy()
        whole[columns] = q
        if world.contact(whole) is not None:
            return None
    lead = np.hstack([lead_of(leg, policy.straight_points) for leg in legs])
    if len(lead) > 1 and check(bound_curves(lead, world.motion, policy.zone)) is not None:
        return None
    if MOTIONS[name] == "joint":
        with world.at_full_margins():
            upright = keep_upright(world, plans, name)
            path = way_in_step(world, arms, lead, goal, rng, upright=upright)
        if isinstance(path, Verdict):
            return None
    else:
        if len(legs[0].q) != len(legs[1].q):
            return None
        path = np.hstack([legs[0].q, legs[1].q])
        if check(bound_curves(path, world.motion, policy.zone)) is not None:
            return None
    return time_in_step(world, plans, legs, path)


def way_in_step(
    world: World,
    arms: Sequence[str],
    lead: Floats,
    goal: Floats,
    rng: np.random.Generator,
    *,
    planner: Planner | None = None,
    upright: Uprightness | None = None,
) -> Floats | Verdict:
    """A free motion of all joints of several arms, in the phase that the world is in; see `onward`.

    Args:
        world: that they are in.
        arms: their names, in the order of their joints in what follows.
        lead: waypoints (k, n) [rad] that it begins with.
        goal: where it ends (n,) [rad].
        rng: of everything random.
        planner: instead of the planner of the policy.
        upright: what keeps parts upright that they carry.
    """
    columns, base, policy = columns_of(world, arms), world.configuration({}), world.policy
    chains = [world.chains[arm] for arm in arms]
    query = PathQuery(
        curve_check(world, columns, base),
        (
            np.concatenate([chain.lower for chain in chains]),
            np.concatenate([chain.upper for chain in chains]),
        ),
        np.concatenate([joint_weights(len(chain.lower), policy) for chain in chains]),
        policy,
        world.motion,
        world.deadline,
        world.edges(columns, base, RESOLUTION),
        pace_in_step(world, arms),
        planner,
        upright,
    )
    return onward(query, lead, goal, rng)


def columns_of(world: World, arms: Sequence[str]) -> Ints:
    """Indices (n,) of the joints of several arms in the whole configuration."""
    return np.concatenate([world.kinematics.columns[arm] for arm in arms])


def pace_in_step(world: World, arms: Sequence[str]) -> Pace:
    """The pace of all joints of several arms.

    If only one arm has limits of jerk, those of the other are infinite.
    """
    paces = [pace_of(world.chains[arm], world.policy.speed) for arm in arms]
    jerks = [np.full_like(p.velocity, np.inf) if p.jerk is None else p.jerk for p in paces]
    return Pace(
        np.concatenate([pace.velocity for pace in paces]),
        np.concatenate([pace.acceleration for pace in paces]),
        np.concatenate(jerks) if any(pace.jerk is not None for pace in paces) else None,
    )


def time_in_step(
    world: World, plans: tuple[ArmPlan, ArmPlan], legs: tuple[Leg, Leg], path: Floats
) -> tuple[Leg, Leg]:
    """Both legs along a path (m, n) [rad] of the joints of both arms, with its timing."""
    pace = pace_in_step(world, [plan.arm for plan in plans])
    count = len(plans[0].joints)
    points = [
        speeds_on(world.cell, world.arm(plan.arm), leg.holding, leg.opening, hand_of(world, plan))
        for plan, leg in zip(plans, legs, strict=True)
    ]

    def shares(q: Floats, slopes: Floats) -> Floats:
        ways = ((q[:, :count], slopes[:, :count]), (q[:, count:], slopes[:, count:]))
        found = [p.shares(*way) for p, way in zip(points, ways, strict=True) if p is not None]
        return np.max(found, axis=0)

    limits = pace.velocity, pace.acceleration, world.policy.zone, pace.jerk
    has_limits = any(p is not None for p in points)
    times = compute_times(path, *limits, shares if has_limits else None)
    return (
        replace(legs[0], q=path[:, :count], t=times),
        replace(legs[1], q=path[:, count:], t=times),
    )
