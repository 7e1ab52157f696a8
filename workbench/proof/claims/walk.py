"""A plan walked through from its first step to its last: what comes too near, and how near."""

from collections.abc import Iterator
from dataclasses import dataclass
from math import prod

import numpy as np

from workbench.model.cell import Cell
from workbench.model.geometry import Floats, Ints
from workbench.model.messages.message import Message
from workbench.model.messages.plans import leg_message
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import Guarantee, Plan, Proof, Violation, are_in_step
from workbench.proof.claims.grasps.straight import part_reach, straight_violations
from workbench.proof.claims.motion import sweep_path
from workbench.proof.claims.stages import (
    INTO_SLOT,
    NEAR_MARGIN_LEGS,
    LegStage,
    MovingArm,
    MovingStep,
    course_of,
    find_carried,
    fingers_of,
    path_at,
    situation_of,
    stages_of,
    steps_of,
    tcp,
    waiting_fingers,
)
from workbench.proof.claims.stirring import bodies_of
from workbench.proof.claims.table import (
    DEEPEST_IN_SLOT,
    PairTable,
    Situation,
    least_distance_allowed,
)
from workbench.proof.engine.pairs import Pairs
from workbench.proof.engine.robot import Tree
from workbench.proof.engine.search import SIGHT, TIGHT, Nearest, SearchGoal, SearchResult, search
from workbench.proof.engine.sets import Sets
from workbench.proof.engine.space import Space

SPARE_MARGIN = 0.0005
"""[m] Distance beyond the margin from which on a hand has left a part."""

CLOSING = 0.001
"""[m] Step of checks while fingers close; fingers are thicker."""

MOST_TOGETHER = 1_000_000
"""Largest number of pairs of places on two arms' paths before halving, enough for 120 waypoints
each."""

FAR_SIGHT = 0.4
"""[m] Distances between arms are computed up to here."""


@dataclass(frozen=True, slots=True, eq=False)
class Walked:
    """What was found: against the plan, and how near things come (w,) [m] on each leg."""

    violations: tuple[Violation, ...]
    clearances: tuple[tuple[str, str, Floats], ...]
    apart: tuple[tuple[str, str, Floats], ...]
    clearance: float
    nearest: Violation | None
    looks: int


@dataclass(frozen=True, slots=True, eq=False)
class _Question:
    """One search as it was asked, to be asked again more closely."""

    step: MovingStep
    moving: MovingArm
    sets: tuple[tuple[Sets, ...], ...]
    pairs: Pairs
    found: SearchResult
    keeps_full_margin: bool


class Walk:
    """One walk through one plan."""

    def __init__(
        self, cell: Cell, tree: Tree, plan: Plan, resolution: float, stated: Proof | None = None
    ) -> None:
        """Among the parts and obstacles that the plan states: `form` has compared them.

        Where a proof is `stated`, its clearances are not searched for: whether they hold is asked.
        """
        self._cell, self._tree, self._plan = cell, tree, plan
        self._stated = stated
        self._resolution = resolution
        bodies = bodies_of(cell, tree, plan)
        self._table = PairTable(cell, tree, bodies)
        self._space = Space(tree, bodies, self._table)
        self._numbers = {arm.name: k for k, arm in enumerate(cell.arms)}
        self._violations: list[Violation] = []
        self._asked: list[_Question] = []
        self._known: dict[tuple[object, ...], Pairs] = {}

    def result(self) -> Walked:
        """Walk all steps, then look more closely at where things come nearest."""
        apart: list[tuple[str, str, Floats]] = []
        for step in steps_of(self._cell, self._tree, self._plan):
            self._put(step)
            for arm_motion in step.moving:
                self._alone(step, arm_motion)
            if len(step.moving) > 1:
                self._together(step)
            if self._stated is None:
                apart.extend(self._apart(step))
        if self._stated is None:
            clearance, nearest = self._closest()
        else:
            clearance, nearest = self._stated.clearance, self._stated.nearest
        clearances: dict[tuple[str, str], Floats] = {}
        for asked in self._asked:
            key, bounds = (asked.moving.arm.name, asked.moving.leg.name), asked.found.bounds
            clearances[key] = np.minimum(clearances.get(key, SIGHT), bounds)
        table = tuple((arm, leg, bounds) for (arm, leg), bounds in clearances.items())
        looks = self._space.looks
        return Walked(tuple(self._violations), table, tuple(apart), clearance, nearest, looks)

    def _put(self, step: MovingStep) -> None:
        """Every part where it is during a step: lying, in a hand, or where it was put."""
        found = [detection.T_world_part for detection in self._plan.detections]
        self._space.put_parts(found, find_carried(self._cell, self._tree, self._plan, step))
        self._known.clear()

    # -- one arm, all others standing -----------------------------------------------------

    def _alone(self, step: MovingStep, arm_motion: MovingArm) -> None:
        """An arm on its leg against everything but arms that move meanwhile."""
        others = [self._numbers[other.arm.name] for other in step.moving if other is not arm_motion]
        cleared_at = 0
        if arm_motion.leg.name == "home":
            cleared_at = self._cleared_at(step, arm_motion)
            if cleared_at:
                out = np.asarray(arm_motion.leg.q[: cleared_at + 1])
                reach = part_reach(self._cell, self._tree, self._plan, arm_motion.plan)
                self._violations += straight_violations(
                    self._tree, arm_motion.arm, "home", out, reach=reach
                )
        now, all_pairs = None, None
        for stage in stages_of(self._cell, self._tree, step, arm_motion, cleared_at):
            if all_pairs is None or stage.now is not now:
                now, all_pairs = stage.now, self._pairs(stage.now)
                for other in others:
                    is_other = all_pairs.between(self._numbers[arm_motion.arm.name], other)
                    all_pairs = all_pairs.among(~is_other)
            # How near a hand stays to what it has put down, or at a slot, is not worth showing.
            pairs = all_pairs.hiding(all_pairs.released | all_pairs.at_slot)
            if stage.now.slot:
                pairs = self._as_at_slot(step, arm_motion, pairs)
            if stage.rises:
                p = tcp(self._tree, step.base, arm_motion.arm, arm_motion.path[0]).translation
                pairs = pairs.among(~self._table.never_met(pairs, p))
            if stage.comes_off or stage.leaves:
                pairs = self._as_it_begins(step, arm_motion, stage, pairs)
            self._ask(step, arm_motion, ((stage.sets, *waiting_fingers(self._tree, step)),), pairs)

    def _as_at_slot(self, step: MovingStep, arm_motion: MovingArm, pairs: Pairs) -> Pairs:
        """Pairs with what they have to keep that are nearer than usual in the slot of a tool."""
        at = len(arm_motion.path) - 1 if arm_motion.leg.name in INTO_SLOT else 0
        self._space.look(self._with(step, arm_motion, arm_motion.path[at]))
        margins = pairs.margins.copy()
        for k in np.flatnonzero(pairs.at_slot).tolist():
            distance = self._space.distance(int(pairs.rows[k]))
            margins[k] = min(margins[k], least_distance_allowed(distance))
            if distance < -DEEPEST_IN_SLOT:
                state = Nearest(int(pairs.rows[k]), distance, -DEEPEST_IN_SLOT, self._space.at, at)
                problem = ProofText.DEEP_IN_SLOT(most=DEEPEST_IN_SLOT)
                self._violations.append(self._violation(arm_motion, state, problem))
        return pairs.keeping(margins)

    def _pairs(self, now: Situation) -> Pairs:
        """The pairs of a situation of the step that was put last; the same are asked for often."""
        leg = now.near_arm, now.target, now.fingers_move_at, now.placed_now, now.stirs, now.slot
        key = now.moves.tobytes(), *leg
        if key not in self._known:
            self._known[key] = self._table.pairs(now, self._space.joints)
        return self._known[key]

    def _as_it_begins(
        self, step: MovingStep, arm_motion: MovingArm, stage: LegStage, pairs: Pairs
    ) -> Pairs:
        """Pairs with what they have to keep where they may begin closer than otherwise."""
        near, sink = self._cell.policy.near_margin, self._cell.policy.sink
        margins, may_touch = pairs.margins.copy(), pairs.beds if stage.comes_off else pairs.released
        self._space.look(self._with(step, arm_motion, arm_motion.path[0]))
        for k in np.flatnonzero(may_touch).tolist():
            distance = self._space.distance(int(pairs.rows[k]))
            margins[k] = min(margins[k], near, least_distance_allowed(distance))
            is_deep = stage.comes_off and distance < -sink
            if is_deep and not self._table.is_rolled(row := int(pairs.rows[k])):
                state = Nearest(row, distance, -sink, self._space.at, 0)
                self._violations.append(self._violation(arm_motion, state, ProofText.TOO_DEEP()))
        return pairs.keeping(margins)

    def _cleared_at(self, step: MovingStep, arm_motion: MovingArm) -> int:
        """The first waypoint of the way home at which the hand has left the part.

        It keeps its margin from there on.  However wide the fingers are open, it has not left a
        part that they would meet if they closed.
        """
        pairs = self._pairs(situation_of(self._tree, step, arm_motion))
        rows = pairs.rows[pairs.released]
        away = self._cell.policy.margin + SPARE_MARGIN
        for number, values in enumerate(arm_motion.path):
            self._space.look(self._with(step, arm_motion, values))
            is_away = all(self._space.distance(int(row)) >= away for row in rows)
            if is_away and not self._is_between(step, arm_motion, values, rows):
                return number
        if np.diff(arm_motion.path, axis=0).any():
            problem = ProofText.NEVER_LEAVES()
            self._violations.append(Violation(problem, arm_motion.arm.name, arm_motion.leg.name))
        return len(arm_motion.path)

    def _is_between(
        self, step: MovingStep, arm_motion: MovingArm, values: Floats, rows: Ints
    ) -> bool:
        """Whether fingers that close at joints (n,) [rad, m] would meet a part, in pairs (r,).

        Each moves by half of what the opening changes: where the nearest is `d` away from the part,
        none meets it before the opening is less by `2 d`.
        """
        rows = rows[self._table.are_fingers(rows)]
        opening, closed = arm_motion.fingers_after, values.copy()
        while len(rows):
            closed[-len(arm_motion.arm.tool.fingers) :] = opening / 2
            self._space.look(self._with(step, arm_motion, closed))
            nearest = min(self._space.distance(int(row)) for row in rows)
            # What is no number is not away.
            if not nearest > 0.0:
                return True
            if opening <= 0.0:
                return False
            opening = max(opening - max(2 * nearest, CLOSING), 0.0)
        return False

    # -- arms that move at once -------------------------------------------------------------

    def _together(self, step: MovingStep) -> None:
        """Arms against each other: at any speeds, or in step where the plan says so."""
        first, second = step.moving
        pairs = self._pairs(situation_of(self._tree, step, first, second))
        numbers = self._numbers[first.arm.name], self._numbers[second.arm.name]
        pairs = pairs.among(pairs.between(*numbers))
        in_step = self._plan.guarantee is Guarantee.SYNCHRONISED
        if in_step and are_in_step([first.leg, second.leg]):
            both = [self._tree.columns[arm_motion.arm.name] for arm_motion in step.moving]
            path = np.hstack([first.path, second.path])
            motion, zone = self._cell.controller.motion, self._cell.policy.zone
            sets: list[tuple[Sets, ...]] = [(sweep_path(np.concatenate(both), path, motion, zone),)]
            # At its end the fingers of both move, in any order.
            sets.append(tuple(fingers_of(self._tree, arm_motion) for arm_motion in step.moving))
        else:
            sets = [
                tuple(course_of(self._cell, self._tree, arm_motion) for arm_motion in step.moving)
            ]
        if sum(prod(len(each.sizes) for each in blocks) for blocks in sets) > MOST_TOGETHER:
            leg = leg_message(second.leg.name)
            problem = ProofText.TOO_MANY(leg=leg, arm=second.arm.name)
            self._violations.append(Violation(problem, first.arm.name, first.leg.name))
            return
        self._ask(step, first, tuple(sets), pairs, second)

    def _apart(self, step: MovingStep) -> Iterator[tuple[str, str, Floats]]:
        """How far arms stay apart (w,) [m] after each waypoint, shoulders left out.

        Two that move at once are checked as they are planned, at the times of the plan.
        """
        if len(self._cell.arms) < 2:
            return
        pairs = self._pairs(situation_of(self._tree, step, *step.moving))
        pairs = pairs.among(self._table.between_hands(pairs, self._space.joints))
        pairs = pairs.keeping(np.full(len(pairs.rows), -np.inf))
        times = np.unique(np.concatenate([arm_motion.leg.t for arm_motion in step.moving]))
        columns = [self._tree.columns[arm_motion.arm.name] for arm_motion in step.moving]
        path = np.hstack([path_at(arm_motion, times) for arm_motion in step.moving])
        motion, zone = self._cell.controller.motion, self._cell.policy.zone
        way = sweep_path(np.concatenate(columns), path, motion, zone)
        asked = ((way, *waiting_fingers(self._tree, step)),)
        found = search(
            self._space,
            step.base,
            asked,
            pairs,
            self._resolution,
            SearchGoal(len(times), sight=FAR_SIGHT),
        )
        if found.gave_up:
            return
        for arm_motion in step.moving:
            first = np.searchsorted(times, arm_motion.leg.t)
            apart = np.minimum.reduceat(found.bounds, first)
            yield arm_motion.arm.name, arm_motion.leg.name, apart

    # -- asking ---------------------------------------------------------------------------

    def _ask(
        self,
        step: MovingStep,
        arm_motion: MovingArm,
        sets: tuple[tuple[Sets, ...], ...],
        pairs: Pairs,
        other: MovingArm | None = None,
    ) -> None:
        keeps_full_margin = any(
            each.leg.name not in NEAR_MARGIN_LEGS
            for each in (arm_motion, other)
            if each is not None
        )
        count, stated, resolution = len(arm_motion.path), None, self._resolution
        if self._stated is not None:
            stated = self._claim(arm_motion)
            if keeps_full_margin:
                stated = np.maximum(stated, self._stated.clearance)
                resolution = min(TIGHT, resolution)
        found = search(
            self._space, step.base, sets, pairs, resolution, SearchGoal(count, stated=stated)
        )
        if found.is_less_than(stated):
            problem = ProofText.NEARER_THAN_STATED()
            self._violations.append(Violation(problem, arm_motion.arm.name, arm_motion.leg.name))
        self._asked.append(_Question(step, arm_motion, sets, pairs, found, keeps_full_margin))
        if found.gave_up:
            problem = ProofText.NEAR_TOO_LONG()
            self._violations.append(Violation(problem, arm_motion.arm.name, arm_motion.leg.name))
        if found.too_near is not None:
            margin = found.too_near.margin
            problem = ProofText.MARGIN(margin=margin)
            if other is not None:
                leg = leg_message(other.leg.name)
                problem = ProofText.MARGIN_BESIDE(margin=margin, arm=other.arm.name, leg=leg)
            self._violations.append(self._violation(arm_motion, found.too_near, problem))

    def _claim(self, arm_motion: MovingArm) -> Floats:
        """What was stated of a leg: bounds (w,) [m] after each waypoint; too much of one left out.

        What two arms keep from each other is stated with the leg of the first.
        """
        stated = self._stated.clearances if self._stated is not None else ()
        known = {(arm, leg): bounds for arm, leg, bounds in stated}
        bounds = known.get((arm_motion.arm.name, arm_motion.leg.name))
        if bounds is None or bounds.shape != (len(arm_motion.path),):
            bounds = np.full(len(arm_motion.path), np.inf)
        return bounds

    def _closest(self) -> tuple[float, Violation | None]:
        """The smallest clearance of free legs, from below, and where that was measured.

        Bounds that are checked more closely for it are better afterwards.
        """
        free = [question for question in self._asked if question.keeps_full_margin]
        measured = [
            (question.found.nearest, question)
            for question in free
            if question.found.nearest is not None
        ]
        if not measured:
            return min(
                (float(question.found.bounds.min()) for question in free), default=SIGHT
            ), None
        state, where = min(measured, key=lambda asked: asked[0].distance)
        within = state.distance
        for asked in free:
            close = asked.found.bounds < within - TIGHT
            if not close.any() or asked.found.too_near is not None or asked.found.gave_up:
                continue
            self._put(asked.step)
            sets = tuple((blocks[0].after(close), *blocks[1:]) for blocks in asked.sets)
            # How near, not whether too near: that has been answered.
            shown = asked.pairs.among(asked.pairs.shown)
            pairs = shown.keeping(np.full(len(shown.rows), -np.inf))
            base, count = asked.step.base, len(asked.moving.path)
            again = search(self._space, base, sets, pairs, TIGHT, SearchGoal(count, within))
            if not again.gave_up:
                asked.found.bounds[close] = again.bounds[close]
            if again.nearest is not None and again.nearest.distance < within:
                within, state, where = again.nearest.distance, again.nearest, asked
        bound = min(float(question.found.bounds.min()) for question in free)
        return bound, self._violation(where.moving, state, ProofText.NEAREST())

    def _with(self, step: MovingStep, arm_motion: MovingArm, values: Floats) -> Floats:
        q = step.base.copy()
        q[self._tree.columns[arm_motion.arm.name]] = values
        return q

    def _violation(self, arm_motion: MovingArm, state: Nearest, problem: Message) -> Violation:
        columns = self._tree.columns[arm_motion.arm.name][: len(arm_motion.arm.joints)]
        labels, q = self._table.labels(state.row), state.q[columns]
        return Violation(
            problem, arm_motion.arm.name, arm_motion.leg.name, state.at, labels, state.distance, q
        )
