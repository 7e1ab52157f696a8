"""A step of a plan as the robot runs it: what comes too close, and how close the rest comes."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats, Ints
from workbench.model.plan import Finding, Guarantee, Leg, are_in_step
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.leaving import comes_back
from workbench.planning.collision.legs import LEAVING, Stretch, lead_of
from workbench.planning.collision.meeting import Course, first_meeting
from workbench.planning.collision.motion import path_contact, walked
from workbench.planning.collision.world import World


@dataclass(frozen=True, slots=True, eq=False)
class Walked:
    """What was found on one step.

    `finding` is the first thing that speaks against it; `clearances` gives for each leg, as
    (arm, leg), the distance at each waypoint (n,) [m]; `closest` is the smallest of them;
    `apart` likewise the distance between the arms, empty for a cell with one.
    """

    finding: Finding | None
    clearances: tuple[tuple[str, str, Floats], ...]
    closest: Finding | None
    apart: tuple[tuple[str, str, Floats], ...]


def walk(
    world: World,
    stretch: Stretch,
    guarantee: Guarantee,
    resolution: float,
    sight: float,
    far_sight: float,
) -> Walked:
    """Go through one step.

    Args:
        world: of the plan's cell and detections.
        stretch: the step.
        guarantee: under which two arms run at once.
        resolution: [m] see `motion`.
        sight: [m] clearances are measured up to here.
        far_sight: [m] distances between arms are measured up to here.
    """
    world.enter(stretch.phase)
    starts = {plan.arm: np.asarray(leg.q[0]) for plan, leg in stretch.runs}
    if any(leg.name in LEAVING for _, leg in stretch.runs):
        world.allow_start_contacts(world.configuration({**stretch.standing, **starts}))
    legs = [leg for _, leg in stretch.runs]
    if len(legs) == 1:
        finding = _alone(world, stretch, resolution)
    elif guarantee is Guarantee.SYNCHRONISED and are_in_step(legs):
        finding = _in_step(world, stretch, resolution)
    else:
        finding = _at_any_speed(world, stretch, resolution)
    clearances, closest = _clearances(world, stretch, sight)
    return Walked(finding, clearances, closest, _apart(world, stretch, far_sight))


def _alone(world: World, stretch: Stretch, resolution: float) -> Finding | None:
    """One leg among arms that stand."""
    ((arm_plan, leg),) = stretch.runs
    return _along(world, arm_plan.arm, leg, stretch.standing, resolution)


def _along(
    world: World,
    arm: str,
    leg: Leg,
    standing: Mapping[str, Floats],
    resolution: float,
    among: Ints | None = None,
) -> Finding | None:
    path, columns = np.asarray(leg.q), world.kinematics.columns[arm]
    base = world.configuration(standing)
    found = path_contact(world, columns, base, path, world.policy.zone, resolution, among)
    found = found or comes_back(world, (arm,), columns, base, path, resolution)
    return None if found is None else _finding(found[0], arm, leg, found[2], found[1])


def _at_any_speed(world: World, stretch: Stretch, resolution: float) -> Finding | None:
    """Each leg by itself, among arms that stand, then both against each other."""
    for arm_plan, leg in stretch.runs:
        (other,) = (one.arm for one, _ in stretch.runs if one is not arm_plan)
        among = world.all_but(arm_plan.arm, other)
        finding = _along(world, arm_plan.arm, leg, stretch.standing, resolution, among)
        if finding is not None:
            return finding
    (first, first_leg), (second, second_leg) = stretch.runs
    zone = world.policy.zone
    curves = [walked(np.asarray(leg.q), zone) for _, leg in stretch.runs]
    met = first_meeting(
        world,
        world.configuration(stretch.standing),
        Course(first.arm, curves[0].points),
        Course(second.arm, curves[1].points),
        resolution,
    )
    if met is None:
        return None
    waypoint = int(curves[0].waypoints[met.curves[0]])
    finding = _finding(met.contact, first.arm, first_leg, waypoint, met.q[0])
    return Finding(
        f"{finding.problem}, while arm {second.arm} is on its leg {second_leg.name}",
        first.arm,
        first_leg.name,
        waypoint,
        finding.pair,
        finding.distance,
        finding.q,
    )


def _in_step(world: World, stretch: Stretch, resolution: float) -> Finding | None:
    """All legs as one motion."""
    columns = np.concatenate([world.kinematics.columns[plan.arm] for plan, _ in stretch.runs])
    path = np.hstack([np.asarray(leg.q) for _, leg in stretch.runs])
    base = world.configuration(stretch.standing)
    arms = [plan.arm for plan, _ in stretch.runs]
    found = path_contact(world, columns, base, path, world.policy.zone, resolution)
    found = found or comes_back(world, arms, columns, base, path, resolution)
    if found is None:
        return None
    arm_plan, leg = stretch.runs[0]
    q = found[1][: len(arm_plan.joints)]
    return _finding(found[0], arm_plan.arm, leg, found[2], q)


def _finding(contact: Contact, arm: str, leg: Leg, waypoint: int, q: Floats) -> Finding:
    problem = f"closer than {contact.margin * 1000:.1f} mm"
    return Finding(problem, arm, leg.name, waypoint, contact.pair, contact.distance, q)


def _clearances(
    world: World, stretch: Stretch, sight: float
) -> tuple[tuple[tuple[str, str, Floats], ...], Finding | None]:
    """Distances at the waypoints of every leg, the others where the timing has them.

    On its straight way out the hand is close to the part that it has let go of: that is left out.
    """
    clearances: list[tuple[str, str, Floats]] = []
    closest: Finding | None = None
    for arm_plan, leg in stretch.runs:
        distances, all_of_it = np.empty(len(leg.q)), world.involving(arm_plan.arm)
        but_the_part = np.setdiff1d(all_of_it, world.left_behind(arm_plan.arm))
        out = len(lead_of(leg, world.policy.straight_points))
        for number, whole in enumerate(_states(world, stretch, arm_plan.arm, leg)):
            q, among = leg.q[number], but_the_part if number < out else all_of_it
            distance, pair = world.clearance(whole, sight, among)
            distances[number] = distance
            if pair is not None and (closest is None or distance < (closest.distance or 0.0)):
                closest = Finding(
                    "smallest clearance", arm_plan.arm, leg.name, number, pair, distance, q
                )
        clearances.append((arm_plan.arm, leg.name, distances))
    return tuple(clearances), closest


def _apart(world: World, stretch: Stretch, far_sight: float) -> tuple[tuple[str, str, Floats], ...]:
    """Distances between the arms, shoulders apart, at the waypoints of every leg."""
    among = world.between_hands()
    if len(among) == 0:
        return ()
    return tuple(
        (
            arm_plan.arm,
            leg.name,
            np.array(
                [
                    world.clearance(whole, far_sight, among)[0]
                    for whole in _states(world, stretch, arm_plan.arm, leg)
                ]
            ),
        )
        for arm_plan, leg in stretch.runs
    )


def _states(world: World, stretch: Stretch, arm: str, leg: Leg) -> Iterator[Floats]:
    """Whole configurations (nq,) at the waypoints of a leg, other arms where they are then."""
    beside = [(plan.arm, other) for plan, other in stretch.runs if plan.arm != arm]
    for q, t in zip(np.asarray(leg.q), leg.t.tolist(), strict=True):
        others = {name: at(other, t) for name, other in beside}
        yield world.configuration({**stretch.standing, **others, arm: q})


def at(leg: Leg, t: float) -> Floats:
    """The configuration (n,) of a leg at a time [s], straight between its waypoints."""
    return np.array([np.interp(t, leg.t, column) for column in np.asarray(leg.q).T])
