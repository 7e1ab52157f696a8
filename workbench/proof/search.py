"""Every configuration of some sets is looked at, by halving: none is too near, and how near it is.

At the middle of a set two bodies are `d` apart.  Nothing in the set brings them nearer by more than
`m`, the sum of what each joint may move them.  So `d - m` is a lower bound for the whole set.
Where it is not enough, the set is halved; where `m` is below the resolution, the middle stands for
the set, and `d - m` still is what is said of it.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product

import numpy as np

from workbench.model.geometry import Floats, Ints
from workbench.proof.motion import Sets
from workbench.proof.sieve import World, lower_to
from workbench.proof.space import Space
from workbench.proof.table import Pairs

SIGHT = 0.1
"""[m] Distances are told up to here."""

SHARE, LEAST = 0.3, 0.002
"""A lower bound is good enough that is short by this share of the distance, or by so much [m]."""

MOST_LOOKS = 50_000
"""After so many looks at one motion nothing is said of it: it is near something for too long."""

BATCH = 64
"""Sets that are looked at together."""

TIGHT = 0.0002
"""[m] How well the smallest distance of all is wanted."""

SAME = 1e-6
"""[m] Another machine rounds otherwise."""

LOOSE = 0.12
"""[m] By about this much bounds fall short of distances; only a matter of speed."""


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """The two bodies that came nearest, measured: how near [m], at `q` (nq,), after a waypoint."""

    row: int
    distance: float
    margin: float
    q: Floats
    at: tuple[int, ...]


@dataclass(slots=True, eq=False)
class Found:
    """What a search brings.

    `violation` is a state at which two bodies are nearer than they may be; None when there is none.
    `bounds` (w,) [m]: nothing that is shown is nearer than this after each waypoint; `nearest` is
    the nearest of them that was measured.  Where a search `gave_up`, none of it counts.
    """

    bounds: Floats
    violation: Nearest | None = None
    nearest: Nearest | None = None
    gave_up: bool = False

    def is_less_than(self, stated: Floats | None) -> bool:
        """Whether something comes nearer than was stated, (w,) [m]; another machine may round."""
        return stated is not None and bool((self.bounds < stated - SAME).any())


def search(
    space: Space,
    base: Floats,
    sets: Sequence[tuple[Sets, ...]],
    pairs: Pairs,
    resolution: float,
    waypoints: int,
    within: float | None = None,
    stated: Floats | None = None,
    sight: float = SIGHT,
) -> Found:
    """Look at all configurations of some sets.

    Args:
        space: with all bodies where they belong.
        base: whole configuration (nq,) of what does not move.
        sets: each entry is a product: sets of different columns, every combination counts.
        pairs: what is compared, with what it has to keep.
        resolution: [m] see above.
        waypoints: how many there are; `bounds` has a value after each.
        within: [m] the nearest is wanted to this, whatever waypoint it follows; None: as `SHARE`.
        stated: (w,) [m] bounds that are only looked whether they hold; None: they are wanted.
        sight: [m] up to here distances are told.
    """
    wanted = _Wanted(np.full(waypoints, sight), within, stated)
    found = Found(np.full(waypoints, sight))
    pending = [
        (some, *(each.ravel() for each in np.mgrid[: len(some), : len(pairs.rows)]))
        for blocks in sets
        for some in combined(blocks)
    ]
    before = space.looks
    while pending:
        some, items, which = pending.pop(0)
        close = _close(space, base, some, pairs, wanted, found, items, which)
        left = _measured(space, base, some, pairs, resolution, wanted, found, close)
        if found.violation is not None or found.is_less_than(stated):
            return found
        if space.looks - before > MOST_LOOKS:
            found.gave_up = True
            return found
        if len(left):
            pending.append(some.halved(close.items[left], close.which[left], space.levers))
    return found


@dataclass(slots=True, eq=False)
class _Wanted:
    """How well distances after each waypoint are wanted: `nearest` (w,) [m] measured so far."""

    nearest: Floats
    within: float | None
    stated: Floats | None

    def goal(self, at: Ints) -> Floats:
        """A bound (n,) [m] above this is good enough, after these waypoints (n,)."""
        if self.stated is not None:
            return self.stated[at]
        if self.within is not None:
            return np.full(len(at), min(self.within, float(self.nearest.min())) - TIGHT)
        nearest = self.nearest[at]
        return nearest - np.maximum(SHARE * nearest, LEAST)


@dataclass(frozen=True, slots=True, eq=False)
class _Combined:
    """One set of each of some blocks, combined: (k,) sets of whole configurations."""

    blocks: tuple[Sets, ...]

    def __len__(self) -> int:
        return len(self.blocks[0].at)

    @property
    def at(self) -> Ints:
        """The waypoint (k,) after which the first of them is."""
        return self.blocks[0].at

    def middles(self, base: Floats) -> Floats:
        """Whole configurations (k, nq) within the sets."""
        q = np.tile(base, (len(self), 1))
        for block in self.blocks:
            q[:, block.columns] = block.middles
        return q

    def spans(self, size: int) -> Floats:
        """How far each value (k, nq) is from that of the middle at most."""
        d = np.zeros((len(self), size))
        for block in self.blocks:
            d[:, block.columns] = block.spans
        return d

    def corners(self, base: Floats, middles: Floats) -> Floats:
        """What each corner of each block adds to the middle, as (k, blocks, m, nq)."""
        most = max(block.corners.shape[1] for block in self.blocks)
        change = np.zeros((len(self), len(self.blocks), most, len(base)))
        for p, block in enumerate(self.blocks):
            off = block.corners - middles[:, None, block.columns]
            change[:, p, : off.shape[1], block.columns] = np.moveaxis(off, 2, 0)
        return change

    def halved(self, items: Ints, which: Ints, weights: Floats) -> "tuple[_Combined, Ints, Ints]":
        """The halves of some sets, and which pairs are still open in each.

        Of blocks, the one is halved in which joints have farther to go.
        """
        open_sets, places = np.unique(items, return_inverse=True)
        blocks = tuple(block.only(open_sets) for block in self.blocks)
        moves = np.stack([(b.spans * weights[b.columns]).sum(axis=1) for b in blocks])
        longer = moves.argmax(axis=0)
        halves: list[Sets] = []
        for number, block in enumerate(blocks):
            both = block.halves(weights[block.columns])
            twice = np.repeat(block.corners, 2, axis=0)
            is_cut = np.repeat(longer == number, 2)[:, None, None]
            halves.append(Sets(block.columns, np.where(is_cut, both.corners, twice), both.at))
        return (
            _Combined(tuple(halves)),
            np.concatenate([2 * places, 2 * places + 1]),
            np.tile(which, 2),
        )


def combined(blocks: tuple[Sets, ...]) -> Iterator[_Combined]:
    """One set of each block with one of every other, in batches."""
    sizes = [range(len(block.at)) for block in blocks]
    grid = np.array(list(product(*sizes)), dtype=np.int64)
    for start in range(0, len(grid), BATCH):
        some = grid[start : start + BATCH]
        yield _Combined(tuple(block.only(some[:, k]) for k, block in enumerate(blocks)))


@dataclass(frozen=True, slots=True, eq=False)
class _Close:
    """Pairs that bounds alone could not tell apart, each (n,) in one of the sets.

    `lower` [m] is a bound at the middle `q` (k, nq) of the set, `moves` [m] what to take off it.
    `world` is where everything is at the middles, `spans` are how far sets go.
    """

    q: Floats
    spans: Floats
    world: World
    items: Ints
    which: Ints
    lower: Floats
    moves: Floats


def _close(
    space: Space,
    base: Floats,
    some: _Combined,
    pairs: Pairs,
    wanted: _Wanted,
    found: Found,
    items: Ints,
    which: Ints,
) -> _Close:
    """Pairs in sets that the boxes around bodies do not tell apart."""
    q = some.middles(base)
    is_shown, at = pairs.shown[which], some.at[items]
    goals = np.where(is_shown, wanted.goal(some.at)[items], -np.inf)
    needs = np.maximum(pairs.margins[which], goals)
    rows, commons = pairs.rows[which], pairs.commons[which]
    spans = some.spans(len(base))
    lower, moves, world = space.bounds(q, spans, items, rows, commons, needs)
    is_close = lower - moves < needs
    lower_to(found.bounds, at, lower - moves, is_shown & ~is_close)
    order = np.flatnonzero(is_close)
    order = order[np.lexsort((lower[order], items[order]))]
    return _Close(q, spans, world, items[order], which[order], lower[order], moves[order])


def _measured(
    space: Space,
    base: Floats,
    some: _Combined,
    pairs: Pairs,
    resolution: float,
    wanted: _Wanted,
    found: Found,
    close: _Close,
) -> list[int]:
    """Measure what is close, nearest first; which of it has to be looked at in halves."""
    is_shown, margins = pairs.shown[close.which], pairs.margins[close.which]
    at, goals = some.at.tolist(), wanted.goal(some.at)
    needs = np.where(is_shown, np.maximum(margins, goals[close.items]), margins)
    # Where it will be halved anyway, measuring would hardly save that.
    is_hopeless = close.moves > np.maximum(resolution, LOOSE)
    is_hopeless &= (close.lower + LOOSE < needs + close.moves) & (close.lower >= margins.clip(0.0))
    left: list[int] = np.flatnonzero(is_hopeless).tolist()
    corners: Floats | None = None
    looked, goals = -1, goals.tolist()
    rest = np.flatnonzero(~is_hopeless)
    columns = (rest, close.items, close.which, margins, close.moves, close.lower, is_shown)
    rows = zip(
        *(c[rest].tolist() if c is not rest else rest.tolist() for c in columns), strict=True
    )
    for number, item, which, margin, move, lower, counts in rows:
        told = lower - move
        need = max(margin, goals[item]) if counts else margin
        if told < need:
            if looked != item:
                space.look(close.q[item])
                looked = item
            row = int(pairs.rows[which])
            distance = space.distance(row)
            told = distance - move
            if counts and wanted.stated is not None and distance < goals[item] - SAME:
                found.bounds[at[item]] = distance
                return []
            if distance < margin or (counts and distance < wanted.nearest[at[item]]):
                places = tuple(int(block.at[item]) for block in some.blocks)
                state = Nearest(row, distance, margin, close.q[item], places)
                if distance < margin:
                    found.violation = state
                    return []
                wanted.nearest[at[item]] = distance
                goals = wanted.goal(some.at).tolist()
                if found.nearest is None or distance < found.nearest.distance:
                    found.nearest = state
            need = max(margin, goals[item]) if counts else margin
            if told < need <= distance and move > resolution:
                if corners is None:
                    corners = some.corners(base, close.q)
                common = int(pairs.commons[which])
                within = space.within(row, common, item, close.world, close.spans, corners)
                told = max(told, within)
        if told < need and move > resolution:
            left.append(number)
        elif counts:
            found.bounds[at[item]] = min(found.bounds[at[item]], told)
    return left
