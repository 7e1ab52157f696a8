"""Sets of whole configurations, many at once, which are halved where something may be too near."""

from dataclasses import dataclass
from functools import reduce

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.proof.engine.frames import SetExtents
from workbench.proof.engine.sets import Sets

OTHER = -1
"""Instead of a waypoint: what a second arm does is reported with the waypoints of the first."""


@dataclass(frozen=True, slots=True, eq=False)
class Batch:
    """Sets (k,), each the hull of the first `sizes` (k,) of its `corners` (k, 3, nq) [rad, m].

    `at` (k,) is the waypoint before each, or `OTHER`.

    What is asked is rows of an array (n, 3): two bodies of a pair in a set each, and the pair.
    They are the same set unless two arms move at any speeds: each set of the one arm may then be
    passed while any of the other is.  Bodies get no nearer than what both sets do to them.
    """

    corners: Floats
    sizes: Ints
    at: Ints

    def __len__(self) -> int:
        return len(self.at)

    def only(self, items: Ints) -> tuple["Batch", Ints]:
        """The sets in which something is asked, and that."""
        is_asked = np.zeros(len(self), bool)
        is_asked[items[:, :2]] = True
        kept, places = np.flatnonzero(is_asked), np.cumsum(is_asked) - 1
        asked = np.column_stack([places[items[:, :2]], items[:, 2]])
        return Batch(self.corners[kept], self.sizes[kept], self.at[kept]), asked

    def halve(self, items: Ints, levers: Floats) -> tuple["Batch", Ints]:
        """What is asked (n, 3) in both halves of a set each, cut in two through its longest edge.

        Where two sets are asked about, the longer one is cut.  `levers` (nq,) tell how much each
        value counts in a length.
        """
        corners, origins, asked = _halve(self.corners, self.sizes, items, levers)
        return Batch(corners, self.sizes[origins], self.at[origins]), asked


def around(base: Floats, blocks: tuple[Sets, ...]) -> Batch:
    """What holds the groups of one block, and of another one, as sets.

    `base` (nq,) [rad, m] is the whole configuration of what does not move.
    """
    return reduce(_join, (_whole(base, b, b.around, np.full(len(b.at), 3)) for b in blocks))


def firsts(base: Floats, blocks: tuple[Sets, ...]) -> Batch:
    """The first set of each group, where `around` has what holds the group.

    `base` (nq,) [rad, m] is the whole configuration of what does not move.
    """
    sets = [b.only(np.diff(b.groups, prepend=-1) > 0) for b in blocks]
    return reduce(_join, (_whole(base, b, b.corners, b.sizes) for b in sets))


def inside(base: Floats, blocks: tuple[Sets, ...], items: Ints) -> tuple[Batch, Ints]:
    """The sets of groups, and what is asked (n, 3) of groups for each of their sets.

    Args:
        base: (nq,) [rad, m] the whole configuration of what does not move.
        blocks: at most two, of different columns.
        items: what is asked of the groups as `around` has them.
    """
    batch = reduce(_join, (_whole(base, b, b.corners, b.sizes, b.groups) for b in blocks))
    counts = np.concatenate([np.bincount(b.groups, minlength=len(b.at)) for b in blocks])
    return batch.only(_inside(items, counts, np.cumsum(counts) - counts))


def _whole(
    base: Floats, block: Sets, corners: Floats, sizes: Ints, groups: Ints | None = None
) -> Batch:
    whole = np.empty((len(corners), 3, len(base)))
    whole[:] = base
    whole[:, :, block.columns] = corners
    return Batch(whole, sizes, block.at if groups is None else block.at[groups])


def _join(batch: Batch, other: Batch) -> Batch:
    return Batch(
        np.concatenate([batch.corners, other.corners]),
        np.concatenate([batch.sizes, other.sizes]),
        np.concatenate([batch.at, np.full(len(other), OTHER)]),
    )


@njit(cache=True)
def _inside(items: Ints, counts: Ints, starts: Ints) -> Ints:  # pragma: no cover (compiled)
    """What is asked (m, 3) of sets, from what is asked (n, 3) of groups of `counts` sets (g,)."""
    total = 0
    for n in range(len(items)):
        a, b = items[n, 0], items[n, 1]
        total += counts[a] if a == b else counts[a] * counts[b]
    asked, m = np.empty((total, 3), np.int64), 0
    for n in range(len(items)):
        a, b = items[n, 0], items[n, 1]
        for i in range(counts[a]):
            for j in range(1 if a == b else counts[b]):
                asked[m, 0] = starts[a] + i
                asked[m, 1] = starts[a] + i if a == b else starts[b] + j
                asked[m, 2] = items[n, 2]
                m += 1
    return asked


@njit(cache=True)
def spread(
    corners: Floats, sizes: Ints, is_motion: bool
) -> tuple[Floats, SetExtents]:  # pragma: no cover (compiled)
    """The middles (k, nq) [rad, m] of sets, and how the sets lie around these.

    Where a set `is_motion` its middle is one of its configurations, else in the middle of all
    values.
    """
    count, most, values = corners.shape
    middles, spans = np.empty((count, values)), np.zeros((count, values))
    changes = np.zeros((count, most, values))
    for k in range(count):
        size = sizes[k]
        for c in range(values):
            first = corners[k, 0, c]
            low, high, off = first, first, 0.0
            for m in range(1, size):
                value = corners[k, m, c]
                # These pass on what is no number.
                low, high = np.minimum(low, value), np.maximum(high, value)
                off += value - first
            middle = first + off / size if is_motion else low + (high - low) / 2
            middles[k, c] = middle
            if high > low:
                spans[k, c] = max(high - middle, middle - low)
                for m in range(size):
                    changes[k, m, c] = corners[k, m, c] - middle
    return middles, SetExtents(spans, changes, sizes)


@njit(cache=True)
def _halve(
    corners: Floats, sizes: Ints, items: Ints, levers: Floats
) -> tuple[Floats, Ints, Ints]:  # pragma: no cover (compiled)
    """Halves and what was left whole (m, 3, nq), of which sets they are (m,), and what is asked."""
    count, most, values = corners.shape
    edges, lengths = np.zeros((count, 2), np.int64), np.full(count, -1.0)
    for k in range(count):
        for m in range(sizes[k]):
            for n in range(m):
                length = 0.0
                for c in range(values):
                    length += levers[c] * abs(corners[k, m, c] - corners[k, n, c])
                if length > lengths[k]:
                    lengths[k], edges[k, 0], edges[k, 1] = length, m, n
    # Where the halves of each set are among the new ones, and where it is itself.
    cut, whole, number = np.full(count, -1), np.full(count, -1), 0
    asked = np.empty((2 * len(items), 3), np.int64)
    for n in range(len(items)):
        a, b = items[n, 0], items[n, 1]
        is_first = a == b or lengths[a] > lengths[b]
        longer, shorter = (a, b) if is_first else (b, a)
        if cut[longer] < 0:
            cut[longer], number = number, number + 2
        if a != b and whole[shorter] < 0:
            whole[shorter], number = number, number + 1
        for half in range(2):
            m, mine = 2 * n + half, cut[longer] + half
            others = mine if a == b else whole[shorter]
            asked[m, 0], asked[m, 1] = (mine, others) if is_first else (others, mine)
            asked[m, 2] = items[n, 2]
    pieces, origins = np.empty((number, most, values)), np.empty(number, np.int64)
    for k in range(count):
        if whole[k] >= 0:
            pieces[whole[k]], origins[whole[k]] = corners[k], k
        if cut[k] >= 0:
            i, j = edges[k]
            for half in range(2):
                pieces[cut[k] + half], origins[cut[k] + half] = corners[k], k
            middle = (corners[k, i] + corners[k, j]) / 2
            pieces[cut[k], i], pieces[cut[k] + 1, j] = middle, middle
    return pieces, origins, asked
