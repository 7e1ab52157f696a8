"""MSSD and MSPD, the errors of poses that BOP goes by.

Hodan et al., BOP Challenge 2020 on 6D Object Localization, section 2.2; as computed by bop_toolkit
(bop_toolkit_lib/pose_error.py, `mssd` and `mspd`): over all motions that leave the object as it is,
the smallest of the largest distances that a vertex has from where it truly is.
"""

from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.spatial import ConvexHull, QhullError
from scipy.spatial.distance import pdist

from workbench.model.geometry import Floats, frozen, put, transform
from workbench.model.part import Part
from workbench.model.symmetry import BALL
from workbench.perception.matching.pose_error import FINE_STEPS
from workbench.studies.bop.precision import THRESHOLDS, WIDTH

PROBES = 12
"""Vertices that tell which motions need not be checked with all."""


@dataclass(frozen=True, slots=True, eq=False)
class Shape:
    """What an object's errors are measured on.

    `points` (n, 3) [m] are its vertices, `motions` (k, 4, 4) [m] leave it as it is, the identity
    among them; `diameter` [m].
    """

    points: Floats
    motions: Floats
    diameter: float

    def __post_init__(self) -> None:
        put(self, points=frozen(self.points), motions=frozen(self.motions))


def shape_of(part: Part) -> Shape:
    """A part as BOP would state it; what looks alike from everywhere is where its middle is."""
    points = part.mesh.points
    corners = points[np.unique(part.mesh.triangles)] if len(part.mesh.triangles) else points
    diameter = _diameter(np.unique(corners, axis=0))
    if part.symmetry.form == BALL:
        return Shape(np.array([part.symmetry.point]), np.eye(4)[None], diameter)
    return Shape(points, part.symmetry.motions(FINE_STEPS), diameter)


Errors = tuple[float, float, float]
"""MSSD over the diameter, MSSD [m], and MSPD [px] were the image 640 px wide."""


def pose_errors(
    shape: Shape, T_camera_true: pin.SE3, T_camera_found: pin.SE3, K: Floats, width: int
) -> Errors:
    """All of them, for a camera matrix K (3, 3) [px] and an image of that width [px]."""
    surface = mssd(shape, T_camera_true, T_camera_found)
    projection = mspd(shape, T_camera_true, T_camera_found, K)
    return surface / shape.diameter, surface, projection * WIDTH / width


def errors_by_name(errors: Sequence[Errors | None]) -> dict[str, tuple[float | None, ...]]:
    """The errors of one estimate against each true object, None where that is of another kind."""
    return {
        name: tuple(None if error is None else error[k] for error in errors)
        for k, name in enumerate(THRESHOLDS)
    }


def mssd(shape: Shape, T_camera_true: pin.SE3, T_camera_found: pin.SE3) -> float:
    """Maximum symmetry-aware surface distance [m]."""
    return _least(shape, T_camera_true, T_camera_found, lambda points: points)


def mspd(shape: Shape, T_camera_true: pin.SE3, T_camera_found: pin.SE3, K: Floats) -> float:
    """Maximum symmetry-aware projection distance [px] with the camera matrix K (3, 3) [px]."""

    def project(points: Floats) -> Floats:
        image = points @ K.T
        with np.errstate(divide="ignore", invalid="ignore"):
            return image[..., :2] / image[..., 2:]

    return _least(shape, T_camera_true, T_camera_found, project)


def _least(
    shape: Shape, T_true: pin.SE3, T_found: pin.SE3, seen: Callable[[Floats], Floats]
) -> float:
    """The smallest over all motions; a few vertices first, which can but be nearer than all."""
    points = shape.points
    found = seen(transform(T_found, points))
    Ts = T_true.homogeneous @ shape.motions
    probes = np.unique(np.concatenate([points.argmin(axis=0), points.argmax(axis=0),
                       np.arange(0, len(points), -(-len(points) // PROBES))]))  # fmt: skip
    moved = points[probes] @ Ts[:, :3, :3].transpose(0, 2, 1) + Ts[:, None, :3, 3]
    bounds = np.linalg.norm(seen(moved) - found[probes], axis=-1).max(axis=1)
    best = np.inf
    for k in np.argsort(bounds):
        if bounds[k] >= best:
            break
        true = seen(points @ Ts[k, :3, :3].T + Ts[k, :3, 3])
        best = min(best, float(np.linalg.norm(true - found, axis=1).max()))
    return best


def _diameter(points: Floats) -> float:
    """The largest distance [m] between two of the points (n, 3)."""
    # Only corners of the hull can be the farthest apart; a flat one has none in space.
    with suppress(QhullError):
        points = points[ConvexHull(points).vertices]
    return float(pdist(points).max())
