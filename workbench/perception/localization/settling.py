"""Refining poses: a dense fit to the scan, then a search along what the fit leaves weak.

Nearly all of its time is drawing the part, about forty times a pose: see `views.rendering`.
"""

import numpy as np
from numba import njit, prange

from workbench.model.geometry import Floats, Ints
from workbench.perception.matching.maps import DepthMap, Seen
from workbench.perception.matching.registration import move, solved, transformed
from workbench.perception.matching.sightings import (
    AGAINST,
    EXPLAINED,
    HIDDEN,
    SQUARES,
    VIOLATED,
    Drawing,
    closeness,
    counted,
    drawing,
    pull,
    pulled,
    tally,
)
from workbench.perception.parts.part_surface import PartSurface

FITS = 3
"""Gauss-Newton steps of the dense fit, at most."""

CONVERGED = 0.002
"""The fit ends when a step turns and shifts the part by less, over the tolerance."""

HOPELESS_SHOWN, HOPELESS_SEEN = 0.2, 0.5
"""Shares that a pose must explain after the first fit, of its visible surface and of the points at
its place.  Other poses are discarded: they are far from the limits of an accepted part."""

WEAK = 3
"""Directions that are searched at most: those that the fit holds least.  A ball's are its turns, of
which none is seen."""

LOOSE_SHARE = 0.05
"""Directions are searched when the noise alone may shift them by this share of the tolerance."""

NOISE = 0.25
"""Deviation of the points over the tolerance."""

GIVEN_UP = 0.01
"""The last fit stands if it costs the pose no more than a pixel and this share of its closeness."""

LOOSE_SHIFT = 0.02
"""A part whose surface may move by this share of its diameter, and be explained as well, is not
held."""

LEAST_TRAVEL = 0.05
"""[m] Motions of one metre that move the surface by less count as if it moved by this much."""

STANDARD_ERRORS = 3.0
"""Standard errors that must stay below that shift where the fit is to hold the part alone."""

HELD = 8.0
"""[pixels] By which the pose must be better than one that is shifted so."""

FIRM = 1e6
"""Information given to a direction that does not count, so that it is taken for held."""

DAMPING = 1e-4
"""Share of the mean information that is added to all directions: nothing may hold one of them."""


def refine_poses(
    depth_map: DepthMap,
    surface: PartSurface,
    poses: Floats,
    tolerance: float,
    steps: tuple[float, ...],
) -> Floats:
    """The poses (k, 4, 4), each refined by dense ICP and a search along what ICP leaves weak.

    Balls, and poses that explain too little, get ICP only.

    A cylinder slides along its axis without leaving its surface, a plate in its plane; where they
    end is seen by which pixels show them, which no distance between points and planes expresses.

    Args:
        depth_map: the scan.
        surface: the part.
        poses: (k, 4, 4) not far from the truth.
        tolerance: [m] see `sightings.look`.
        steps: [m] lengths of the search's steps, one after the other.
    """
    return _refine_arrays(
        *drawing(depth_map, surface, tolerance), np.ascontiguousarray(poses), surface.middle,
        surface.diameter / 2, np.array(steps), 0 if surface.is_ball else WEAK,
    )  # fmt: skip


@njit(cache=True, parallel=True)
def _refine_arrays(
    seen: Seen,
    vertices: Floats,
    triangles: Ints,
    is_closed: bool,
    tolerance: float,
    poses: Floats,
    middle: Floats,
    radius: float,
    steps: Floats,
    searched: int,
) -> Floats:  # pragma: no cover (compiled)
    """See `refine_poses`; a `Drawing` is taken apart: threads take no tuples in tuples."""
    rested = poses.copy()
    for k in prange(len(poses)):
        _settle(
            Drawing(seen, vertices, triangles, is_closed, tolerance), rested[k],
            middle, radius, steps, searched,
        )  # fmt: skip
    return rested


@njit(cache=True)
def _settle(
    drawing: Drawing, T: Floats, middle: Floats, radius: float, steps: Floats, searched: int
) -> None:  # pragma: no cover (compiled)
    """Bring one pose `T` (4, 4) to rest, in place; this many directions may be searched."""
    x = np.empty(6)
    _fit(drawing, T, middle, radius)
    if searched == 0:
        return
    says = counted(drawing, T)
    shown = says[EXPLAINED] + says[VIOLATED] + says[HIDDEN]
    seen = says[EXPLAINED] + says[VIOLATED]
    if says[EXPLAINED] < max(HOPELESS_SHOWN * shown, HOPELESS_SEEN * seen):
        return
    value = says[EXPLAINED] - AGAINST * says[VIOLATED] - says[SQUARES]
    centre = transformed(T, middle)
    A, _ = pulled(drawing, T, centre, radius)
    values, directions = np.linalg.eigh(A)
    is_moved = False
    for weak in range(searched):
        if NOISE / np.sqrt(max(values[weak], 1e-12)) < LOOSE_SHARE:
            break
        for step in steps:
            start = T.copy()
            for sign in (-1.0, 1.0):
                tried = start.copy()
                centre = transformed(tried, middle)
                for i in range(6):
                    x[i] = directions[i, weak] * (sign * step)
                move(tried, centre, x, radius)
                says = counted(drawing, tried)
                found = says[EXPLAINED] - AGAINST * says[VIOLATED] - says[SQUARES]
                if found > value:
                    value, is_moved = found, True
                    _copy(tried, T)
    if not is_moved:
        return
    # Counting pixels is coarse: what surfaces hold, they hold better, if the shape is right.
    tried = T.copy()
    _fit(drawing, tried, middle, radius)
    says = counted(drawing, tried)
    found = says[EXPLAINED] - AGAINST * says[VIOLATED] - says[SQUARES]
    if found >= value - 1.0 - GIVEN_UP * abs(value):
        _copy(tried, T)


@njit(cache=True)
def _copy(source: Floats, target: Floats) -> None:  # pragma: no cover (compiled)
    """Write one pose (4, 4) over another; numba takes seconds to compile `target[:] = source`."""
    for i in range(4):
        for k in range(4):
            target[i, k] = source[i, k]


@njit(cache=True)
def _fit(
    drawing: Drawing, T: Floats, middle: Floats, radius: float
) -> None:  # pragma: no cover (compiled)
    """A few Gauss-Newton steps of the pose `T`, in place, until it hardly moves."""
    x = np.empty(6)
    for _ in range(FITS):
        centre = transformed(T, middle)
        A, b = pulled(drawing, T, centre, radius)
        if A[0, 0] == 0.0:
            break
        solved(A, b, x)
        move(T, centre, x, radius)
        if np.abs(x).max() < CONVERGED * drawing.tolerance:
            break


def is_constrained(
    depth_map: DepthMap, surface: PartSurface, pose: Floats, tolerance: float
) -> bool:
    """Whether the scan fixes the pose in every direction but turns about its symmetry axis.

    Every weakly fitted direction must lose `HELD` pixels when the pose is shifted along it.

    Turns about a near-symmetry axis do not count, that is what `roll_error` is for, and no turns
    of a ball.

    Args:
        depth_map: the scan.
        surface: the part.
        pose: (4, 4).
        tolerance: [m] see `sightings.look`.
    """
    A, _ = pull(depth_map, surface, pose, tolerance)
    if surface.is_ball:
        A = A + FIRM * np.diag([1.0, 1.0, 1.0, 0.0, 0.0, 0.0])
    elif surface.symmetry.axis is not None:
        turn = _turn(surface, pose)
        A = A + FIRM * np.outer(turn, turn) / float(turn @ turn)
    values, vectors = np.linalg.eigh(A)
    radius, step = surface.diameter / 2, LOOSE_SHIFT * surface.diameter
    errors = NOISE * tolerance / np.sqrt(np.maximum(values, 1e-12))
    # What counts is how far the surface moves: a spring, as a screw about its axis, moves little.
    travels = _travels(surface, pose, vectors)
    directions = (vectors / travels)[:, STANDARD_ERRORS * errors * travels > step].T
    if len(directions) == 0:
        return True
    tried = [pose]
    for direction in directions:
        for sign in (-1.0, 1.0):
            shifted = np.array(pose)
            centre = transformed(shifted, surface.middle)
            move(shifted, centre, sign * step * direction, radius)
            tried.append(shifted)
    own, *others = closeness(tally(depth_map, surface, np.array(tried), tolerance))
    return max(others) <= own - HELD


def _travels(surface: PartSurface, pose: Floats, motions: Floats) -> Floats:
    """How far the point of the surface that moves most does [m], for each of motions (6, k) [m]."""
    arms = (surface.coarse.points - surface.middle) @ pose[:3, :3].T / (surface.diameter / 2)
    moved = np.cross(motions[:3].T[:, None], arms) + motions[3:].T[:, None]
    return np.maximum(np.linalg.norm(moved, axis=2).max(axis=1), LEAST_TRAVEL)


def roll_error(
    depth_map: DepthMap, surface: PartSurface, pose: Floats, tolerance: float, deviation: float
) -> float:
    """Standard error [rad] of the turn about the near-symmetry axis, all else being free too.

    Args:
        depth_map: the scan.
        surface: one that has such an axis.
        pose: (4, 4).
        tolerance: [m] see `sightings.look`.
        deviation: [m] of the points from the surface, as if each had an error of its own.
    """
    A, _ = pull(depth_map, surface, pose, tolerance)
    turn = _turn(surface, pose)
    others = np.linalg.svd(turn[None])[2][1:]
    basis = np.column_stack([turn, others.T])
    damped = A + (DAMPING * np.trace(A) / 6 + 1e-9) * np.eye(6)
    return deviation * float(np.sqrt(np.linalg.inv(basis.T @ damped @ basis)[0, 0]))


def _turn(surface: PartSurface, pose: Floats) -> Floats:
    """The motion (6,) [m] of one radian about the near-symmetry axis."""
    assert surface.symmetry.axis is not None
    point, direction = surface.symmetry.axis
    axis = pose[:3, :3] @ direction
    arm = pose[:3, :3] @ (surface.middle - point)
    return np.concatenate([axis * surface.diameter / 2, np.cross(axis, arm)])
