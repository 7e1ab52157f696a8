"""Parts whose surface stands off their CAD file by one distance all around: castings, prints."""

from dataclasses import replace

import open3d as o3d
import trimesh

from workbench.model.geometry import Floats, Ints, outwards
from workbench.perception.parts.oriented import OrientedPoints
from workbench.perception.parts.part_surface import PartSurface
from workbench.perception.views.surfaces import add_surface


def grow_surface(surface: PartSurface, by: float) -> PartSurface:
    """The surface of a part whose faces lie `by` [m] further outside, inside where negative.

    The features that votes are by stay as they were: they are as coarse as the difference.
    """

    def moved(vertices: Floats, triangles: Ints) -> Floats:
        return vertices + by * outwards(vertices, triangles)

    def oriented(points: OrientedPoints) -> OrientedPoints:
        return OrientedPoints(points.points + by * points.normals, points.normals)

    vertices = moved(surface.vertices, surface.triangles)
    scene = o3d.t.geometry.RaycastingScene()
    add_surface(scene, trimesh.Trimesh(vertices, surface.triangles, process=False))
    table = surface.table
    return replace(
        surface,
        diameter=surface.diameter + 2 * by,
        vertices=vertices,
        rough_vertices=moved(surface.rough_vertices, surface.rough_triangles),
        coarse=oriented(surface.coarse),
        table=replace(table, model=oriented(table.model), references=oriented(table.references)),
        scene=scene,
    )
