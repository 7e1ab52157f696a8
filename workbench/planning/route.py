"""From picks to a plan: the free legs between the straight ones, as they will be sent."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Literal

import numpy as np

from workbench.model.candidate import Pick, Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.geometry import Floats
from workbench.model.plan import ArmPlan, Guarantee, Leg, LegName, Plan, Step, Strategy
from workbench.planning.clock import working_time
from workbench.planning.contact import Contact
from workbench.planning.execution import timed
from workbench.planning.legs import HOLDING, phase_of
from workbench.planning.motion import Curves, chain_contact
from workbench.planning.search import joint_weights, searched
from workbench.planning.wire import on_wire
from workbench.planning.world import World

MOTIONS: Mapping[LegName, Literal["joint", "linear"]] = {
    "reach": "joint",
    "approach": "linear",
    "extract": "linear",
    "return": "joint",
    "place": "linear",
    "home": "joint",
}


def route(
    world: World,
    picks: Sequence[Pick],
    strategy: Strategy,
    *,
    scan_digest: str,
    seed: int,
    note: str = "",
) -> Plan | Verdict:
    """A plan in which the arms work one after the other, in the order of `picks`.

    Each arm reaches, approaches, closes, extracts, returns, places, opens and goes home while
    the other stands at home as an obstacle.

    Args:
        world: of the cell and the detections that the picks were made from.
        picks: at most one an arm, each of another detection.
        strategy: what to call the plan; it says which arms work.
        scan_digest: what the detections were found in.
        seed: of the request.
        note: for people, why this strategy.

    Returns:
        The plan, or the verdict of the leg for which no path was found.
    """
    began = working_time()
    arms: list[ArmPlan] = []
    steps: list[Step] = []
    gone: frozenset[int] = frozenset()
    for pick in picks:
        planned = arm_plan(world, pick, gone, seed)
        if isinstance(planned, Verdict):
            return planned
        arms.append(planned)
        steps.extend(Step(((planned.arm, leg.name),)) for leg in planned.legs)
        gone = gone | {planned.detection}
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
        note=note,
        seconds={"route": working_time() - began},
    )


def arm_plan(world: World, pick: Pick, gone: frozenset[int], seed: int) -> ArmPlan | Verdict:
    """All legs of one arm, the others standing at home.

    `gone` are detections that have been taken away before.  The verdict is that of the first
    leg for which no path was found.
    """
    candidate = pick.candidate
    arm = world.arm(candidate.arm)
    plan = ArmPlan(
        arm.name, candidate.detection, candidate.grasp.name, pick.T_tcp_part, arm.joints, ()
    )
    chain = world.chains[arm.name]
    home = np.clip(on_wire(np.asarray(arm.home)), chain.lower, chain.upper)
    seeds = np.random.SeedSequence([seed, candidate.detection, ord(arm.letter)])
    rng = np.random.default_rng(seeds)
    free: dict[LegName, Floats] = {}
    ways: tuple[tuple[LegName, Floats, Floats], ...] = (
        ("reach", home, pick.approach[0]),
        ("return", pick.extract[-1], pick.place[0]),
        ("home", pick.place[-1], home),
    )
    for name, start, end in ways:
        opening = candidate.grasp.grip if name in HOLDING else candidate.grasp.opening
        world.enter(phase_of([(plan, name, opening)], gone=gone))
        path = free_path(world, arm, start, end, rng)
        if isinstance(path, Verdict):
            return path if name == "reach" else _without_return(path, name)
        free[name] = path
    legs = (
        leg_of(world, arm, "reach", free["reach"], candidate.grasp.opening),
        leg_of(world, arm, "approach", pick.approach, candidate.grasp.opening),
        leg_of(world, arm, "extract", pick.extract, candidate.grasp.grip),
        leg_of(world, arm, "return", free["return"], candidate.grasp.grip),
        leg_of(world, arm, "place", pick.place, candidate.grasp.grip),
        leg_of(world, arm, "home", free["home"], candidate.grasp.opening),
    )
    return ArmPlan(
        arm.name, candidate.detection, candidate.grasp.name, pick.T_tcp_part, arm.joints, legs
    )


def _without_return(verdict: Verdict, name: LegName) -> Verdict:
    """The verdict on a way back that was not found; where time ran out, nothing else is known."""
    if verdict.reason is Reason.OUT_OF_TIME:
        return verdict
    return replace(verdict, reason=Reason.NO_RETURN, note=f"leg {name}")


def leg_of(world: World, arm: Arm, name: LegName, path: Floats, opening: float) -> Leg:
    """A leg of one arm with its timing."""
    policy = world.policy
    _, _, velocity = world.cell.robot.limits(arm.joints)
    times = timed(path, velocity * policy.speed, np.asarray(arm.acceleration), policy.zone)
    return Leg(name, MOTIONS[name], name in HOLDING, opening, path, times)


def free_path(
    world: World, arm: Arm, start: Floats, goal: Floats, rng: np.random.Generator
) -> Floats | Verdict:
    """A path of one arm in the world's present phase, rounded and checked as it will be run.

    Returns:
        Waypoints (m, n) [rad]; or why there are none, with the pair in the way when an end
        of the path is itself too close to something.
    """
    columns, base = world.kinematics.columns[arm.name], world.configuration({})
    for q in (start, goal):
        contact = world.contact(world.configuration({arm.name: q}))
        if contact is not None:
            return Verdict(
                Reason.NO_PATH, Stage.ROUTE, contact.pair, contact.distance, q, "at its end"
            )

    def check(curves: Curves) -> tuple[Contact, Floats] | None:
        found = chain_contact(world, columns, base, curves)
        return None if found is None else found[:2]

    chain = world.chains[arm.name]
    return searched(
        start,
        goal,
        (chain.lower, chain.upper),
        joint_weights(len(start), world.policy),
        check,
        world.policy,
        rng,
        world.deadline,
    )
