"""Where two bodies are that a proof names: for people, who want to see the place."""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Floats, Shape
from workbench.model.plan import Plan, Violation
from workbench.proof.claims.stages import (
    FIRST_LEGS,
    MovingArm,
    MovingStep,
    find_carried,
    steps_of,
    waiting_fingers,
)
from workbench.proof.claims.stirring import bodies_of
from workbench.proof.claims.table import PairTable
from workbench.proof.claims.tool_change import by_stretches
from workbench.proof.engine.robot import Tree, tree_of
from workbench.proof.engine.space import Space

WAY_SAMPLES = 61
"""Places on the way of another arm at which it may be."""

SAME_STATE = 1e-5
"""[m] The state that was proven is found."""


@dataclass(frozen=True, slots=True, eq=False)
class Spot:
    """Two bodies that a proof names, as near as they come there.

    `seconds` on the leg; `points` (2, 3) [m] are the nearest of the two, in the world, `distance`
    [m] apart; `bodies` are their shapes with `T_world_body`; `others` is how far [s] arms that move
    meanwhile are on their legs.
    """

    seconds: float
    points: Floats
    distance: float
    bodies: tuple[tuple[Shape, pin.SE3], ...]
    others: Mapping[str, float]


def spot_of(cell: Cell, plan: Plan, place: Violation) -> Spot | None:
    """Where two bodies are that a proof names; None where it names none that can be shown.

    How open fingers are, and, of two arms at any speeds, where the other one is, it does not say:
    of all that may be, it is what comes nearest to the distance found.
    """
    if place.pair is None or place.q is None or place.waypoint is None:
        return None
    for each, stretch in by_stretches(cell, plan):
        if any(leg.name == place.leg for arm in stretch.arms for leg in arm.legs):
            return _on_stretch(each, stretch, place)
    return None


def _on_stretch(cell: Cell, plan: Plan, place: Violation) -> Spot | None:
    """As `spot_of`, for a stretch of a plan and the cell as it is then."""
    if place.pair is None:
        return None
    tree = tree_of(cell)
    bodies = bodies_of(cell, tree, plan)
    table = PairTable(cell, tree, bodies)
    space = Space(tree, bodies, table)
    wanted = set(place.pair)
    rows = [row for row in range(len(table.first)) if set(table.labels(row)) == wanted]
    for step in steps_of(cell, tree, plan):
        for arm_motion in step.moving:
            if (arm_motion.arm.name, arm_motion.leg.name) == (place.arm, place.leg) and rows:
                found = [detection.T_world_part for detection in plan.detections]
                space.put_parts(found, find_carried(cell, tree, plan, step))
                return _locate(tree, space, step, arm_motion, place, rows)
    return None


def _locate(
    tree: Tree,
    space: Space,
    step: MovingStep,
    arm_motion: MovingArm,
    place: Violation,
    rows: list[int],
) -> Spot:
    seconds = _seconds(arm_motion, place)
    wanted = 0.0 if place.distance is None else place.distance
    best: tuple[float, float, int, Floats, Mapping[str, float]] | None = None
    for q, others in _states(tree, step, arm_motion, np.asarray(place.q), seconds):
        space.look(q)
        distance, row = min((space.distance(row), row) for row in rows)
        if best is None or abs(distance - wanted) < best[0]:
            best = abs(distance - wanted), distance, row, q, others
            if best[0] < SAME_STATE:
                break
    assert best is not None
    _, distance, row, q, others = best
    space.look(q)
    space.distance(row)
    pair = [space.bodies[int(k[row])].label for k in (space.table.first, space.table.second)]
    shown = tuple(
        (body.shape, space.pose(number))
        for number, body in enumerate(space.bodies)
        if body.label in pair
    )
    return Spot(seconds, space.nearest(), distance, shown, others)


def _seconds(arm_motion: MovingArm, place: Violation) -> float:
    """When [s] on a leg the arm is nearest to the configuration of a place."""
    q, t, after = np.asarray(arm_motion.leg.q), np.asarray(arm_motion.leg.t), place.waypoint or 0
    best, seconds = np.inf, float(t[-1])
    # A blend that is counted with a waypoint ends in the segment after the next one.
    for k in range(after, min(after + 2, len(q) - 1)):
        way = q[k + 1] - q[k]
        share = float(np.clip((place.q - q[k]) @ way / max(way @ way, 1e-12), 0.0, 1.0))
        off = float(np.linalg.norm(q[k] + share * way - place.q))
        if off < best - 1e-9:
            best, seconds = off, float(t[k] + share * (t[k + 1] - t[k]))
    return seconds


def _states(
    tree: Tree, step: MovingStep, arm_motion: MovingArm, q_arm: Floats, seconds: float
) -> Iterator[tuple[Floats, Mapping[str, float]]]:
    """Whole configurations (nq,) that may have been meant, the likeliest first."""
    others = [other for other in step.moving if other is not arm_motion]
    at_once = [{other.arm.name: min(seconds, other.leg.seconds) for other in others}]
    ways = [np.linspace(0.0, other.leg.seconds, WAY_SAMPLES) for other in others]
    at_any = [
        {other.arm.name: float(t)} for other, times in zip(others, ways, strict=True) for t in times
    ]
    fingers = len(arm_motion.arm.tool.fingers)
    openings = [arm_motion.leg.opening]
    if fingers:
        ends = (arm_motion.leg.opening, arm_motion.fingers_after)
        # Before the first leg they may be anywhere.
        is_first = arm_motion.leg.name in FIRST_LEGS and seconds == 0.0
        openings += np.linspace(*(arm_motion.arm.tool.stroke if is_first else ends), 5).tolist()
    waits = waiting_fingers(tree, step)
    for when, share in product(at_once + at_any, np.linspace(0.0, 1.0, 5 if waits else 1)):
        q = step.base.copy()
        for sets in waits:
            q[sets.columns] = (1.0 - share) * sets.corners[0, 0] + share * sets.corners[0, 1]
        for other in others:
            values = other.path[0].copy()
            values[: len(other.arm.joints)] = other.leg.at(when[other.arm.name])
            q[tree.columns[other.arm.name]] = values
        for opening in openings:
            q[tree.columns[arm_motion.arm.name]] = np.append(q_arm, np.full(fingers, opening / 2))
            yield q.copy(), when
