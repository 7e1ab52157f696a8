"""Bodies that come close to each other, too close in red."""

import viser

from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.scene.robot import place
from workbench.gui.shared.colours import BAD, rgb_of
from workbench.gui.shared.look import Placed
from workbench.gui.shared.solids import with_hard_edges


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
        points, triangles = with_hard_edges(triangles_of(shape))
        node = scene.add_mesh_simple(
            f"{name}/{number}", points, triangles, color=rgb_of(colour), opacity=opacity
        )
        place(node, T)
