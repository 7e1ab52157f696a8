"""From picks to a plan: the free legs between the straight ones, as they will be sent."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from workbench.model.candidate import FoundGrip, Pick, Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.derived.carried_points import InHand
from workbench.model.derived.point_speeds import speeds_on
from workbench.model.geometry import Floats
from workbench.model.load import loads_of
from workbench.model.messages.message import Message
from workbench.model.messages.plans import leg_message
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.motion import LEG_NAMES
from workbench.model.plan import ArmPlan, Guarantee, Leg, LegName, Plan, Step, Strategy
from workbench.planning.collision.legs import HOLDING, Run, phase_of
from workbench.planning.collision.motion import RESOLUTION
from workbench.planning.collision.world import World
from workbench.planning.kinematics.execution import compute_times
from workbench.planning.kinematics.quickness import pace_of
from workbench.planning.kinematics.upright import UprightLimit, Uprightness, upright_limit
from workbench.planning.picking.leaving import along_placed
from workbench.planning.picking.put_down import PutDown, home_of, put_down
from workbench.planning.picking.search import PathQuery, curve_check, joint_weights, onward
from workbench.planning.planners.clock import working_time

MOTIONS: Mapping[LegName, Literal["joint", "linear"]] = {
    "reach": "joint",
    "approach": "linear",
    "extract": "linear",
    "return": "joint",
    "place": "linear",
    "home": "joint",
    "view": "joint",
    "stir": "joint",
    "stow": "linear",
    "retract": "linear",
    "cross": "joint",
    "dock": "linear",
    "undock": "linear",
    "lift": "linear",
    "carry": "joint",
}

STRAIGHT_REASONS: Mapping[LegName, Reason] = {
    "approach": Reason.APPROACH_BLOCKED,
    "extract": Reason.EXTRACT_BLOCKED,
}
"""Legs known to be clear except for parts that other arms placed, and the reason of a refusal."""


def route(
    world: World,
    picks: Sequence[Pick],
    strategy: Strategy,
    *,
    scan_digest: str,
    seed: int,
    notes: tuple[Message, ...] = (),
    since: int = 0,
) -> Plan | Verdict:
    """A plan in which the arms work one after the other, in the order of `picks`.

    Each arm reaches, approaches, closes, extracts, returns, places, opens and goes home while
    the other stands at home as an obstacle; what the arms before have placed is one, too, from leg
    number `since` on.

    Args:
        world: of the cell and the detections that the picks were made from.
        picks: at most one an arm, each of another detection.
        strategy: what to call the plan; it says which arms work.
        scan_digest: what the detections were found in.
        seed: of the request.
        notes: for people, why this strategy.
        since: see `arm_plan`; 0 where one arm has done all its legs before the next begins.

    Returns:
        The plan, or the verdict of the leg for which no path was found.
    """
    began = working_time()
    arms: list[ArmPlan] = []
    steps: list[Step] = []
    for pick in picks:
        planned = arm_plan(world, pick, seed, arms, since)
        if isinstance(planned, Verdict):
            return planned
        arms.append(planned)
        steps.extend(Step(((planned.arm, leg.name),)) for leg in planned.legs)
    return Plan(
        cell=world.cell.name,
        cell_digest=world.cell.digest,
        scan_digest=scan_digest,
        seed=seed,
        strategy=strategy,
        guarantee=Guarantee.ONE_AT_A_TIME,
        detections=world.detections,
        obstacles=world.obstacles,
        arms=tuple(arms),
        sequence=tuple(steps),
        notes=notes,
        seconds={"route": working_time() - began},
    )


def arm_plan(
    world: World, pick: Pick, seed: int, before: Sequence[ArmPlan] = (), since: int = 0
) -> ArmPlan | Verdict:
    """All legs of one arm, the others standing at home.

    Args:
        world: of the cell and the detections that the pick was made from.
        pick: what the arm does.
        seed: of the request.
        before: plans of arms that have placed their parts where this one comes by.
        since: number of the leg from which on they have; before it their parts lie in the bin.

    Returns:
        The plan, or the verdict of the first leg for which no path was found.
    """
    arm, grasp = world.arm(pick.candidate.arm), pick.candidate.grasp

    def waiting(name: LegName) -> list[Run]:
        is_placed = LEG_NAMES.index(name) >= since
        return (
            [(earlier, "home", earlier.leg("home").opening) for earlier in before]
            if is_placed
            else []
        )

    put = put_down(world, pick, phase_of([], waiting("place")))
    if isinstance(put, Verdict):
        return put
    plan = _straight_legs(world, pick, put)
    for name in STRAIGHT_REASONS:
        world.enter(phase_of([(plan, name, plan.leg(name).opening)], waiting(name)))
        found = along_placed(world, arm.name, np.asarray(plan.leg(name).q))
        if found is not None:
            contact, q = found
            return contact.refuse(STRAIGHT_REASONS[name], Stage.ROUTE, q)
    home = home_of(world, arm)
    seeds = np.random.SeedSequence([seed, plan.detection, ord(arm.controller_id)])
    rng = np.random.default_rng(seeds)
    free: list[Leg] = []
    ways: tuple[tuple[LegName, Floats, Floats], ...] = (
        ("reach", home[None], pick.approach[0]),
        ("return", pick.extract[-1:], put.down[0]),
        ("home", put.out, home),
    )
    for name, lead, goal in ways:
        opening = grasp.grip if name in HOLDING else grasp.opening
        world.enter(phase_of([(plan, name, opening)], waiting(name)))
        if name == "home" and len(lead) == 1:
            # The place is at home, the hand stays around the part.
            world.allow_start_contacts(world.configuration({arm.name: lead[0]}))
        path = free_path(world, arm, lead, goal, rng, keep_upright(world, [plan], name))
        if isinstance(path, Verdict):
            return path if name == "reach" else _refuse_later_leg(path, name)
        free.append(leg_of(world, arm, name, path, opening, hand_of(world, plan)))
    legs = sorted((*plan.legs, *free), key=lambda leg: LEG_NAMES.index(leg.name))
    return replace(plan, legs=tuple(legs))


def _straight_legs(world: World, pick: Pick, put: PutDown) -> ArmPlan:
    """The plan of an arm with its straight legs alone."""
    candidate, grasp = pick.candidate, pick.candidate.grasp
    arm = world.arm(candidate.arm)
    found = world.detections[candidate.detection]
    part = world.cell.part(found.part)
    hand = InHand(part, found, pick.T_tcp_part)
    legs = (
        leg_of(world, arm, "approach", pick.approach, grasp.opening, hand),
        leg_of(world, arm, "extract", pick.extract, grasp.grip, hand),
        leg_of(world, arm, "place", put.down, grasp.grip, hand),
    )
    loads = loads_of(arm.tool, part, pick.T_tcp_part)
    taken = candidate.detection, grasp.name, pick.T_tcp_part
    grip = FoundGrip(grasp.T_part_tcp, grasp.opening, grasp.grip) if grasp.is_found else None
    tcp = arm.tool.tcp
    return ArmPlan(arm.name, *taken, arm.joints, legs, loads=loads, found=grip, tcp=tcp)


def _refuse_later_leg(verdict: Verdict, name: LegName) -> Verdict:
    """The verdict where the path to the place or home was not found, or time ran out before."""
    if verdict.reason is Reason.OUT_OF_TIME:
        return verdict
    return replace(verdict, reason=Reason.NO_RETURN, note=VerdictNote.LEG(leg=leg_message(name)))


def hand_of(world: World, plan: ArmPlan) -> InHand:
    """What an arm carries on the legs on which it holds its part."""
    found = world.detections[plan.detection]
    return InHand(world.cell.part(found.part), found, plan.T_tcp_part)


def leg_of(
    world: World, arm: Arm, name: LegName, path: Floats, opening: float, hand: InHand | None
) -> Leg:
    """A leg of one arm along a path (m, n) [rad], with its timing; the `opening` is in m."""
    pace = pace_of(world.chains[arm.name], world.policy.speed)
    points = speeds_on(world.cell, arm, name in HOLDING, opening, hand, name)
    limits = pace.velocity, pace.acceleration, world.policy.zone, pace.jerk
    times = compute_times(path, *limits, None if points is None else points.shares)
    return Leg(name, MOTIONS[name], name in HOLDING, opening, path, times)


def keep_upright(world: World, plans: Sequence[ArmPlan], name: LegName) -> Uprightness | None:
    """What keeps the parts upright that arms carry on a leg; None where nothing has to."""
    if name not in HOLDING:
        return None
    limits: list[UprightLimit | None] = []
    for plan in plans:
        found = world.detections[plan.detection]
        part, chain = world.cell.part(found.part), world.chains[plan.arm]
        limits.append(upright_limit(chain, part, found, plan.T_tcp_part))
    if not any(limits):
        return None
    return Uprightness(limits, [len(plan.joints) for plan in plans])


def free_path(
    world: World,
    arm: Arm,
    lead: Floats,
    goal: Floats,
    rng: np.random.Generator,
    upright: Uprightness | None = None,
) -> Floats | Verdict:
    """A path of one arm in the world's present phase, rounded and checked as it will be run.

    Args:
        world: in the phase of the leg.
        arm: that moves.
        lead: waypoints (k, n) that the path begins with; only the last one and the corner there
            are checked.
        goal: where it ends (n,).
        rng: of everything random.
        upright: what keeps the part upright that it carries.

    Returns:
        Waypoints (m, n) [rad]; or why there are none, with the pair in the way when an end
        of the path is itself too close to something.
    """
    columns, base = world.kinematics.columns[arm.name], world.configuration({})
    for q in (lead[-1], goal):
        contact = world.contact(world.configuration({arm.name: q}))
        if contact is not None:
            return contact.refuse(Reason.NO_PATH, Stage.ROUTE, q, VerdictNote.AT_END())
    chain = world.chains[arm.name]
    query = PathQuery(
        curve_check(world, columns, base),
        (chain.lower, chain.upper),
        joint_weights(len(goal), world.policy),
        world.policy,
        world.motion,
        world.deadline,
        world.edges(columns, base, RESOLUTION),
        pace_of(chain, world.policy.speed),
        upright=upright,
    )
    return onward(query, lead, goal, rng)
