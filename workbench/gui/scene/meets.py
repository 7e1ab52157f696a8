"""Bodies at their poses; those that come close to each other, too close in red."""

import pinocchio as pin
import viser

from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.robot import place
from workbench.gui.shared.colours import BAD, rgb_of
from workbench.gui.shared.look import Placed
from workbench.gui.shared.solids import Colour, with_hard_edges
from workbench.model.geometry import Shape


def draw_meets(
    scene: viser.SceneApi,
    name: str,
    meets: tuple[Placed, ...],
    colour: str = BAD,
    opacity: float = 0.75,
) -> None:
    """Show these bodies under a node of that name, and what was there before no more."""
    scene.remove_by_name(name)
    for number, (shape, T) in enumerate(meets):
        add_body(scene, f"{name}/{number}", shape, T, rgb_of(colour), opacity)


def add_body(
    scene: viser.SceneApi,
    name: str,
    shape: Shape,
    T: pin.SE3,
    colour: Colour,
    opacity: float | None = None,
) -> None:
    """Show a body under that name at `T`, its pose in what the name is below of."""
    points, triangles = with_hard_edges(triangles_of(shape))
    place(scene.add_mesh_simple(name, points, triangles, color=colour, opacity=opacity), T)
