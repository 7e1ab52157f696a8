"""A plan walked through from its first step to its last: what comes too near, and how near."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.plan import Finding, Guarantee, Plan, Proof, are_in_step
from workbench.proof.bodies import bodies_of
from workbench.proof.motion import Sets, moved
from workbench.proof.robot import Tree
from workbench.proof.rules import straight_findings
from workbench.proof.search import SIGHT, TIGHT, Found, Nearest, search
from workbench.proof.space import Space
from workbench.proof.stages import (
    STRAIGHT,
    Moving,
    Stage,
    Step,
    course_of,
    fingers_of,
    situation_of,
    stages_of,
    steps_of,
    tcp,
)
from workbench.proof.table import SLACK, Pairs, Situation, Table

ROOM = 0.0005
"""[m] So much more than its margin away, a hand has left a part."""

FAR_SIGHT = 0.4
"""[m] Distances between arms are told up to here."""


@dataclass(frozen=True, slots=True, eq=False)
class Walked:
    """What was found: against the plan, and how near things come (w,) [m] on each leg."""

    findings: tuple[Finding, ...]
    clearances: tuple[tuple[str, str, Floats], ...]
    apart: tuple[tuple[str, str, Floats], ...]
    clearance: float
    nearest: Finding | None
    looks: int


@dataclass(frozen=True, slots=True, eq=False)
class _Question:
    """One search as it was asked, to be asked again more closely."""

    step: Step
    one: Moving
    sets: tuple[tuple[Sets, ...], ...]
    pairs: Pairs
    found: Found


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
        bodies = bodies_of(cell, tree, plan.scene)
        self._table = Table(cell, tree, bodies)
        self._space = Space(tree, bodies, self._table)
        hands = self._pairs(Situation(np.ones(tree.model.nq, bool)))
        self._hands = hands.among(self._table.between_hands(hands, self._space.joints))
        self._numbers = {arm.name: k for k, arm in enumerate(cell.arms)}
        self._findings: list[Finding] = []
        self._asked: list[_Question] = []

    def result(self) -> Walked:
        """Walk all steps, then look more closely at where things come nearest."""
        clearances: list[tuple[str, str, Floats]] = []
        apart: list[tuple[str, str, Floats]] = []
        for step in steps_of(self._cell, self._tree, self._plan):
            self._put(step)
            for one in step.moving:
                bounds = self._alone(step, one)
                clearances.append((one.arm.name, one.leg.name, bounds))
            if len(step.moving) > 1:
                self._together(step)
            if self._stated is None:
                apart.extend(self._apart(step))
        if self._stated is None:
            clearance, nearest = self._closest()
        else:
            clearance, nearest = self._stated.clearance, self._stated.nearest
        looks = self._space.looks
        return Walked(
            tuple(self._findings), tuple(clearances), tuple(apart), clearance, nearest, looks
        )

    def _put(self, step: Step) -> None:
        """Every part where it is during a step: lying, in a hand, or where it was put."""
        where: dict[int, tuple[int, pin.SE3]] = {}
        for number, plan in step.held.items():
            arm = self._cell.arm(plan.arm)
            joint, T_joint_flange = self._tree.flange(arm)
            where[number] = joint, T_joint_flange * arm.tool.T_flange_tcp * plan.T_tcp_part
        for number, plan in step.placed.items():
            q_place, arm = np.asarray(plan.leg("place").q[-1]), self._cell.arm(plan.arm)
            where[number] = 0, tcp(self._tree, step.base, arm, q_place) * plan.T_tcp_part
        for number, body in enumerate(self._space.bodies):
            if body.part >= 0:
                T_world_part = self._plan.detections[body.part].T_world_part
                joint, T = where.get(body.part, (0, T_world_part))
                self._space.put(number, joint, T * T_world_part.actInv(body.T_joint_body))

    # -- one arm, all others standing -----------------------------------------------------

    def _alone(self, step: Step, one: Moving) -> Floats:
        """How near an arm comes to anything (w,) [m] after each waypoint of its leg."""
        bounds = np.full(len(one.path), SIGHT)
        others = [self._numbers[other.arm.name] for other in step.moving if other is not one]
        left_at = 0
        if one.leg.name == "home":
            left_at = self._left_at(step, one)
            if left_at:
                out = np.asarray(one.leg.q[: left_at + 1])
                self._findings += straight_findings(self._tree, one.arm, "home", out)
        now, all_pairs = None, None
        for stage in stages_of(self._cell, self._tree, step, one, left_at):
            if all_pairs is None or stage.now is not now:
                now, all_pairs = stage.now, self._pairs(stage.now)
                for other in others:
                    is_other = all_pairs.between(self._numbers[one.arm.name], other)
                    all_pairs = all_pairs.among(~is_other)
            # How near a hand stays to the part that it has put down is not worth showing.
            pairs = all_pairs.hiding(all_pairs.left)
            if stage.comes_off or stage.leaves:
                pairs = self._as_it_begins(step, one, stage, pairs)
            found = self._ask(step, one, tuple((sets,) for sets in stage.sets), pairs)
            bounds = np.minimum(bounds, found.bounds)
        return bounds

    def _pairs(self, now: Situation) -> Pairs:
        return self._table.pairs(now, self._space.joints)

    def _as_it_begins(self, step: Step, one: Moving, stage: Stage, pairs: Pairs) -> Pairs:
        """Pairs with what they have to keep where they may begin closer than otherwise."""
        near, sink = self._cell.policy.near_margin, self._cell.policy.sink
        margins, may_touch = pairs.margins.copy(), pairs.beds if stage.comes_off else pairs.left
        self._space.look(self._with(step, one, one.path[0]))
        for k in np.flatnonzero(may_touch).tolist():
            distance = self._space.distance(int(pairs.rows[k]))
            margins[k] = min(margins[k], near, distance - SLACK)
            if stage.comes_off and distance < -sink:
                state = Nearest(int(pairs.rows[k]), distance, -sink, self._space.at, (0,))
                problem = "a part lies too deep in what it lies on: its pose is wrong"
                self._findings.append(self._finding(one, state, problem))
        kept = pairs.keeping(margins)
        return kept

    def _left_at(self, step: Step, one: Moving) -> int:
        """The first waypoint of the way home at which the hand has left the part."""
        pairs = self._pairs(situation_of(self._tree, step, one))
        rows = pairs.rows[pairs.left]
        away = self._cell.policy.margin + ROOM
        for number, values in enumerate(one.path):
            self._space.look(self._with(step, one, values))
            if all(self._space.distance(int(row)) >= away for row in rows):
                return number
        if np.diff(one.path, axis=0).any():
            problem = "the hand never leaves the part that it has let go of"
            self._findings.append(Finding(problem, one.arm.name, one.leg.name))
        return len(one.path)

    # -- arms that move at once -------------------------------------------------------------

    def _together(self, step: Step) -> None:
        """Arms against each other: at any speeds, or in step where the plan says so."""
        first, second = step.moving
        pairs = self._pairs(situation_of(self._tree, step, first, second))
        numbers = self._numbers[first.arm.name], self._numbers[second.arm.name]
        pairs = pairs.among(pairs.between(*numbers))
        in_step = self._plan.guarantee is Guarantee.SYNCHRONISED
        if in_step and are_in_step([first.leg, second.leg]):
            both = [self._tree.columns[one.arm.name] for one in step.moving]
            path = np.hstack([first.path, second.path])
            motion, zone = self._cell.controller.motion, self._cell.policy.zone
            sets: list[tuple[Sets, ...]] = [
                (s,) for s in moved(np.concatenate(both), path, motion, zone)
            ]
            # At its end the fingers of both move, in any order.
            sets.append(tuple(fingers_of(self._tree, one) for one in step.moving))
        else:
            ways = (course_of(self._cell, self._tree, one) for one in step.moving)
            sets = list(product(*ways))
        self._ask(step, first, tuple(sets), pairs, second)

    def _apart(self, step: Step) -> Iterator[tuple[str, str, Floats]]:
        """Distances between the arms [m] at the waypoints of each leg, shoulders left out."""
        if len(self._cell.arms) < 2:
            return
        for one in step.moving:
            q = np.tile(step.base, (len(one.path), 1))
            for other in step.moving:
                times = np.asarray(one.leg.t)
                at = [np.interp(times, other.leg.t, column) for column in other.path.T]
                q[:, self._tree.columns[other.arm.name]] = np.stack(at, axis=1)
            yield one.arm.name, one.leg.name, self._smallest(q, self._hands)

    def _smallest(self, q: Floats, pairs: Pairs) -> Floats:
        """The smallest distances (k,) [m] of some pairs at configurations (k, nq)."""
        items, which = (each.ravel() for each in np.mgrid[: len(q), : len(pairs.rows)])
        rows, commons = pairs.rows[which], pairs.commons[which]
        most = np.full(len(items), FAR_SIGHT)
        lower, _, _ = self._space.bounds(q, np.zeros_like(q), items, rows, commons, most)
        lower = lower.reshape(len(q), -1)
        smallest = np.full(len(q), FAR_SIGHT)
        for number, whole in enumerate(q):
            self._space.look(whole)
            for k in np.argsort(lower[number], kind="stable").tolist():
                if lower[number, k] >= smallest[number]:
                    break
                distance = self._space.distance(int(pairs.rows[k]))
                smallest[number] = min(smallest[number], distance)
        return smallest

    # -- asking ---------------------------------------------------------------------------

    def _ask(
        self,
        step: Step,
        one: Moving,
        sets: tuple[tuple[Sets, ...], ...],
        pairs: Pairs,
        other: Moving | None = None,
    ) -> Found:
        is_free = any(each.leg.name not in STRAIGHT for each in (one, other) if each is not None)
        count, stated, resolution = len(one.path), None, self._resolution
        if self._stated is not None:
            stated = self._claim(one, is_alone=other is None)
            if is_free:
                stated, resolution = np.maximum(stated, self._stated.clearance), TIGHT
        found = search(self._space, step.base, sets, pairs, resolution, count, stated=stated)
        if found.is_less_than(stated):
            problem = "comes nearer to something than was stated"
            self._findings.append(Finding(problem, one.arm.name, one.leg.name))
        if is_free:
            self._asked.append(_Question(step, one, sets, pairs, found))
        if found.gave_up:
            problem = "is near something for too long to be proven"
            self._findings.append(Finding(problem, one.arm.name, one.leg.name))
        if found.violation is not None:
            problem = f"closer than {found.violation.margin * 1e3:.1f} mm"
            if other is not None:
                problem += f", while arm {other.arm.name} is on its leg {other.leg.name}"
            self._findings.append(self._finding(one, found.violation, problem))
        return found

    def _claim(self, one: Moving, *, is_alone: bool) -> Floats:
        """What was stated of a leg: bounds (w,) [m] after each waypoint.

        Between two arms nothing but the smallest clearance is; of a leg left out, nothing holds.
        """
        if not is_alone:
            return np.full(len(one.path), -np.inf)
        stated = self._stated.clearances if self._stated is not None else ()
        known = {(arm, leg): bounds for arm, leg, bounds in stated}
        bounds = known.get((one.arm.name, one.leg.name))
        if bounds is None or bounds.shape != (len(one.path),):
            bounds = np.full(len(one.path), np.inf)
        return bounds

    def _closest(self) -> tuple[float, Finding | None]:
        """The smallest clearance of free legs, from below, and where that was measured."""
        bound = min((float(one.found.bounds.min()) for one in self._asked), default=SIGHT)
        measured = [
            (one.found.nearest, one) for one in self._asked if one.found.nearest is not None
        ]
        if not measured:
            return bound, None
        state, where = min(measured, key=lambda one: one[0].distance)
        within, bound = state.distance, SIGHT
        for asked in self._asked:
            close = np.flatnonzero(asked.found.bounds < within - TIGHT)
            if len(close) == 0 or asked.found.violation is not None or asked.found.gave_up:
                bound = min(bound, float(asked.found.bounds.min()))
                continue
            self._put(asked.step)
            sets = tuple(
                (blocks[0].only(np.isin(blocks[0].at, close)), *blocks[1:]) for blocks in asked.sets
            )
            # How near, not whether too near: that has been answered.
            shown = asked.pairs.among(asked.pairs.shown)
            pairs = shown.keeping(np.full(len(shown.rows), -np.inf))
            base, count = asked.step.base, len(asked.one.path)
            again = search(self._space, base, sets, pairs, TIGHT, count, within)
            known = asked.found.bounds if again.gave_up else again.bounds
            bound = min(bound, float(known.min()))
            if again.nearest is not None and again.nearest.distance < within:
                within, state, where = again.nearest.distance, again.nearest, asked
        return min(bound, within), self._finding(where.one, state, "smallest clearance")

    def _with(self, step: Step, one: Moving, values: Floats) -> Floats:
        q = step.base.copy()
        q[self._tree.columns[one.arm.name]] = values
        return q

    def _finding(self, one: Moving, state: Nearest, problem: str) -> Finding:
        columns = self._tree.columns[one.arm.name][: len(one.arm.joints)]
        labels, q = self._table.labels(state.row), state.q[columns]
        return Finding(problem, one.arm.name, one.leg.name, state.at[0], labels, state.distance, q)
