"""The poses of scans, a little better than they were given: by where the scans show the same.

Shape alone does not say how views of flat faces lie to each other: they slide.  So the given poses
are kept where the scans say nothing, by weighing the way from them as their error would be.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.spatial import KDTree

from workbench.extras.reconstruction.depth_views import DepthView
from workbench.model.geometry import Floats, shift_and_turn, transform

SHIFT, TURN = 0.0003, float(np.deg2rad(0.15))
"""[m], [rad] Deviations that given poses are taken to have, along and about each axis."""

MOST_MOVED, MOST_TURNED = 0.002, float(np.deg2rad(1.0))
"""[m], [rad] A pose that would go further stays as it was given."""

POINT_DEVIATION = 0.0003
"""[m] Deviation of a point from the surface that other views show."""

WORTH = 200.0
"""This many points of a view are taken to err independently: neighbours share their errors."""

SAME_PLACE_WITHIN = 0.002
"""[m] What is further from each other is not the same place."""

ALIKE_NORMALS = 0.8
"""Cosine between the normals of what is the same place."""

SWEEPS = 6

MOST_POINTS = 4000
"""Of a view."""


@dataclass(frozen=True, slots=True, eq=False)
class Aligned:
    """The poses `Ts_model_camera` of views, and how well the views agree.

    How far points of one lie from the surface that the others show, in the median [m]: with the
    poses as they were `given`, and as they are `now`.  `shared` (n,), 0..1, is how much of what
    each view shows of the part the others show too, with the poses as they are now.
    """

    Ts_model_camera: tuple[pin.SE3, ...]
    given: float
    now: float
    shared: Floats


def aligned(views: Sequence[DepthView]) -> Aligned:
    """Fit each view to the others in turn, no further than `MOST_MOVED` and `MOST_TURNED`.

    Where that brings the views no nearer to each other the poses are those that were given.
    """
    clouds = [_thin(view) for view in views]
    given = [view.T_model_camera for view in views]
    poses = list(given)
    for _ in range(SWEEPS):
        for k in range(len(views)):
            fitted = _fit(k, clouds, poses, given[k])
            shift, turn = shift_and_turn(_way(clouds[k], given[k], fitted))
            if shift <= MOST_MOVED and turn <= MOST_TURNED:
                poses[k] = fitted
    (before, shared), (after, shared_after) = _apart(clouds, given), _apart(clouds, poses)
    if not after < before:
        return Aligned(tuple(given), before, before, shared)
    return Aligned(tuple(poses), before, after, shared_after)


def as_given(views: Sequence[DepthView]) -> Aligned:
    """The poses as they are, and how far apart the views are with them."""
    given = [view.T_model_camera for view in views]
    apart, shared = _apart([_thin(view) for view in views], given)
    return Aligned(tuple(given), apart, apart, shared)


def _thin(view: DepthView) -> tuple[Floats, Floats]:
    points, normals = view.points()
    every = max(1, len(points) // MOST_POINTS)
    return points[::every], normals[::every]


def _way(cloud: tuple[Floats, Floats], given: pin.SE3, now: pin.SE3) -> pin.SE3:
    """The motion of a view from one pose to the other, about the centre of its points."""
    middle = pin.SE3(np.eye(3), cloud[0].mean(axis=0))
    return (given * middle).inverse() * (now * middle)


def _pairs(
    k: int, clouds: Sequence[tuple[Floats, Floats]], poses: Sequence[pin.SE3]
) -> tuple[Floats, Floats, Floats]:
    """Points of view k, the nearest of others, and the normals there, each (n, 3), model frame."""
    points = [transform(T, cloud[0]) for cloud, T in zip(clouds, poses, strict=True)]
    normals = [cloud[1] @ T.rotation.T for cloud, T in zip(clouds, poses, strict=True)]
    others = [j for j in range(len(clouds)) if j != k]
    target = np.concatenate([points[j] for j in others])
    facing = np.concatenate([normals[j] for j in others])
    found = KDTree(target).query(points[k], distance_upper_bound=SAME_PLACE_WITHIN)
    apart, nearest = np.asarray(found[0]), np.asarray(found[1])
    close = np.flatnonzero(np.isfinite(apart))
    nearest = nearest[close]
    same = np.einsum("nk,nk->n", normals[k][close], facing[nearest]) > ALIKE_NORMALS
    return points[k][close[same]], target[nearest[same]], facing[nearest[same]]


def _fit(
    k: int, clouds: Sequence[tuple[Floats, Floats]], poses: Sequence[pin.SE3], given: pin.SE3
) -> pin.SE3:
    """The pose of view k that brings its points onto the planes of the others.

    One step of Gauss-Newton from where it is; the way from the given pose is weighed by `SHIFT` and
    `TURN`.
    """
    p, q, n = _pairs(k, clouds, poses)
    if len(p) == 0:
        return poses[k]
    middle = p.mean(axis=0)
    rows = np.hstack([n, np.cross(p - middle, n)])
    off = np.einsum("nk,nk->n", p - q, n)
    worth = WORTH / len(p) / POINT_DEVIATION**2
    prior = np.diag([1 / SHIFT**2] * 3 + [1 / TURN**2] * 3)
    # The way gone so far, along and about the model's axes through the same middle.
    gone = poses[k] * given.inverse()
    so_far = np.concatenate([gone.act(middle) - middle, pin.log3(gone.rotation)])
    step = np.linalg.solve(worth * rows.T @ rows + prior, -worth * rows.T @ off - prior @ so_far)
    turned = pin.exp3(np.asarray(step[3:], dtype=np.float64))
    return pin.SE3(turned, middle + step[:3] - turned @ middle) * poses[k]


def _apart(
    clouds: Sequence[tuple[Floats, Floats]], poses: Sequence[pin.SE3]
) -> tuple[float, Floats]:
    """The median distance [m] where views show the same, and each view's share (n,) of that."""
    off = [_pairs(k, clouds, poses) for k in range(len(clouds))]
    each = np.concatenate([np.abs(np.einsum("nk,nk->n", p - q, n)) for p, q, n in off])
    shared = [len(p) / len(cloud[0]) for (p, _, _), cloud in zip(off, clouds, strict=True)]
    return float(np.median(each)) if len(each) else np.inf, np.array(shared)
