"""A new tool from CAD files that somebody has on their machine."""

import numpy as np
import viser

from workbench.app.core.cell.making import AddTool
from workbench.app.core.command import Command
from workbench.app.core.state import State
from workbench.formats.cells.drawn_tools import CadDrawing, DrawnTool, SuctionLip, TwoFingers
from workbench.gui.shared.movable_frames import ANGLES, typed_pose
from workbench.gui.shared.visitor import Visitor
from workbench.gui.uploads.cad_pick import CadPick
from workbench.model.errors import InputError

TWO_FINGERS, CUP = "two fingers", "a suction cup"

FINGER = ("thickness", "width", "length")
"""Along x, in which fingers open, y and z of the drawing."""


class ToolUpload:
    """Body, fingers or cup, where they are at the flange, and the button that makes a tool of them.

    Concurrency: callbacks of viser and the renderer's thread; handles only.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._asked = ""
        gui, arms = visitor.gui, tuple(arm.name for arm in visitor.cell.arms)
        self._body = CadPick(visitor, "Choose the body", self._on_chosen)
        self._name = gui.add_text("Name", "", hint="Letters, digits, - and _.")
        self._arm = gui.add_dropdown("For the arm", arms, visible=len(arms) > 1)
        self._position = gui.add_vector3(
            "CAD origin [mm]",
            (0.0, 0.0, 0.0),
            step=0.1,
            hint="Of the file's frame in that of the flange, z out of the flange.",
        )
        self._angles = gui.add_vector3("CAD rotation [deg]", (0.0, 0.0, 0.0), step=0.1)
        visitor.name(self._angles, ANGLES)
        self._way = gui.add_dropdown("Takes parts by", (TWO_FINGERS, CUP))
        self._size = gui.add_vector3(
            "A finger [mm]",
            (6.0, 10.0, 50.0),
            step=0.1,
            hint="As a box, where no file says how it looks. Fingers open along x.",
        )
        visitor.name(self._size, FINGER)
        self._finger = CadPick(visitor, "Choose a finger", self._refresh)
        self._stroke = gui.add_number("Stroke [mm]", 50.0, step=0.1, hint="The largest opening.")
        self._radius = gui.add_number("Cup radius [mm]", 10.0, step=0.1)
        self._length = gui.add_number("Cup length [mm]", 20.0, step=0.1)
        self._press = gui.add_number("Gives way [mm]", 3.0, step=0.1, hint="The lip, at most.")
        self._force = gui.add_number(
            "Force [N]", 0.0, step=0.1, hint="Of each finger, or of the vacuum; 0: not known."
        )
        self._begins = gui.add_number(
            "Fingers from z [mm]",
            0.0,
            step=0.1,
            hint="Where fingers or cup begin along z of the CAD file; "
            "by default at the body's end.",
        )
        self._is_mended = gui.add_checkbox(
            "Repair mesh", False, hint="Close holes, turn facets, join what lies apart."
        )
        self._add = gui.add_button("Add the tool", icon=viser.Icon.TOOL)
        self._way.on_update(lambda _: self._show_way())
        visitor.on_press(self._add, self._make_command)
        self._show_way()

    def show(self, state: State) -> None:
        """Let it be used while a tool can be made."""
        missing = "choose a file for the body first" if self._body.drawing is None else ""
        self._visitor.admit(self._add, state, AddTool, otherwise=missing)
        for pick in (self._body, self._finger):
            pick.admit(state, AddTool)

    def take_arrival(self, state: State) -> str:
        """The name of the tool that this browser has asked for, once it is in the cell."""
        tools = {tool.name for arm in state.cell.arms for tool in arm.tools}
        if self._asked not in tools:
            return ""
        name, self._asked = self._asked, ""
        return name

    def _refresh(self) -> None:
        self.show(self._visitor.bench.state)

    def _on_chosen(self) -> None:
        """A body was chosen, or read: it says where it ends, and may say a name."""
        if self._body.look is not None:
            self._begins.value = round(float(self._body.look.high[2]) * 1000, 2)
        if not self._name.value:
            self._name.value = self._body.stem
        self._refresh()

    def _show_way(self) -> None:
        by_fingers = self._way.value == TWO_FINGERS
        for control in (self._size, self._stroke):
            control.visible = by_fingers
        self._finger.show(visible=by_fingers)
        for control in (self._radius, self._length, self._press):
            control.visible = not by_fingers

    def _make_command(self) -> Command:
        if self._body.drawing is None:
            raise InputError("choose a file for the body first")
        force = self._force.value or None
        if self._way.value == TWO_FINGERS:
            takes_by = TwoFingers(
                np.array(self._size.value) / 1000,
                self._stroke.value / 1000,
                force,
                self._finger.drawing or CadDrawing(),
            )
        else:
            takes_by = SuctionLip(
                self._radius.value / 1000,
                self._length.value / 1000,
                self._press.value / 1000,
                force,
            )
        self._asked = self._name.value.strip()
        drawn = DrawnTool(
            self._asked,
            self._body.drawing,
            takes_by,
            typed_pose(self._position.value, self._angles.value),
            self._begins.value / 1000,
            bool(self._is_mended.value),
        )
        return AddTool(self._arm.value, drawn)
