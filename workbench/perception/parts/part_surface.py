"""What the localizer knows of a part: prepared once from its mesh and cached by its digest."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import open3d as o3d
import trimesh
from scipy.spatial import KDTree

from workbench.model.errors import InputError
from workbench.model.geometry import Floats, frozen, own, put, spread_directions
from workbench.model.part import Part
from workbench.model.symmetry import BALL, Symmetry
from workbench.perception.parts.near_symmetry import (
    TURNS_TRIED,
    NearSymmetry,
    find_near_symmetry,
)
from workbench.perception.parts.oriented import OrientedPoints
from workbench.perception.parts.point_pairs import PairTable, make_table
from workbench.perception.views.surfaces import add_surface, rays_of, triangles_of

DENSE = 12_000
"""Points sampled on the surface before thinning."""

VIEW_DIRECTIONS = 80
"""From which the part is checked to find which of its surface can be seen at all."""

VOTING, COARSE = 0.08, 0.055
"""Distance of the points for voting and for the first fit, over the diameter."""

FINE_STEPS, ALIKE_DISTANCE, ALIKE_NORMALS = 72, 0.6, 0.95
"""Points are equivalent if a rotation, by one of this many steps of a turn, maps one to the other:
within this share of the point spacing, with at least this cosine between the normals."""

FEW_DRAWN, DRAWN = 1000, (500, 1000, 2000, 4000)
"""Triangles of what is drawn at a pose: meshes of more than a few are simplified, to the least of
these numbers that shows the surface well."""

DRAWN_OFF = 0.002
"""How far off that is then at most, over the diameter; with the largest number, whatever it is."""

ROUGH, ROUGH_OFF = (100, 200, 400, 800), 0.006
"""The same for a rough look, with several times the tolerance: that takes half of a search."""

FITTING, ROUGHLY_FITTING = 0.95, 0.9
"""Share of the surface that must lie within these distances, of both."""

BALL_SHARE = 0.02
"""A surface whose distance from its middle varies by less, over the diameter, is a ball's."""

MOST_KEPT = 400
"""Prepared parts remembered at a time, about a megabyte each: each search for the kinds of a larger
library prepares them all again."""


@dataclass(frozen=True, slots=True, eq=False)
class PartSurface:
    """A part's outer surface, in the part's frame.

    `diameter` [m] and `middle` (3,) are those of a ball around it.  `vertices` (n, 3) [m] and
    `triangles` (m, 3) are drawn, `rough_vertices` and `rough_triangles` where much is tolerated;
    `coarse` are points on it, `table` holds the pair features of
    still fewer; `scene` answers distances; `is_closed` says that it knows inside from outside.
    `symmetry` is what the localizer may mix up; `stated` (k, 4, 4) the motions after which the
    part counts as the same by its author's word; `fixed` (3,) [m] the place near the middle that
    these leave where it is.  Of what `is_ball` no turn is ever seen.
    """

    diameter: float
    middle: Floats
    vertices: Floats
    triangles: np.ndarray
    rough_vertices: Floats
    rough_triangles: np.ndarray
    coarse: OrientedPoints
    table: PairTable
    scene: o3d.t.geometry.RaycastingScene
    is_closed: bool
    symmetry: NearSymmetry
    stated: Floats
    fixed: Floats
    is_ball: bool

    def __post_init__(self) -> None:
        own(self, "middle", "vertices", "rough_vertices", "stated", "fixed")
        put(
            self,
            triangles=frozen(self.triangles, np.int64),
            rough_triangles=frozen(self.rough_triangles, np.int64),
        )


_kept: dict[str, PartSurface] = {}


def prepare(part: Part) -> PartSurface:
    """The part's surface; the last few parts are remembered.

    Raises:
        InputError: the mesh has no area, or none that can be seen from outside.
    """
    surface = _kept.pop(part.digest, None) or _prepare(part)
    while len(_kept) >= MOST_KEPT:
        del _kept[next(iter(_kept))]
    _kept[part.digest] = surface
    return surface


def _prepare(part: Part) -> PartSurface:
    mesh = triangles_of(part.mesh)
    mesh.merge_vertices()
    if not mesh.area > 0:
        raise InputError(f"the mesh of part {part.name} has no area, so nothing can be found by it")
    if mesh.is_watertight and mesh.volume < 0:
        mesh.invert()
    scene = o3d.t.geometry.RaycastingScene()
    add_surface(scene, mesh)
    middle = mesh.bounds.mean(axis=0)
    diameter = 2 * float(np.linalg.norm(mesh.vertices - middle, axis=1).max())
    sampled: Any = trimesh.sample.sample_surface(mesh, DENSE, seed=0)
    points, triangles = sampled
    dense = OrientedPoints(np.asarray(points), np.asarray(mesh.face_normals[triangles]))
    outer = dense[_can_be_seen(scene, dense, diameter)]
    if len(outer) == 0:
        raise InputError(
            f"no part of the mesh of part {part.name} can be seen from outside, so nothing can be "
            "found by it: do its triangles look inwards?"
        )
    voting = outer.thinned(VOTING * diameter)
    drawn = mesh
    if len(mesh.faces) > FEW_DRAWN:
        drawn = _simplify(mesh, outer.points, DRAWN, DRAWN_OFF * diameter, FITTING)
    rough = _simplify(drawn, outer.points, ROUGH, ROUGH_OFF * diameter, ROUGHLY_FITTING)
    return PartSurface(
        diameter=diameter,
        middle=middle,
        vertices=drawn.vertices,
        triangles=drawn.faces,
        rough_vertices=rough.vertices,
        rough_triangles=rough.faces,
        coarse=outer.thinned(COARSE * diameter),
        table=make_table(voting, voting[_unlike(voting, part.symmetry, diameter)], diameter),
        scene=scene,
        is_closed=bool(mesh.is_watertight),
        symmetry=find_near_symmetry(scene, outer.points, diameter),
        stated=part.symmetry.motions(TURNS_TRIED),
        fixed=part.symmetry.invariant_point(middle),
        is_ball=part.symmetry.form == BALL or _is_ball(outer.points, middle, diameter),
    )


def resize_surface(surface: PartSurface, factor: float) -> PartSurface:
    """The surface of a part that is `factor` times as large, about `PartSurface.fixed`."""
    fixed = surface.fixed

    def grown(points: Floats) -> Floats:
        return fixed + factor * (points - fixed)

    def oriented(points: OrientedPoints) -> OrientedPoints:
        return OrientedPoints(grown(points.points), points.normals)

    drawn = trimesh.Trimesh(grown(surface.vertices), surface.triangles, process=False)
    scene = o3d.t.geometry.RaycastingScene()
    add_surface(scene, drawn)
    table, motions = surface.table, np.array(surface.symmetry.motions)
    # What a motion does to the point grows with the part.
    motions[:, :3, 3] += (factor - 1.0) * (motions[:, :3, :3] @ fixed + motions[:, :3, 3] - fixed)
    axis = surface.symmetry.axis
    return replace(
        surface,
        diameter=factor * surface.diameter,
        middle=grown(surface.middle),
        vertices=grown(surface.vertices),
        rough_vertices=grown(surface.rough_vertices),
        coarse=oriented(surface.coarse),
        table=replace(
            table,
            model=oriented(table.model),
            references=oriented(table.references),
            diameter=factor * table.diameter,
        ),
        scene=scene,
        symmetry=NearSymmetry(
            motions, None if axis is None else np.array([grown(axis[0]), axis[1]])
        ),
    )


def _unlike(points: OrientedPoints, symmetry: Symmetry, diameter: float) -> np.ndarray:
    """Indices of points no two of which a symmetry takes to each other."""
    if symmetry.form == BALL:
        return np.arange(1)
    motions = symmetry.motions(FINE_STEPS)
    tree, is_open = KDTree(points.points), np.ones(len(points), dtype=bool)
    kept: list[int] = []
    for number, (p, n) in enumerate(zip(points.points, points.normals, strict=True)):
        if not is_open[number]:
            continue
        kept.append(number)
        images, normals = motions[1:, :3, :3] @ p + motions[1:, :3, 3], motions[1:, :3, :3] @ n
        for near, normal in zip(
            tree.query_ball_point(images, ALIKE_DISTANCE * VOTING * diameter), normals, strict=True
        ):
            alike = np.array(near, dtype=np.int64)
            is_open[alike[points.normals[alike] @ normal > ALIKE_NORMALS]] = False
    return np.array(kept)


def _is_ball(points: Floats, middle: Floats, diameter: float) -> bool:
    """Whether points of a surface (n, 3) [m] are all as far from its middle."""
    return bool(np.ptp(np.linalg.norm(points - middle, axis=1)) < BALL_SHARE * diameter)


def _simplify(
    mesh: trimesh.Trimesh, points: Floats, counts: tuple[int, ...], off: float, share: float
) -> trimesh.Trimesh:
    """The mesh with fewer triangles, by quadrics, which keeps edges; it passes its points (n, 3).

    It has the least of the counts with which a share of the points is within `off` [m], or the
    largest.
    """
    fine = o3d.geometry.TriangleMesh(
        o3d.utility.Vector3dVector(np.asarray(mesh.vertices)),
        o3d.utility.Vector3iVector(np.asarray(mesh.faces)),
    )
    asked = o3d.core.Tensor(points.astype(np.float32))
    for most in (count for count in counts if count < len(mesh.faces)):
        few = fine.simplify_quadric_decimation(most)
        simple = trimesh.Trimesh(np.asarray(few.vertices), np.asarray(few.triangles), process=False)
        scene = o3d.t.geometry.RaycastingScene()
        add_surface(scene, simple)
        distances = scene.compute_distance(asked).numpy()
        if most == counts[-1] or np.quantile(distances, share) <= off:
            return simple
    return mesh


def _can_be_seen(
    scene: o3d.t.geometry.RaycastingScene, surface: OrientedPoints, diameter: float
) -> np.ndarray:
    """Which points have a free line of sight, not too flat, to somewhere outside."""
    seen = np.zeros(len(surface), dtype=bool)
    start = surface.points + 1e-4 * diameter * surface.normals
    for direction in spread_directions(VIEW_DIRECTIONS):
        facing = np.flatnonzero(~seen & (surface.normals @ direction > 0.3))
        towards = np.broadcast_to(direction, (len(facing), 3))
        blocked = scene.test_occlusions(rays_of(start[facing], towards)).numpy()
        seen[facing[~blocked]] = True
    return seen
