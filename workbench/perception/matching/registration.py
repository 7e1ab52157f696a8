"""Fitting poses of a model to a depth map, many at once: quick scores and projective ICP.

Poses are arrays (k, 4, 4) of the part's frame in the scanner's frame, as compiled code takes
them.
"""

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.perception.matching.maps import DepthMap, Seen
from workbench.perception.parts.oriented import OrientedPoints
from workbench.perception.views.motions import Triple, dot, motion_of, moved, turned

FACING = 0.15
"""Cosine to the line of sight above which a model point is expected to be measured."""

AGREEING = 0.6
"""Cosine between normals of model and scan above which they agree."""

FEWEST_PAIRS = 12
"""Points of model and scan without which a pose is not fitted."""

DAMPING = 1e-3
"""Share of the mean diagonal by which `solved` raises it."""

SUPPORT, VIOLATION, OCCLUSION = 0, 1, 2
"""Columns of `quick_scores`."""


def quick_scores(
    depth_map: DepthMap, poses: Floats, model: OrientedPoints, tolerance: float
) -> Floats:
    """How the scan agrees with each pose, from the model points that face the scanner.

    Args:
        depth_map: the scan.
        poses: (k, 4, 4).
        model: points of the part's surface.
        tolerance: distance from the surface [m] up to which a point counts as measured.

    Returns:
        (k, 3): shares of the facing surface that are measured where the pose has them, where
        the scan looks through them, and which hide behind something else.
    """
    return _quick_scores(
        depth_map.seen, np.ascontiguousarray(poses), model.points, model.normals, tolerance,
    )  # fmt: skip


def refine(
    depth_map: DepthMap, poses: Floats, model: OrientedPoints, gates: Floats
) -> tuple[Floats, Floats]:
    """Point-to-plane ICP (Chen & Medioni 1992) with projective association.

    Each model point that faces the scanner is paired with the scan point in its pixel.

    Args:
        depth_map: the scan.
        poses: (k, 4, 4), where to begin.
        model: points of the part's surface.
        gates: (iterations,) [m] the largest distance of a pair in each iteration.

    Returns:
        The refined poses (k, 4, 4), and the root mean square distance (k,) [m] of the pairs in
        the last iteration.  The distance is infinite if there were too few pairs.
    """
    return _refine(
        depth_map.seen, np.ascontiguousarray(poses), model.points, model.normals,
        np.ascontiguousarray(gates),
    )  # fmt: skip


@njit(cache=True)
def transformed(T: Floats, p: Floats) -> Triple:  # pragma: no cover (compiled)
    """The point `p` (3,) [m] moved by the pose `T` (4, 4), as a tuple."""
    return (
        T[0, 0] * p[0] + T[0, 1] * p[1] + T[0, 2] * p[2] + T[0, 3],
        T[1, 0] * p[0] + T[1, 1] * p[1] + T[1, 2] * p[2] + T[1, 3],
        T[2, 0] * p[0] + T[2, 1] * p[1] + T[2, 2] * p[2] + T[2, 3],
    )


@njit(cache=True)
def _pixel(
    p: Triple, focal: float, column: float, row: float, rows: int, columns: int
) -> tuple[int, int]:  # pragma: no cover (compiled)
    """Row and column where the camera sees `p`, or (-1, -1)."""
    u = int(np.rint(p[0] / p[2] * focal + column))
    v = int(np.rint(p[1] / p[2] * focal + row))
    return (v, u) if 0 <= u < columns and 0 <= v < rows else (-1, -1)


@njit(cache=True)
def _quick_scores(
    seen: Seen,
    poses: Floats,
    points: Floats,
    normals: Floats,
    tolerance: float,
) -> Floats:  # pragma: no cover (compiled)
    scores = np.zeros((len(poses), 3))
    rays, depths, measured, foreground = seen[:4]
    rows, columns = depths.shape
    for k in range(len(poses)):
        motion, total = motion_of(poses[k]), 0.0
        support, violation, occlusion = 0.0, 0.0, 0.0
        for m in range(len(points)):
            p = moved(motion, (points[m, 0], points[m, 1], points[m, 2]))
            n = turned(motion, (normals[m, 0], normals[m, 1], normals[m, 2]))
            towards = -dot(n, p)
            if towards <= 0.0 or p[2] <= 0.0:  # half of them, and no root is needed to know
                continue
            cosine = towards / np.sqrt(dot(p, p))
            if cosine < FACING:
                continue
            total += cosine
            v, u = _pixel(p, seen.focal, seen.column, seen.row, rows, columns)
            if v < 0 or depths[v, u] == 0.0:
                continue
            ray = rays[v, u, 0], rays[v, u, 1], rays[v, u, 2]
            off = depths[v, u] * dot(n, ray) - dot(n, p)
            if off < -tolerance:
                violation += cosine
            elif off > tolerance:
                occlusion += cosine
            elif foreground[v, u]:
                there = measured[v, u, 0], measured[v, u, 1], measured[v, u, 2]
                if dot(n, there) > AGREEING:
                    support += cosine
        scores[k, SUPPORT] = support
        scores[k, VIOLATION], scores[k, OCCLUSION] = violation, occlusion
        if total > 0.0:
            for which in range(3):
                scores[k, which] /= total
    return scores


@njit(cache=True)
def _refine(
    seen: Seen,
    poses: Floats,
    points: Floats,
    normals: Floats,
    gates: Floats,
) -> tuple[Floats, Floats]:  # pragma: no cover (compiled)
    refined = poses.copy()
    errors = np.full(len(poses), np.inf)
    middle = np.zeros(3)
    for m in range(len(points)):
        middle += points[m] / len(points)
    size = 0.0
    for m in range(len(points)):
        size = max(size, np.sqrt(np.sum((points[m] - middle) ** 2)))
    A, b, x = np.empty((6, 6)), np.empty(6), np.empty(6)
    rays, depths, measured, foreground = seen[:4]
    rows, columns = depths.shape
    for k in range(len(poses)):
        T = refined[k]
        for gate in gates:
            centre = transformed(T, middle)
            A[:] = 0.0
            b[:] = 0.0
            pairs, square = 0, 0.0
            motion = motion_of(T)
            for m in range(len(points)):
                p = moved(motion, (points[m, 0], points[m, 1], points[m, 2]))
                n = turned(motion, (normals[m, 0], normals[m, 1], normals[m, 2]))
                if dot(n, p) > -FACING * p[2] or p[2] <= 0.0:
                    continue
                v, u = _pixel(p, seen.focal, seen.column, seen.row, rows, columns)
                if v < 0 or not foreground[v, u]:
                    continue
                if dot(n, (measured[v, u, 0], measured[v, u, 1], measured[v, u, 2])) < AGREEING:
                    continue
                ray = rays[v, u, 0], rays[v, u, 1], rays[v, u, 2]
                off = depths[v, u] * dot(n, ray) - dot(n, p)
                if abs(off) > gate:
                    continue
                # Turns about the middle in units of the size: all six unknowns alike.
                ax, ay, az = p[0] - centre[0], p[1] - centre[1], p[2] - centre[2]
                x[0] = (ay * n[2] - az * n[1]) / size
                x[1] = (az * n[0] - ax * n[2]) / size
                x[2] = (ax * n[1] - ay * n[0]) / size
                x[3], x[4], x[5] = n
                weight = (1.0 - (off / gate) ** 2) ** 2  # Tukey's biweight
                for i in range(6):
                    b[i] += weight * x[i] * off
                    for j in range(i + 1):
                        A[i, j] += weight * x[i] * x[j]
                pairs += 1
                square += off * off
            if pairs < FEWEST_PAIRS:
                errors[k] = np.inf
                break
            errors[k] = np.sqrt(square / pairs)
            solved(A, b, x)
            move(T, centre, x, size)
    return refined, errors


@njit(cache=True)
def solved(A: Floats, b: Floats, x: Floats) -> None:  # pragma: no cover (compiled)
    """Solve A (6, 6) x = b (6,), no unit of its own, by Cholesky's method in place.

    Only the lower half of A is given.

    The diagonal is raised a little (`DAMPING`), so that the pose does not drift in directions that
    the scan leaves open.
    """
    trace = 0.0
    for i in range(6):
        trace += A[i, i]
    for i in range(6):
        A[i, i] += DAMPING * trace / 6.0
    for i in range(6):
        for j in range(i + 1):
            total = A[i, j]
            for k in range(j):
                total -= A[i, k] * A[j, k]
            A[i, j] = np.sqrt(max(total, 1e-300)) if i == j else total / A[j, j]
    for i in range(6):
        total = b[i]
        for k in range(i):
            total -= A[i, k] * x[k]
        x[i] = total / A[i, i]
    for i in range(5, -1, -1):
        total = x[i]
        for k in range(i + 1, 6):
            total -= A[k, i] * x[k]
        x[i] = total / A[i, i]


@njit(cache=True)
def move(T: Floats, centre: Triple, x: Floats, size: float) -> None:  # pragma: no cover (compiled)
    """Turn the pose `T` (4, 4) by x[:3] / size [rad] about `centre` [m], shift it by x[3:] [m]."""
    w0, w1, w2 = x[0] / size, x[1] / size, x[2] / size
    angle = np.sqrt(w0 * w0 + w1 * w1 + w2 * w2)
    K = np.array([[0.0, -w2, w1], [w2, 0.0, -w0], [-w1, w0, 0.0]])
    turn = np.eye(3) + K
    if angle > 1e-9:  # Rodrigues
        turn = np.eye(3) + np.sin(angle) / angle * K + (1.0 - np.cos(angle)) / angle**2 * (K @ K)
    old = T.copy()
    for i in range(3):
        T[i, 3] = centre[i] + x[3 + i]
        for j in range(3):
            T[i, 3] += turn[i, j] * (old[j, 3] - centre[j])
            T[i, j] = 0.0
            for k in range(3):
                T[i, j] += turn[i, k] * old[k, j]
