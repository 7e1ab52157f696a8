"""Bodies that come too close to each other, drawn in red."""

import viser

from workbench.formats.triangles import triangles_of
from workbench.gui.colours import BAD, rgb_of
from workbench.gui.look import Placed
from workbench.gui.robot import place
from workbench.gui.solids import with_hard_edges


def draw_meets(scene: viser.SceneApi, name: str, meets: tuple[Placed, ...]) -> None:
    """Show these bodies under a node of that name, and what was there before no more."""
    scene.remove_by_name(name)
    for number, (shape, T) in enumerate(meets):
        points, triangles = with_hard_edges(triangles_of(shape))
        node = scene.add_mesh_simple(
            f"{name}/{number}", points, triangles, color=rgb_of(BAD), opacity=0.75
        )
        place(node, T)
