"""What a scan would show of a part's colours, were the part at some pose."""

from dataclasses import dataclass
from itertools import permutations, product

import numpy as np
import open3d as o3d

from workbench.model.geometry import Floats, own
from workbench.model.part import Part
from workbench.model.scan import Scan
from workbench.perception.colours.light import SPREAD, are_unlike
from workbench.perception.localization.hypotheses import SAME_ANGLE
from workbench.perception.matching.poses import distinct
from workbench.perception.parts.near_symmetry import TURNS_TRIED
from workbench.perception.parts.part_surface import PartSurface
from workbench.perception.views.srgb import linear

MOST_POINTS = 200
"""Of one part that are held against its colours, spread evenly over those seen."""

SAME_SURFACE = 0.02
"""Of what is painted otherwise by a motion no more than this share is no change: points at the
edges of triangles belong to either."""


@dataclass(frozen=True, slots=True, eq=False)
class Painted:
    """A part's surface with the paints (m, 3) of its triangles, as shares of light sent back.

    `motions` (k, 4, 4) [m] bring its shape onto itself, more or less, the identity first.
    """

    surface: PartSurface
    paints: Floats
    motions: Floats

    def __post_init__(self) -> None:
        own(self, "paints", "motions")

    def at(self, points: Floats, pose: Floats) -> Floats:
        """Paints (n, 3) that the part at a pose (4, 4) has at points (n, 3) [m]."""
        local = (points - pose[:3, 3]) @ pose[:3, :3]
        asked = o3d.core.Tensor(np.ascontiguousarray(local, np.float32))
        hit = self.surface.scene.compute_closest_points(asked, nthreads=1)["primitive_ids"].numpy()
        return self.paints[hit.astype(np.int64)]

    def shows(self, motion: Floats) -> Floats:
        """Paints (c, 3) all over the surface, of the part after a motion (4, 4) of its shape."""
        return self.at(self.surface.coarse.points, motion)


def painted(part: Part, surface: PartSurface) -> Painted | None:
    """The part with its colours, None where shape alone counts."""
    if part.colours is None:
        return None
    tried = np.concatenate(
        [part.symmetry.motions(TURNS_TRIED), surface.symmetry.motions, _of_a_box(surface.middle)]
    )
    kept = distinct(
        tried,
        np.arange(len(tried)),
        np.eye(4)[None],
        surface.middle,
        distance=np.inf,
        angle=SAME_ANGLE,
        most=len(tried),
    )
    return Painted(surface, linear(part.colours), tried[kept])


def is_same_surface(first: Floats, second: Floats) -> bool:
    """Whether a surface has the same paints (c, 3), 0..1, after two motions."""
    return float(np.mean(are_unlike(first, second, np.array(SPREAD)))) < SAME_SURFACE


def points_on(scan: Scan, surface: PartSurface, pose: Floats, tolerance: float) -> np.ndarray:
    """Which points of a scan (n,) lie within `tolerance` [m] of a part at a pose (4, 4)."""
    middle = pose[:3, :3] @ surface.middle + pose[:3, 3]
    off = scan.points - middle
    near = np.flatnonzero(
        np.einsum("ij,ij->i", off, off) <= (surface.diameter / 2 + tolerance) ** 2
    )
    local = (scan.points[near] - pose[:3, 3]) @ pose[:3, :3]
    asked = o3d.core.Tensor(np.ascontiguousarray(local, np.float32))
    on = near[surface.scene.compute_distance(asked, nthreads=1).numpy() <= tolerance]
    return on[np.linspace(0, len(on) - 1, min(len(on), MOST_POINTS)).astype(np.int64)]


def _of_a_box(middle: Floats) -> Floats:
    """The turns (24, 4, 4) of a cube about a point (3,) [m], as motions along a part's axes.

    Cubes and plates in CAD lie along the axes; moments of inertia do not show those of a cube.
    """
    motions = list[Floats]()
    for order, signs in product(permutations(range(3)), product((1.0, -1.0), repeat=3)):
        R = np.zeros((3, 3))
        R[range(3), order] = signs
        if np.linalg.det(R) > 0:
            motion = np.eye(4)
            motion[:3, :3] = R
            motion[:3, 3] = middle - R @ middle
            motions.append(motion)
    return np.array(motions)
