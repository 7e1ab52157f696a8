"""How far pieces of two shapes are apart at least, by boxes and balls around them: compiled.

Pieces are rows (n, 7) [m] in the frame of their shape: centre and half sizes of a box, and the
radius of a ball around the same centre.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints
from workbench.planning.compiled import njit_in_place


@njit(cache=True)
def far_from(pieces: Floats, R: Floats, p: Floats, box: Floats) -> Floats:
    """How far each piece (n,) [m] is at least from a box, below 0 where it may reach into it.

    Args:
        pieces: (n, 7) [m].
        R: (3, 3) turns the frame of the pieces into that of the box.
        p: (3,) [m] the origin of the pieces' frame there.
        box: (7,) [m].
    """
    far, out = np.empty(len(pieces)), np.empty(3)
    for i in range(len(pieces)):
        for k in range(3):
            out[k] = p[k] - box[k]
            for m in range(3):
                out[k] += R[k, m] * pieces[i, m]
            out[k] = abs(out[k]) - box[3 + k]
        far[i] = _to_box(out) - pieces[i, 6]
    return far


@njit(cache=True)
def close_pairs(
    first: Floats,
    second: Floats,
    R: Floats,
    p: Floats,
    ours: Ints,
    theirs: Ints,
    within: float,
) -> tuple[Ints, Floats]:
    """Pairs of pieces that may be nearer than `within` [m], the nearest first.

    Args:
        first: (n, 7) [m] pieces.
        second: (m, 7) [m] pieces.
        R: (3, 3) turns the frame of the second into that of the first.
        p: (3,) [m] the origin of the second frame there.
        ours: (i,) numbers of those of the first that count.
        theirs: (j,) numbers of those of the second that count.
        within: [m].

    Returns:
        Their numbers (k, 2), and how far they are apart at least (k,) [m].
    """
    turn = np.abs(R)
    pairs, least = (
        np.empty((len(ours) * len(theirs), 2), np.int64),
        np.empty(len(ours) * len(theirs)),
    )
    apart, here, there = np.empty(3), np.empty(3), np.empty(3)
    count = 0
    for j in theirs:
        for i in ours:
            for k in range(3):
                apart[k] = p[k] - first[i, k]
                for m in range(3):
                    apart[k] += R[k, m] * second[j, m]
            gap = -np.inf
            for k in range(3):
                here[k], there[k] = abs(apart[k]) - first[i, 3 + k], 0.0
                reach, back = 0.0, 0.0
                for m in range(3):
                    there[k] += R[m, k] * apart[m]
                    reach += turn[k, m] * second[j, 3 + m]
                    back += turn[m, k] * first[i, 3 + m]
                there[k] = abs(there[k]) - second[j, 3 + k]
                # The boxes are apart along a face of one of them.
                gap = max(gap, here[k] - reach, there[k] - back)
            gap = max(gap, _to_box(here) - second[j, 6], _to_box(there) - first[i, 6])
            if gap < within:
                pairs[count, 0], pairs[count, 1], least[count] = i, j, gap
                count += 1
    order = np.argsort(least[:count])
    return pairs[order], least[order]


@njit_in_place
def _to_box(out: Floats) -> float:
    """How far a point [m] is from a box whose faces it is `out` (3,) [m] of; below 0 within."""
    square, most = 0.0, -np.inf
    for k in range(3):
        most = max(most, out[k])
        square += max(out[k], 0.0) ** 2
    return float(np.sqrt(square) + min(most, 0.0))
