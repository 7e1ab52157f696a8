"""How a part can stand on a level surface: what its convex hull and its weight say."""

from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats
from workbench.model.part import Part
from workbench.model.symmetry import Symmetry

STEADY = np.deg2rad(12.0)
"""[rad] Tilt up to which a part must not fall over; the proof requires a little less."""

COPLANAR_WITHIN = 2e-4
"""[m] Corners of the hull no farther than this from a plane lie in it."""

VERTICAL_TURNS = 12
"""In how many ways a part is turned about the vertical."""

SAME_POSE = 2e-4
"""[m, no unit] Poses whose numbers differ by less are one."""


SAME_VERTICAL = np.deg2rad(10.0)
"""[rad] Ways to lie whose verticals differ by less are one: a round part rolls from one to the
next."""

COUNTED_SHARE = 0.95
"""Share of all drops after which ways to lie are left out: edges on which a part hardly stands."""


@lru_cache(maxsize=64)
def ways_to_lie(part: Part) -> tuple[Floats, Floats]:
    """How a part that is dropped comes to lie on a level floor, the most frequent way first.

    Returns:
        Unit vectors (n, 3) of the part that point up then, and how often (n,), adding up to 1: by
        the solid angles of its hull's faces (Goldberg et al., Part pose statistics, 1999).  Also
        those on its side, where it may roll.
    """
    import trimesh

    mesh = trimesh.Trimesh(part.mesh.points, part.mesh.triangles, process=False)
    poses, shares = trimesh.poses.compute_stable_poses(
        mesh, center_mass=_centre(part), sigma=0.0, n_samples=1, threshold=0.0
    )
    ups: list[Floats] = []
    often: list[float] = []
    # The digits behind these depend on the processor.
    for k in np.lexsort((*np.round(poses[:, 2, :3], 3).T, -np.round(shares, 6))).tolist():
        up = poses[k, 2, :3]
        near = [n for n, other in enumerate(ups) if up @ other > np.cos(SAME_VERTICAL)]
        if near:
            often[near[0]] += float(shares[k])
        else:
            ups.append(up)
            often.append(float(shares[k]))
    order = np.argsort(-np.round(often, 6), kind="stable")
    chosen = order[: int(np.searchsorted(np.cumsum(np.array(often)[order]), COUNTED_SHARE)) + 1]
    share = np.array(often)[chosen]
    return np.array(ups)[chosen], share / share.sum()


@lru_cache(maxsize=64)
def resting_poses(part: Part) -> tuple[pin.SE3, ...]:
    """Poses T_surface_part in which a part stands on a level surface, the steadiest first.

    Its centre of mass, or what its symmetry leaves of that, is above the origin.  It may be turned
    about the vertical in `VERTICAL_TURNS` ways; of poses that its symmetry makes alike there is
    one.  A part that would roll has none on its side.
    """
    middle = part.symmetry.invariant_point(_centre(part))
    found: list[tuple[float, Floats]] = []
    for down, offset, steady in _stands(part):
        T = np.eye(4)
        T[:3, :3] = _upright(down)
        T[:3, 3] = -T[:3, :3] @ middle
        T[2, 3] += offset - down @ middle
        found.append((steady, T))
    # The digits behind these depend on the processor.
    found.sort(key=lambda pose: (-round(pose[0], 3), np.round(pose[1], 3).ravel().tolist()))
    angles = np.arange(VERTICAL_TURNS) * (2 * np.pi / VERTICAL_TURNS)
    every = [_turn(angle) @ T for _, T in found for angle in angles]
    return tuple(pin.SE3(T[:3, :3], T[:3, 3]) for T in _each_once(every, part.symmetry))


def _stands(part: Part) -> list[tuple[Floats, float, float]]:
    """Each face of the hull on which a part stands.

    Returns:
        Its outward normal (3,), how far along that it is from the part's origin [m]; and how far
        the part may be tilted before it falls over [rad].
    """
    # Takes a while, and planning without stations asks for no hulls.
    from scipy.spatial import ConvexHull, QhullError

    points, centre = np.asarray(part.mesh.points), _centre(part)
    try:
        hull = ConvexHull(points)
    except QhullError:
        return []
    corners = points[hull.vertices]
    found: list[tuple[Floats, float, float]] = []
    for normal, offset in zip(hull.equations[:, :3], -hull.equations[:, 3], strict=True):
        if any(normal @ known > 1.0 - SAME_POSE for known, _, _ in found):
            continue
        height = float(offset - normal @ centre)
        face = (corners[corners @ normal >= offset - COPLANAR_WITHIN] - centre) @ _upright(normal)[
            :2
        ].T
        steady = _tilt(face, height)
        if steady >= STEADY:
            found.append((normal, float(offset), steady))
    return found


def _tilt(face: Floats, height: float) -> float:
    """How far [rad] a part may be tilted, whose face (n, 2) [m] is seen from its centre of mass."""
    from scipy.spatial import ConvexHull, QhullError

    try:
        edges = ConvexHull(face).equations
    except (QhullError, ValueError):
        return 0.0
    return float(np.arctan2((-edges[:, 2]).min(), height))


def _centre(part: Part) -> Floats:
    """The centre of mass (3,) [m] of a part of one material."""
    import trimesh  # takes half a second, which planning without stations does not wait for

    mesh = trimesh.Trimesh(part.mesh.points, part.mesh.triangles, process=False)
    return np.array([float(coordinate) for coordinate in mesh.center_mass.real])


def _upright(down: Floats) -> Floats:
    """A rotation (3, 3) that brings a direction of the part (3,) down."""
    # The axis of the part that is the most level comes to lie along x.
    aside = np.eye(3)[int(np.argmin(np.round(np.abs(down), 3)))]
    x = aside - (aside @ down) * down
    x /= np.linalg.norm(x)
    return np.array([x, np.cross(-down, x), -down]).astype(np.float64)


def _turn(angle: float) -> Floats:
    T = np.eye(4)
    T[:2, :2] = [[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]]
    return T


def _each_once(poses: list[Floats], symmetry: Symmetry) -> list[Floats]:
    """The poses (4, 4) without those that the symmetry makes of one before."""
    kept: list[Floats] = []
    known = np.empty((0, 4, 4))
    motions = symmetry.motions(VERTICAL_TURNS)
    for T in poses:
        if len(known) and (np.abs(known - T).max(axis=(1, 2)) < SAME_POSE).any():
            continue
        kept.append(T)
        known = np.concatenate([known, T @ motions])
    return kept
