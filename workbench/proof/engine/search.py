"""Searches sets of configurations by halving: whether bodies come too near, and how near.

At the middle of a set two bodies are `d` apart.  Nothing in the set brings them nearer by more than
`m`, the sum of what each joint may move them.  So `d - m` is a lower bound for the whole set, and
so is how far they stay apart along any direction.  Where neither is enough, the set is halved.

The search accepts a set if both bodies keep the margin at its middle and approach by at most the
resolution.  The true distance may fall short of the margin by that much.  A positive margin below
the resolution replaces it, but never below `FINEST_RESOLUTION`.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from workbench.model.geometry import Floats, Ints
from workbench.proof.engine.batch import Batch, around, firsts, inside, spread
from workbench.proof.engine.frames import BodyPoses, SetExtents, poses
from workbench.proof.engine.pairs import Pairs
from workbench.proof.engine.sets import Sets
from workbench.proof.engine.sieve import (
    OpenPairs,
    PairQuery,
    planes,
    select_nearest_pairs,
    select_pairs_in_sight,
    sieve,
)
from workbench.proof.engine.space import Space

SIGHT = 0.1
"""[m] Distances are computed up to here."""

SHORT_SHARE, SHORT_BY = 0.3, 0.002
"""A lower bound is good enough within this share of the distance, or within this distance [m]."""

MOST_HALVES = 100_000
"""The proof gives up on a motion after this many halvings: it is close to a body for too long."""

RUN = 16
"""Groups of sets, of each arm, that are checked together at first."""

HALVES = 4096
"""Sets that are checked together: what is worked out of them takes some kB for each."""

FINEST_RESOLUTION = 0.00005
"""[m] The resolution where what is to be kept is still less."""

TIGHT = 0.0002
"""[m] How well the smallest distance of all is wanted."""

ROUNDING = 1e-6
"""[m] Another machine rounds otherwise."""

USUALLY_SHORT_BY = 0.04
"""[m] By about this much bounds fall short of distances; only a matter of speed."""


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """The two bodies that came nearest, measured: how near [m], at `q` (nq,), after a waypoint."""

    row: int
    distance: float
    margin: float
    q: Floats
    at: int


@dataclass(frozen=True, slots=True, eq=False)
class SearchGoal:
    """How many `waypoints` there are, and how well the distances after each are wanted.

    `within` [m]: the nearest of all is wanted to this, whatever waypoint it follows; None: as
    `SHORT_SHARE`.  `stated` (w,) [m] are bounds that are only checked; None: they are wanted.
    Distances up to `sight` [m] are reported.
    """

    waypoints: int
    within: float | None = None
    stated: Floats | None = None
    sight: float = SIGHT


@dataclass(slots=True, eq=False)
class SearchResult:
    """What a search brings.

    `too_near` is a state at which two bodies are nearer than they may be; None when there is none.
    `bounds` (w,) [m]: nothing that is shown is nearer than this after each waypoint; `nearest` is
    the nearest of them that was measured.  Where a search `gave_up`, none of it counts.
    """

    bounds: Floats
    too_near: Nearest | None = None
    nearest: Nearest | None = None
    gave_up: bool = False

    def is_less_than(self, stated: Floats | None) -> bool:
        """Whether something comes nearer than was stated, (w,) [m]; another machine may round."""
        return stated is not None and bool((self.bounds < stated - ROUNDING).any())


def search(
    space: Space,
    base: Floats,
    sets: Sequence[tuple[Sets, ...]],
    pairs: Pairs,
    resolution: float,
    goal: SearchGoal,
) -> SearchResult:
    """Look at all configurations of some sets.

    Args:
        space: with all bodies where they belong.
        base: whole configuration (nq,) of what does not move.
        sets: each entry is a product: sets of different columns, every combination counts.
        pairs: what is compared, with what it has to keep.
        resolution: [m] see above.
        goal: `bounds` has a value after each of its waypoints.
    """
    branch_and_bound = _Search(space, base, pairs, resolution, _Wanted(goal))
    for blocks in sets:
        for some in product(*(block.runs(RUN) for block in blocks)):
            branch_and_bound.look(some)
            if branch_and_bound.is_over():
                return branch_and_bound.found
    return branch_and_bound.found


class _Wanted:
    """Required accuracy of the distances after each waypoint.

    `nearest` (w,) [m] are the smallest measured distances; a bound above `goals` (w,) [m] is good
    enough.  Goals are `by_waypoint` unless only the smallest distance of all is required.
    """

    def __init__(self, goal: SearchGoal) -> None:
        self._within = within = goal.within
        self.stated = stated = goal.stated
        sight, waypoints = goal.sight, goal.waypoints
        self.by_waypoint = within is None
        self.nearest = [sight] * waypoints
        if stated is not None:
            self.goals: list[float] = stated.tolist()
        elif within is not None:
            self.goals = [min(within, sight) - TIGHT] * waypoints
        else:
            self.goals = [_enough(sight)] * waypoints

    def note_distance(self, at: int, distance: float) -> None:
        """Something is so near [m] after a waypoint, nearer than all else that was measured."""
        self.nearest[at] = distance
        if self._within is not None:
            self.goals[:] = [min(self.goals[0], distance - TIGHT)] * len(self.goals)
        elif self.stated is None:
            self.goals[at] = _enough(distance)


def _enough(distance: float) -> float:
    return distance - max(SHORT_SHARE * distance, SHORT_BY)


class _Search:
    """What is asked of all sets alike, and what was `found`."""

    def __init__(
        self, space: Space, base: Floats, pairs: Pairs, resolution: float, wanted: _Wanted
    ) -> None:
        self._space, self._base, self._pairs, self._resolution = space, base, pairs, resolution
        self._wanted, self._halves = wanted, 0
        first, second = space.table.first[pairs.rows], space.table.second[pairs.rows]
        self._asked = PairQuery(first, second, pairs.commons, pairs.margins, pairs.shown)
        # Where little is to be kept, it must not be lost between two looks.
        finer = np.where(pairs.margins > 0.0, pairs.margins.clip(min=FINEST_RESOLUTION), resolution)
        self._fine = np.minimum(resolution, finer)
        self.found, self._sight = SearchResult(np.array(wanted.nearest)), wanted.nearest[0]

    def is_over(self) -> bool:
        """Whether nothing more can change what comes of the search."""
        found = self.found
        is_worse = found.is_less_than(self._wanted.stated)
        return found.gave_up or found.too_near is not None or is_worse

    def look(self, blocks: tuple[Sets, ...]) -> None:
        """Look at every set of one block, with every one of another: first at what holds many."""
        batch, split = around(self._base, blocks), len(blocks[0].at)
        sides: Ints = np.zeros(len(self._space.joints), np.int64)
        if len(blocks) > 1:
            moved = self._space.tree.ancestors[self._space.joints][:, blocks[1].columns]
            sides[moved.any(axis=1)] = 1
        _, spreads, world = self._world(batch, self._asked.first, self._asked.second, False)
        arrays = self._space.arrays
        items = select_pairs_in_sight(self._asked, self._sight, sides, split, arrays, world)
        sets = firsts(self._base, blocks)
        q, around_q, there = self._world(sets, self._asked.first, self._asked.second, True)
        compiled = self._space.normals, self._space.chain, arrays, there, around_q
        if self._wanted.by_waypoint:
            # What seems nearest after each waypoint tells what is far enough; where that was
            # stated, the way from one to the other shows it for many sets.
            count = len(self.found.bounds)
            seem = items[select_nearest_pairs(items, self._asked, sets.at, count, arrays, there)]
            planes(seem, self._ways(sets, q, seem), self._asked, *compiled)
        close = self._sift(batch, items, world, spreads)
        if len(close.items) and not self.is_over():
            # The direction in which a pair is apart in one set often is good for others.
            order = np.argsort(close.whole_bounds, kind="stable")
            once = close.items[order[np.unique(close.items[order, 2], return_index=True)[1]]]
            once = once[~self._space.has_direction(self._pairs.rows[once[:, 2]])]
            planes(once, self._ways(sets, q, once), self._asked, *compiled)
            if not self.is_over():
                self._exhaust(*inside(self._base, blocks, close.items))

    def _ways(self, batch: Batch, q: Floats, items: Ints) -> Floats:
        """Measure pairs in the middles `q` (k, nq) of sets: ways (n, 3) [m] from one to other."""
        space, asked, ways = self._space, self._asked, np.zeros((len(items), 3))
        looked = (-1, -1)
        for n in np.lexsort(items.T[1::-1]).tolist():
            first, second, pair = items[n].tolist()
            if looked != (first, second):
                looked = (first, second)
                space.look(self._both(q[first], q[second]))
            row, place = int(self._pairs.rows[pair]), int(batch.at[[first, second]].max())
            distance, shown = space.distance(row), bool(asked.shown[pair])
            self._note(row, distance, float(asked.margins[pair]), place, shown)
            ways[n] = space.way()
        return ways

    def _exhaust(self, batch: Batch, items: Ints) -> None:
        """Look at pairs in sets (n, 3), see `Batch`, and in halves of these where needed."""
        waiting = [(batch, items)]
        while waiting:
            batch, items = waiting.pop()
            if len(batch) > HALVES:
                middle = len(items) // 2
                waiting += [batch.only(some) for some in (items[middle:], items[:middle])]
                continue
            items = self._open_pairs(batch, items)
            if self.is_over():
                return
            if len(items):
                # Twice, since a half is seldom enough.
                for _ in range(2):
                    batch, items = batch.halve(items, self._space.levers)
                waiting.append((batch, items))
                self._halves += len(batch)
                if self._halves > MOST_HALVES:
                    self.found.gave_up = True
                    return

    def _world(
        self, batch: Batch, first: Ints, second: Ints, is_motion: bool
    ) -> tuple[Floats, SetExtents, BodyPoses]:
        """The middles (k, nq) of sets, how they lie around these, and where bodies are there."""
        space = self._space
        needed = np.zeros(len(space.joints), bool)
        needed[first] = needed[second] = True
        q, spreads = spread(batch.corners, batch.sizes, is_motion)
        return q, spreads, poses(space.chain, space.arrays, q, spreads.spans, needed)

    def _sift(self, batch: Batch, items: Ints, world: BodyPoses, spreads: SetExtents) -> OpenPairs:
        space, goals = self._space, np.array(self._wanted.goals)
        return sieve(
            items, self._asked, goals, batch.at, self.found.bounds, space.normals,
            space.chain, space.arrays, world, spreads,
        )  # fmt: skip

    def _open_pairs(self, batch: Batch, items: Ints) -> Ints:
        """Look at pairs in sets (n, 3), see `Batch`; those of which halves have to be checked."""
        first, second = self._asked.first[items[:, 2]], self._asked.second[items[:, 2]]
        q, spreads, world = self._world(batch, first, second, True)
        close = self._sift(batch, items, world, spreads)
        if not len(close.items):
            return close.items
        asked, space, lower_bounds, which = (
            self._asked,
            self._space,
            close.whole_bounds,
            close.items[:, 2],
        )
        at = batch.at[close.items[:, :2]].max(axis=1)
        ways = self._measure_pairs(q, close, at)
        if ways:
            n, way = np.array(list(ways)), np.array(list(ways.values()))
            compiled = space.normals, space.chain, space.arrays, world, spreads
            lower_bounds[n] = np.fmax(
                lower_bounds[n], planes(close.items[n], way, asked, *compiled)
            )
        # What is no number is not far enough, here and below.
        is_undecided = ~(lower_bounds >= self._needs(which, at)) & (close.moves > self._fine[which])
        is_reported = asked.shown[which] & ~is_undecided
        np.minimum.at(self.found.bounds, at[is_reported], lower_bounds[is_reported])
        return close.items[is_undecided]

    def _needs(self, which: Ints, at: Ints) -> Floats:
        """Bounds (n,) [m] that are enough for pairs (n,) after waypoints (n,)."""
        margins, goals = self._asked.margins[which], np.array(self._wanted.goals)[at]
        return np.where(self._asked.shown[which], np.maximum(margins, goals), margins)

    def _measure_pairs(self, q: Floats, close: OpenPairs, at: Ints) -> dict[int, Floats]:
        """Measure pairs in the middles `q` (k, nq) of sets after waypoints (n,), nearest first.

        Better bounds are put into `close`.

        Returns:
            For those for which these are not enough, the way (3,) [m] from the one to the other.
        """
        space, wanted, found = self._space, self._wanted, self.found
        first, second, which = close.items.T
        margins = self._asked.margins[which]
        # Where it will be halved anyway, measuring would hardly save that.
        is_hopeless = close.moves > max(self._resolution, USUALLY_SHORT_BY)
        is_hopeless &= close.whole_bounds + USUALLY_SHORT_BY < self._needs(which, at)
        is_hopeless &= close.lower >= margins.clip(0.0)
        order = np.lexsort((close.whole_bounds, second, first))
        order = order[~is_hopeless[order]]
        rows, shown = self._pairs.rows[which], self._asked.shown[which]
        columns = first, second, at, rows, close.whole_bounds, close.moves, margins, shown
        columns = order, *(column[order] for column in (*columns, space.has_direction(rows)))
        ways: dict[int, Floats] = {}
        looked, goals = (-1, -1), wanted.goals
        for n, mine, theirs, place, row, bound, moves, margin, counts, is_known in zip(
            *(column.tolist() for column in columns), strict=True
        ):
            if bound >= margin and not (counts and bound < goals[place]):
                continue
            if looked != (mine, theirs):
                looked = (mine, theirs)
                space.look(self._both(q[mine], q[theirs]))
            distance = space.distance(row)
            if counts and wanted.stated is not None and distance < goals[place] - ROUNDING:
                found.bounds[place] = distance
                return {}
            self._note(row, distance, margin, place, counts)
            if found.too_near is not None:
                return {}
            bound = max(bound, distance - moves)
            close.whole_bounds[n] = bound
            if bound < margin or (counts and bound < goals[place]) or not is_known:
                ways[n] = space.way()
        return ways

    def _note(self, row: int, distance: float, margin: float, place: int, counts: bool) -> None:
        """Note what was measured of a pair after a waypoint, where that is too near or nearest."""
        is_near = not distance >= margin
        if is_near or (counts and distance < self._wanted.nearest[place]):
            state, found = Nearest(row, distance, margin, self._space.at, place), self.found
            if is_near:
                found.too_near = state
                return
            self._wanted.note_distance(place, distance)
            if found.nearest is None or distance < found.nearest.distance:
                found.nearest = state

    def _both(self, first: Floats, second: Floats) -> Floats:
        """The whole configuration (nq,) of two in each of which another arm has moved."""
        return np.where(second != self._base, second, first)
