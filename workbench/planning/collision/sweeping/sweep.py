"""The continuous check of a chain of curves in one compiled piece, for the planner.

The same halving as in `motion`, with distances by `gjk` instead of Coal.  The proof
does not use it: what the planner found is measured again with another library.
"""

from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.collision.sweeping.groups import Groups, groups_of, move_to_front
from workbench.planning.collision.sweeping.look import (
    ANY,
    FIRST,
    IS_CLEAR,
    NAMED,
    TOO_LONG,
    Model,
    look_at,
)
from workbench.planning.collision.sweeping.scratch import Scratch, scratch_for
from workbench.planning.compiled import njit_in_place

CHECKED_TOGETHER = 0.03
"""[rad] Curves one after the other, as corners are made of, are checked together up to here."""


@njit(cache=True)
def sweep_chain(
    points: Floats,
    columns: Ints,
    base: Floats,
    resolution: float,
    among: Ints,
    margins: Floats,
    commons: Ints,
    model: Model,
) -> tuple[int, int, Floats, int]:
    """Go through a chain of curves, one after the other, until a pair touches.

    Args:
        points: their control points (k, 3, n).
        columns: places of the n joints in the whole configuration.
        base: whole configuration (nq,) of the others.
        resolution: [m] see `motion`.
        among: pairs that are checked; see `bounds.close_pairs`, as the next two.
        margins: see there.
        commons: see there.
        model: of what moves.

    Returns:
        How many curves are clear; on the next one, of the pairs that touch at the first state where
        one does: that with the lowest number, and the configuration (n,) there; or `IS_CLEAR` when
        there is no next one, or `TOO_LONG` when that takes more room than there is; and how many
        states were checked.
    """
    scratch = scratch_for(columns, base, model.tree, model.boxes, model.cores)
    groups = groups_of(among, margins, model.first, model.second, model.boxes.joint)
    looks, curve = 0, FIRST
    while curve < len(points):
        last = _narrow(points, curve)
        if last > curve + 1:
            looks += 1
            if _is_box_clear(
                points, curve, last, columns, groups, margins, commons, model, scratch
            ):
                curve = last
                continue
        for k in range(3):
            for i in range(len(columns)):
                scratch.pending[0, k, i] = points[curve, k, i]
        found, looked = curve_swept(
            columns, resolution, groups, margins, commons, model, scratch, NAMED
        )
        looks += looked
        if found != IS_CLEAR:
            return curve, found, scratch.middle, looks
        curve += 1
    return len(points), IS_CLEAR, scratch.middle, looks


@njit(cache=True)
def _narrow(points: Floats, first: int) -> int:
    """Where curves (k, 3, n) from `first` on turn a joint by more than `CHECKED_TOGETHER`."""
    low, high = points[first, 0].copy(), points[first, 0].copy()
    for curve in range(first, len(points)):
        for i in range(points.shape[2]):
            for k in range(3):
                low[i] = min(low[i], points[curve, k, i])
                high[i] = max(high[i], points[curve, k, i])
            if high[i] - low[i] > CHECKED_TOGETHER:
                return curve
    return len(points)


# Part of `sweep_chain`: otherwise all of `look_at` is compiled once more.
@njit(cache=True, inline="always")
def _is_box_clear(
    points: Floats,
    first: int,
    last: int,
    columns: Ints,
    groups: Groups,
    margins: Floats,
    commons: Ints,
    model: Model,
    scratch: Scratch,
) -> bool:
    """Whether one look states that the curves from `first` up to `last` are clear, all at once.

    It is at the middle of the box around them, which need not be on any: if anything is near there
    nothing is said.
    """
    count = len(groups.order)
    if count > len(scratch.open_pairs):
        return False
    for i in range(len(columns)):
        low, high = points[first, 0, i], points[first, 0, i]
        for curve in range(first, last):
            for k in range(3):
                low = min(low, points[curve, k, i])
                high = max(high, points[curve, k, i])
        scratch.q[columns[i]] = (low + high) / 2
        scratch.d[columns[i]] = scratch.bent[columns[i]] = (high - low) / 2
        scratch.ahead[columns[i]] = 0.0
    for k in range(count):
        scratch.open_pairs[k] = -1 - groups.order[k]
    found, kept, _ = look_at(FIRST, count, count, margins, commons, model, groups, scratch, ANY)
    return found == IS_CLEAR and kept == count


@njit_in_place
def curve_swept(
    columns: Ints,
    resolution: float,
    groups: Groups,
    margins: Floats,
    commons: Ints,
    model: Model,
    scratch: Scratch,
    names: bool,
) -> tuple[int, int]:
    """Look at the one curve that lies in `scratch.pending[0]` until a pair touches.

    Arguments as those of `sweep_chain`: `margins` (p,) [m]; `columns` (n,) and `commons` (p,) are
    numbers, without a unit.  The scratch must be that of these `columns`
    and of this model, the `groups` those of the pairs to be checked.  Which pair of several
    touches is the one with the lowest number if it `names` it, or else any: what touched moves to
    the front, where it is checked first the next time.

    Returns:
        The pair that touches at `scratch.middle`, `IS_CLEAR` or `TOO_LONG`; how many states were
        checked.
    """
    n, count = len(columns), len(groups.order)
    pending, begins, sizes, open_pairs = (
        scratch.pending,
        scratch.begins,
        scratch.sizes,
        scratch.open_pairs,
    )
    if count > len(open_pairs):
        return TOO_LONG, 0
    # Loops, here and below: numba takes seconds to compile the assignment of an array to a slice.
    for k in range(count):
        open_pairs[k] = -1 - groups.order[k]
    begins[0], sizes[0] = 0, count
    used, last, at = count, 1, FIRST
    while at < last:
        for i in range(n):
            a, b, e = pending[at, 0, i], pending[at, 1, i], pending[at, 2, i]
            m = (a + 2.0 * b + e) / 4.0
            scratch.middle[i] = m
            scratch.q[columns[i]] = m
            scratch.d[columns[i]] = max(abs(a - m), abs(e - m))
            scratch.ahead[columns[i]] = (e - a) / 2.0
            scratch.bent[columns[i]] = abs(a - 2.0 * b + e) / 4.0
        found, kept, furthest = look_at(
            int(begins[at]), int(sizes[at]), used, margins, commons, model, groups, scratch, names
        )
        if found >= 0 and not names:
            move_to_front(found, groups)
        if found != IS_CLEAR:
            return found, at + 1
        if kept > used and furthest > resolution:
            if last + 2 > len(pending):
                return TOO_LONG, at + 1
            _halve(pending, at, last)
            begins[last], sizes[last] = used, kept - used
            begins[last + 1], sizes[last + 1] = used, kept - used
            last, used = last + 2, kept
        at += 1
    return IS_CLEAR, at


@njit_in_place
def _halve(pending: Floats, at: int, last: int) -> None:
    """Put both halves of the curve at `at` behind the last one pending."""
    for i in range(pending.shape[2]):
        a, b, e = pending[at, 0, i], pending[at, 1, i], pending[at, 2, i]
        m = (a + 2.0 * b + e) / 4.0
        pending[last, 0, i], pending[last, 1, i], pending[last, 2, i] = a, (a + b) / 2, m
        pending[last + 1, 0, i], pending[last + 1, 1, i] = m, (b + e) / 2
        pending[last + 1, 2, i] = e
