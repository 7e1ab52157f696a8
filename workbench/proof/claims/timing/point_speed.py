"""Limits of the speed of the TCP and of points: whether a plan keeps them, and how fast it gets.

As in `pace` a leg holds where there is a motion as planned; here no point may be faster either: the
bound on points is one more column of slopes, whose speed is at most 1 and whose acceleration is not
limited.  What is stated is greater: no motion along the way that keeps all limits is faster.
"""

from collections.abc import Iterator

import numpy as np

from workbench.model.cell import Cell
from workbench.model.derived.speed_limits import effective_mass, limits_speed, speed_limits
from workbench.model.geometry import Floats
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import SpeedBound
from workbench.model.plan import Guarantee, Plan, Violation, are_in_step
from workbench.proof.claims.stages import MovingArm, MovingStep, steps_of
from workbench.proof.claims.timing.fastest import (
    ceilings,
    fastest,
    find_infeasible_segment,
    seconds,
)
from workbench.proof.claims.timing.pace import LIMIT_TOLERANCE, from_rest_to_rest, marks_of
from workbench.proof.claims.timing.point_bounds import PointBounds
from workbench.proof.engine.robot import Tree

SHARES_TRIED = (0.98, 1.0, 0.95)
"""Of the limits of points, with which a motion is tried: planning leaves a little of them."""

PIECES = 32
"""Of a way from rest to rest."""

FINER = (1, 2, 4, 8)
"""Into how many each piece is cut, until no more than `ROUGH` of a bound is for what is between."""

ROUGH = 0.003


def speed_claims(
    cell: Cell, tree: Tree, plan: Plan
) -> tuple[tuple[Violation, ...], tuple[SpeedBound, ...]]:
    """Legs on which points are too fast, and how fast each leg can be; nothing without limits."""
    if not (limits_speed(cell) or plan.is_stir_plan or plan.is_tool_plan):
        return (), ()
    bounds = PointBounds(cell, tree, plan)
    violations: list[Violation] = []
    stated: list[SpeedBound] = []
    for step in steps_of(cell, tree, plan):
        legs = [arm_motion.leg for arm_motion in step.moving]
        is_one = plan.guarantee is Guarantee.SYNCHRONISED and are_in_step(legs) and cell.zone > 0.0
        for some in [list(step.moving)] if is_one else [[moving] for moving in step.moving]:
            together = _Together(cell, bounds, step, some)
            violations += together.violations()
            stated += together.stated()
    return tuple(violations), tuple(stated)


def _limits(cell: Cell, moving: MovingArm) -> tuple[float, float]:
    """How fast [m/s] the TCP and any point may be on a leg."""
    leg = moving.leg
    return speed_limits(cell, moving.arm, leg.holding, leg.name)


class _Together:
    """Legs that have one clock."""

    def __init__(
        self, cell: Cell, bounds: PointBounds, step: MovingStep, some: list[MovingArm]
    ) -> None:
        self._cell, self._some = cell, some
        robot, share = cell.robot, cell.policy.speed
        self._velocity = np.concatenate([robot.limits(m.arm.joints)[2] * share for m in some])
        self._acceleration = np.concatenate([m.arm.acceleration for m in some])
        self._limits = [_limits(cell, m) for m in some]
        self._steps = np.diff(np.hstack([m.leg.q for m in some]), axis=0)
        corners = cell.controller.motion.corners
        self._rounded = self._of(bounds, step, cell.zone) if cell.zone > 0.0 else None
        stops = cell.zone == 0.0 or corners == "blend"
        self._stopping = self._of(bounds, step, 0.0) if stops else None

    def _of(self, bounds: PointBounds, step: MovingStep, zone: float) -> "_Marked":
        """Marks along the way, with corners rounded or not, as fine as it takes."""
        for finer in FINER[:-1]:
            marked, share = self._with_marks(bounds, step, zone, finer)
            if share <= ROUGH:
                return marked
        return self._with_marks(bounds, step, zone, FINER[-1])[0]

    def _with_marks(
        self, bounds: PointBounds, step: MovingStep, zone: float, finer: int
    ) -> "tuple[_Marked, float]":
        """Marks, and the share of the bounds there that stands for what lies between them."""
        if zone > 0.0:
            slopes, widths = marks_of(self._steps, zone, finer)
            start = np.concatenate([m.leg.q[0] for m in self._some])
            moves = (slopes[:-1] + slopes[1:]) / 2 * widths[:, None]
            q = start + np.vstack([0.0 * start, np.cumsum(moves, axis=0)])
        else:
            count = PIECES * finer
            at = np.linspace(0.0, 1.0, count + 1)[:, None]
            starts = np.hstack([m.leg.q[:-1] for m in self._some])
            q = (starts[:, None] + at * self._steps[:, None]).reshape(-1, starts.shape[1])
            slopes = np.repeat(self._steps, count + 1, axis=0)
            widths = np.tile(np.append(np.full(count, 1.0 / count), 0.0), len(starts))[:-1]
        column, points, shares, rough = 0, [], [], 0.0
        for moving, limits in zip(self._some, self._limits, strict=True):
            mine = slice(column, column := column + len(moving.arm.joints))
            found, extra = bounds.marks(step, moving, q[:, mine], slopes[:, mine], widths)
            points.append(found)
            shares.append((found / np.array(limits)).max(axis=1))
            rough = max(rough, extra)
        return _Marked(slopes, widths, points, np.max(shares, axis=0)), rough

    def violations(self) -> Iterator[Violation]:
        """Where no motion passes the waypoints as planned with every point slow enough."""
        times = np.diff(self._some[0].leg.t)
        rows = [self._row_rounded(times), self._row_stopping(times)]
        if any(m.arm.jerk is not None for m in self._some):
            rows = [0]  # nothing is known of how fast points are then
        if np.any(times <= 0) or any(row == -1 for row in rows):
            return
        row = max(row for row in rows if row is not None)
        first = self._some[0]
        most = _limits(self._cell, first)
        yield Violation(
            ProofText.POINT_TOO_FAST(most=min(most)), first.arm.name, first.leg.name, row
        )

    def _row_rounded(self, times: Floats) -> int | None:
        """The first way that is too fast with corners rounded, -1 for none; None for no corners."""
        if (marked := self._rounded) is None:
            return None
        slopes, widths = np.column_stack([marked.slopes, marked.shares]), marked.widths
        pieces = len(widths) // len(times)
        most = ceilings(slopes, np.append(self._velocity * LIMIT_TOLERANCE, 1.0))
        for row, planned in enumerate(times.tolist()):
            first, last = row * pieces, (row + 1) * pieces
            if planned < seconds(most[first : last + 1], widths[first:last]):
                return row
        acceleration = np.append(self._acceleration * LIMIT_TOLERANCE, np.inf)
        rows: list[int] = []
        for share in SHARES_TRIED:
            quick = self._quick(marked, share)
            rows.append(find_infeasible_segment(slopes, widths, quick, most, acceleration, times))
            if rows[-1] < 0:
                return -1
        return max(rows)

    def _row_stopping(self, times: Floats) -> int | None:
        """The same from rest to rest on each way; None where the arm does not stop there."""
        if (marked := self._stopping) is None:
            return None
        # A tolerance is for sums of rounded values: of points it is in the bound already.
        steps = np.column_stack([self._steps, self._full_shares(marked) * LIMIT_TOLERANCE])
        velocity = np.append(self._velocity, 1.0)
        found = from_rest_to_rest(steps, times, velocity, np.append(self._acceleration, np.inf))
        return -1 if found is None else found[1]

    def _full_shares(self, marked: "_Marked") -> Floats:
        """The largest share (m,) on each straight segment."""
        return np.asarray(marked.shares.reshape(len(self._steps), -1).max(axis=1))

    def _quick(self, marked: "_Marked", share: float = 1.0) -> Floats:
        """Squared speeds (k,) [1/s2] of the fastest motion with a share of the points' limits."""
        slopes = np.column_stack([marked.slopes, marked.shares])
        limits = np.append(self._velocity, share), np.append(self._acceleration, np.inf)
        return fastest(slopes, marked.widths, *limits)

    def stated(self) -> Iterator[SpeedBound]:
        """How fast the TCP and any point of each arm can be."""
        squares: list[tuple[_Marked, Floats]] = []
        if self._rounded is not None:
            squares.append((self._rounded, self._squares_rounded(self._rounded)))
        if self._stopping is not None:
            squares.append((self._stopping, self._squares_stopping(self._stopping)))
        for number, (moving, limits) in enumerate(zip(self._some, self._limits, strict=True)):
            fast = np.zeros(2)
            for marked, x in squares:
                points = marked.points[number]
                most = np.maximum(points[:-1], points[1:]) * np.sqrt(x)[:, None]
                fast = np.maximum(fast, most.max(axis=0))
            tcp, point = np.minimum(fast * LIMIT_TOLERANCE, limits).tolist()
            mass = effective_mass(self._cell, moving.arm, moving.leg.holding)
            yield SpeedBound(moving.arm.name, moving.leg.name, tcp, point, mass)

    def _squares_rounded(self, marked: "_Marked") -> Floats:
        """The squared speeds (k - 1,) [1/s2] that no motion exceeds in the pieces between marks."""
        x, slopes, widths = self._quick(marked), marked.slopes, marked.widths
        columns = np.column_stack([slopes, marked.shares])
        steep = np.maximum(np.abs(columns[:-1]), np.abs(columns[1:]))
        limits = np.append(self._velocity, 1.0)
        ceiling = (np.min(limits / np.maximum(steep, 1e-12), axis=1)) ** 2
        # Between marks it may go up, and down again, as hard as the joints may accelerate.
        flat = np.minimum(np.abs(slopes[:-1]), np.abs(slopes[1:]))
        bends = np.abs(np.diff(slopes, axis=0)) / widths[:, None]
        highest = np.maximum(x[:-1], x[1:])[:, None]
        push = np.min((self._acceleration + bends * highest) / np.maximum(flat, 1e-12), axis=1)
        return np.minimum(ceiling, (x[:-1] + x[1:]) / 2 + push * widths)

    def _squares_stopping(self, marked: "_Marked") -> Floats:
        """The same from rest to rest on each way."""
        steps = np.abs(np.column_stack([self._steps, self._full_shares(marked)]))
        limits = np.append(self._velocity, 1.0)
        full = np.min(limits / np.maximum(steps, 1e-12), axis=1) ** 2
        push = np.min(self._acceleration / np.maximum(steps[:, :-1], 1e-12), axis=1)
        pieces = len(marked.slopes) // len(steps) - 1
        far = np.arange(1, pieces + 1) / pieces
        ramps = 2.0 * push[:, None] * np.minimum(far, far[::-1])
        x = np.column_stack([np.minimum(full[:, None], ramps), np.zeros(len(steps))])
        return np.asarray(x.reshape(-1)[:-1])


class _Marked:
    """Slopes (k, n), widths (k - 1,), bounds (k, 2) [m] by arm, and shares (k,) of the limits."""

    def __init__(
        self, slopes: Floats, widths: Floats, points: list[Floats], shares: Floats
    ) -> None:
        self.slopes, self.widths, self.points, self.shares = slopes, widths, points, shares
