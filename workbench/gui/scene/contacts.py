"""Bodies at their poses; those that come close to each other, too close in red."""

import pinocchio as pin
import viser

from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.robot import place_new
from workbench.gui.shared.colours import BAD, rgb_of
from workbench.gui.shared.look import Placed
from workbench.gui.shared.solids import Colour, with_hard_edges
from workbench.model.geometry import Shape

GROWN = 0.0015
"""[m] What is marked stands out this far beyond what it marks."""


def draw_meets(
    scene: viser.SceneApi,
    name: str,
    meets: tuple[Placed, ...],
    colour: str = BAD,
    opacity: float = 0.75,
    grown: float = GROWN,
) -> None:
    """Show these bodies under a node of that name, and what was there before no more.

    They are `grown` [m] to all sides: their own surfaces, and scanned points on these, are drawn
    in other colours.
    """
    scene.remove_by_name(name)
    for number, (shape, T) in enumerate(meets):
        add_body(scene, f"{name}/{number}", shape, T, rgb_of(colour), opacity, grown=grown)


def add_body(
    scene: viser.SceneApi,
    name: str,
    shape: Shape,
    T: pin.SE3,
    colour: Colour,
    opacity: float | None = None,
    *,
    grown: float = 0.0,
) -> None:
    """Show a body, `grown` [m] to all sides, at `T`, its pose in what its name is below of."""
    surface = triangles_of(shape)
    if grown:
        surface.merge_vertices()
        surface.vertices = surface.vertices + grown * surface.vertex_normals
    points, triangles = with_hard_edges(surface)
    place_new(scene.add_mesh_simple(name, points, triangles, color=colour, opacity=opacity), T)
