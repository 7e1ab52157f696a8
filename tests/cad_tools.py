"""Tools as CAD files have them, for tests: boxes in millimetres, in the flange's frame."""

import numpy as np
import trimesh

from workbench.formats.cells.drawn_tools import CadDrawing, DrawnTool, SuctionLip, TwoFingers

PALM = ((-40, -25, 0), (40, 25, 71.3))
"""[mm] Lowest and highest corner of a body."""

BAR = ((0, -5, 71.3), (7, 5, 120))
"""[mm] Of a finger."""


def stl(corners, scale: float = 1.0) -> np.ndarray:
    """The bytes of an STL file of a box."""
    box = trimesh.creation.box(bounds=corners).apply_scale(scale)
    return np.frombuffer(box.export(file_type="stl"), np.uint8)


def drawn_gripper(name: str = "drawn", **others) -> DrawnTool:
    """A box with two fingers of 50 mm."""
    fingers = TwoFingers(np.array([0.006, 0.01, 0.05]), 0.05, 20.0)
    given = {"body": CadDrawing("palm.stl", stl(PALM)), "takes_by": fingers, **others}
    return DrawnTool(name, **given)


WITH_BAR = TwoFingers(np.zeros(3), 0.06, drawing=CadDrawing("bar.stl", stl(BAR)))
CUP = SuctionLip(0.01, 0.03, force=15.0)
