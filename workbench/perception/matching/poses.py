"""Poses that are the same or not, and the best different ones of many."""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats, Ints


def distinct(
    poses: Floats,
    order: np.ndarray,
    motions: Floats,
    middle: Floats,
    *,
    distance: float,
    angle: float,
    most: int,
    nearby: tuple[float, int] = (0.0, 0),
) -> np.ndarray:
    """Indices of poses that differ from every better one by more than a symmetry.

    Args:
        poses: (k, 4, 4).
        order: indices, best first.
        motions: (s, 4, 4) motions of the part that count as no difference; the identity alone
            when every difference counts.
        middle: (3,) [m] the point of the part between whose places `distance` is measured.
        distance: [m] poses further apart than this differ.
        angle: [rad] and so do those turned by more than this.
        most: how many to return at most.
        nearby: radius [m] and the largest number of poses within it, so that one clear part does
            not crowd out the others; 0: no limit.
    """
    return _distinct(
        np.ascontiguousarray(poses),
        np.ascontiguousarray(order, dtype=np.int64),
        np.ascontiguousarray(motions),
        np.ascontiguousarray(middle),
        distance,
        np.cos(angle),
        most,
        *nearby,
    )


@njit(cache=True)
def _distinct(
    poses: Floats,
    order: Ints,
    motions: Floats,
    middle: Floats,
    distance: float,
    cosine: float,
    most: int,
    nearby: float,
    most_nearby: int,
) -> Ints:  # pragma: no cover (compiled)
    kept = np.empty(most, np.int64)
    places = np.empty((most, 3))
    count = 0
    for k in order:
        if count == most:
            break
        for i in range(3):
            places[count, i] = poses[k, i, 3]
            for j in range(3):
                places[count, i] += poses[k, i, j] * middle[j]
        crowd, is_new = 0, True
        for j in range(count):
            square = 0.0
            for i in range(3):
                square += (places[count, i] - places[j, i]) ** 2
            apart = np.sqrt(square)
            crowd += apart < nearby
            if apart <= distance and _is_turned_by_any(poses[kept[j]], poses[k], motions, cosine):
                is_new = False
                break
        if is_new and (most_nearby == 0 or crowd < most_nearby):
            kept[count] = k
            count += 1
    return kept[:count]


@njit(cache=True)
def _is_turned_by_any(
    first: Floats, second: Floats, motions: Floats, cosine: float
) -> bool:  # pragma: no cover (compiled)
    """Whether `second` is `first` after one of the motions, up to an angle."""
    for s in range(len(motions)):
        trace = 0.0  # of the rotation that is left
        for i in range(3):
            for a in range(3):
                for b in range(3):
                    trace += first[i, a] * motions[s, a, b] * second[i, b]
        if (trace - 1.0) / 2.0 > cosine:
            return True
    return False
