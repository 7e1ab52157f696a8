"""Poses as plain numbers, for loops that move many points.

Compiled code counts who holds an array whenever it passes it on: for a point that takes longer than
to move it.
"""

from numba import njit

from workbench.model.geometry import Floats

Triple = tuple[float, float, float]

Motion = tuple[Triple, Triple, Triple, Triple]
"""The rows of a rotation, and a translation [m]."""


@njit(cache=True)
def motion_of(T: Floats) -> Motion:  # pragma: no cover (compiled)
    """The pose `T` (4, 4) [m] as numbers."""
    return (
        (T[0, 0], T[0, 1], T[0, 2]),
        (T[1, 0], T[1, 1], T[1, 2]),
        (T[2, 0], T[2, 1], T[2, 2]),
        (T[0, 3], T[1, 3], T[2, 3]),
    )


@njit(cache=True)
def dot(a: Triple, b: Triple) -> float:  # pragma: no cover (compiled)
    """The scalar product, in the unit of `a` times that of `b`."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


@njit(cache=True)
def moved(motion: Motion, p: Triple) -> Triple:  # pragma: no cover (compiled)
    """Where the motion takes a point [m]."""
    shift = motion[3]
    return (
        dot(motion[0], p) + shift[0],
        dot(motion[1], p) + shift[1],
        dot(motion[2], p) + shift[2],
    )


@njit(cache=True)
def turned(motion: Motion, n: Triple) -> Triple:  # pragma: no cover (compiled)
    """Where the motion takes a direction."""
    return dot(motion[0], n), dot(motion[1], n), dot(motion[2], n)
