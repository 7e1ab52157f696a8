"""The tab that shows what the cell is made of: to move things, jog the robot, and save."""

from collections.abc import Mapping
from typing import Any

import numpy as np
import pinocchio as pin
import viser

from workbench.app.core.cell.changes import ChangeCell, RedoCell, SaveCell, StateTool, UndoCell
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.state import State
from workbench.gui.cell.commissioning import steps_html
from workbench.gui.cell.jogging import JogControls
from workbench.gui.cell.tool_upload import ToolUpload
from workbench.gui.cell.views import cell_line, measured_line, reach_line, tree_html
from workbench.gui.dragging.pose_inputs import PoseInputs
from workbench.gui.help.groups import group
from workbench.gui.scene.measure import pointed_at
from workbench.gui.scene.surroundings import nodes_with
from workbench.gui.shared.look import View
from workbench.gui.shared.movable_frames import (
    SCANNER,
    TCP,
    frame_of,
    move_frame,
    moving,
    pose_of,
    things,
    tool_of,
)
from workbench.gui.shared.views import not_redone, not_saved, not_undone
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.cell import CellPageText
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.messages.commands import EditText

NOT_SHOWN, NOT_KNOWN = "not shown", "not known"
GIZMO = 0.18
"""[m] Size of the gizmo that moves a thing."""


class CellPanel:
    """Steps of commissioning, things with their poses, the robot by hand, undo, redo and save.

    Concurrency: callbacks of viser change this browser's gizmo, controls and own look, the shared
    look, or give commands; the renderer's thread draws what came of them.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._clicked: Any = None
        self._view: View | None = None
        self._is_saving = False
        gui, cell = visitor.gui, visitor.cell
        with group(gui, "Commissioning", expand_by_default=not visitor.is_recorded):
            self._steps = gui.add_html("")
        with group(gui, "What is there", expand_by_default=False):
            self._tree = gui.add_html("")
        with group(gui, "Objects in the cell"):
            self._thing = gui.add_dropdown(
                "Object", things(cell), hint="What the numbers and the gizmo below move."
            )
            self._inputs = PoseInputs(
                visitor,
                "/cell_gizmo",
                GIZMO,
                command=ChangeCell,
                meant=self._move,
                otherwise=self._otherwise,
                carried=self._poses_carried,
            )
            self._undo = gui.add_button("Undo", icon=viser.Icon.ARROW_BACK_UP, color="gray")
            self._redo = gui.add_button("Redo", icon=viser.Icon.ARROW_FORWARD_UP, color="gray")
            self._shapes = gui.add_checkbox(
                "Collision shapes", False, hint="Show what is checked instead of how it looks."
            )
            self._frames = gui.add_checkbox(
                "Frames", False, hint="Show the frames that the cell file is about."
            )
            self._reach = gui.add_dropdown(
                "Reach",
                (NOT_SHOWN, *(arm.name for arm in cell.arms)),
                hint="Where an arm gets its tool pointing straight down, whatever stands there: "
                "green at any turn of the tool, orange at some.",
            )
            self._reached = gui.add_html("")
            self._measure = gui.add_button(
                "Measure",
                icon=viser.Icon.RULER,
                color="gray",
                hint="Then click on two points in the scene; once more ends it.",
            )
            self._measured = gui.add_html("")
        with group(gui, "Robot by hand"):
            self._jog = JogControls(visitor)
            self._tools = {
                arm.name: gui.add_dropdown(
                    visitor.words.render(CellPageText.TOOL_OF(arm=arm.name)),
                    tuple(tool.name for tool in arm.tools),
                    initial_value=arm.tool.name,
                    hint="What the arm carries now: change it here when you have changed it there.",
                    visible=len(arm.tools) > 1,
                )
                for arm in cell.arms
            }
        with group(gui, "A tool from CAD", expand_by_default=False):
            self._upload = ToolUpload(visitor)
        with group(gui, "Cell file"):
            self._remark = gui.add_text(
                "Remark", "", hint="Why the cell was changed; kept in changes.log beside it."
            )
            self._save = gui.add_button("Save", icon=viser.Icon.DEVICE_FLOPPY)
            self._line = gui.add_html("")
        self._react()
        visitor.add_form(self._not_moved)
        visitor.on_end(self._end_measuring, in_scene=True)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        self._view = new
        self._inputs.show_drag(old, new)
        state, cell = new.state, new.state.cell
        if old is None or old.state is not state or old.statistics is not new.statistics:
            self._steps.content = steps_html(new, self._visitor.words)
        if old is None or old.state.cell is not cell:
            self._tree.content = tree_html(cell, self._visitor.words)
            names = things(cell)
            if self._thing.options != names:
                self._thing.options = names
        if old is None or old.state is not state:
            admit = self._visitor.admit
            cannot = self._visitor.obstacle(state, ChangeCell)
            self._show_thing(cell, cannot)
            admit(self._undo, state, UndoCell, otherwise=not_undone(state))
            admit(self._redo, state, RedoCell, otherwise=not_redone(state))
            is_changed = not state.is_saved
            admit(self._save, state, SaveCell, otherwise=not_saved(state))
            self._visitor.emphasise(self._save, "Cell")
            if self._is_saving and not is_changed:
                self._is_saving, self._remark.value = False, ""
            lacks = self._visitor.lacks(state, TakeScan)
            for control in (self._shapes, self._frames, self._reach):
                control.disabled = bool(lacks)
            self._visitor.allow(self._measure, lacks)
            self._line.content = cell_line(state, self._visitor.words)
            self._show_tools(state, self._visitor.obstacle(state, StateTool))
            self._upload.show(state)
            if tool := self._upload.take_arrival(state):
                # Its TCP is what comes next: the gizmo is there.
                self._thing.value = f"{TCP} {tool}"
                self._visitor.own.change(thing=self._thing.value)
        for box, value in ((self._shapes, new.look.shapes), (self._frames, new.look.frames)):
            if box.value != value:
                box.value = value
        if old is None or old.own.measured is not new.own.measured:
            self._measured.content = measured_line(new.own.measured)
        if self._reach.value != (new.look.reach or NOT_SHOWN):
            self._reach.value = new.look.reach or NOT_SHOWN
        is_same_reach = old is not None and old.look.reach == new.look.reach
        if old is None or not is_same_reach or old.reached is not new.reached:
            self._reached.content = reach_line(new.look.reach, new.reached, self._visitor.words)
        self._jog.show(old, new)

    def _show_tools(self, state: State, cannot: str) -> None:
        for name, dropdown in self._tools.items():
            tools = tuple(tool.name for tool in state.cell.arm(name).tools)
            dropdown.disabled, dropdown.visible = bool(cannot), len(tools) > 1
            is_unknown = name in state.tools_unknown
            options = (NOT_KNOWN, *tools) if is_unknown else tools
            if dropdown.options != options:
                dropdown.options = options
            value = NOT_KNOWN if is_unknown else state.cell.arm(name).tool.name
            if dropdown.value != value:
                dropdown.value = value

    def _react(self) -> None:
        visitor, look = self._visitor, self._visitor.look
        self._thing.on_update(self._on_chosen)
        visitor.on_press(self._undo, UndoCell)
        visitor.on_press(self._redo, RedoCell)
        self._save.on_click(lambda _: self._save_cell())
        for name, dropdown in self._tools.items():
            dropdown.on_update(lambda event, name=name: self._on_mount(event, name))
        self._measure.on_click(lambda _: self._turn_measuring())
        visitor.by_hand(self._reach, lambda arm: look.change(reach="" if arm == NOT_SHOWN else arm))
        visitor.by_hand(self._shapes, lambda shown: look.change(shapes=bool(shown)))
        visitor.by_hand(self._frames, lambda shown: look.change(frames=bool(shown)))

    def _on_chosen(self, event: Any) -> None:
        """Another thing is in the field: by a person, or since the one before is gone."""
        visitor, thing = self._visitor, self._thing.value
        if event.client is not None:
            visitor.own.change(thing=thing)
        self._show_thing(visitor.cell, visitor.obstacle(visitor.bench.state, ChangeCell))

    def _show_thing(self, cell: Cell, problem: str) -> None:
        thing = self._thing.value
        frame = frame_of(cell, thing)
        self._inputs.show(pose_of(cell, thing), problem=problem, T_world_frame=frame)

    def _not_moved(self) -> str:
        """What a person does first with numbers to which no object was moved; empty: nothing."""
        if not self._inputs.is_typed():
            return ""
        return self._visitor.words.render(CellPageText.MOVE_FIRST())

    def _save_cell(self) -> None:
        """Save with the remark, which goes once it is in the files."""
        self._is_saving = True
        self._is_saving = self._visitor.save(lambda: SaveCell(self._remark.value))

    def _turn_measuring(self) -> None:
        """The next two clicks into the scene are points to measure between; or none any more."""
        if self._clicked is not None:
            self._end_measuring()
            return
        self._visitor.own.change(measured=())
        self._measure.label = "Click on two points"

        @self._visitor.client.scene.on_click()
        def click(event: Any) -> None:
            self._measure_to(np.array(event.ray_origin), np.array(event.ray_direction))

        self._clicked = click

    def _end_measuring(self) -> None:
        clicked, self._clicked = self._clicked, None
        if clicked is not None:
            self._visitor.client.scene.remove_click_callback(clicked)
            self._measure.label = "Measure"

    def _measure_to(self, origin: Floats, direction: Floats) -> None:
        """A person has clicked along a ray, of which each is (3,) [m] in the world."""
        view, own = self._view, self._visitor.own
        if view is None:
            return
        p = pointed_at(view, origin, direction)
        if p is not None:
            own.change(measured=(*own.now.measured, p)[:2])
        if len(own.now.measured) == 2:
            self._end_measuring()

    def _on_mount(self, event: Any, arm: str) -> None:
        """A person has put another tool on an arm."""
        tool, state = str(event.target.value), self._visitor.bench.state
        is_known = arm not in state.tools_unknown
        if event.client is None or tool == NOT_KNOWN:
            return
        if is_known and tool == self._visitor.cell.arm(arm).tool.name:
            return
        self._visitor.ask(lambda: StateTool(arm, tool))

    def _otherwise(self, T: pin.SE3) -> Mapping[str, Any] | None:
        """What is other while a thing is dragged; scanner and TCP are in no verdict."""
        cell, thing = self._visitor.cell, self._thing.value
        is_in_none = thing == SCANNER or bool(tool_of(cell, thing))
        return None if is_in_none else {"change": moving(cell, thing, T)}

    def _poses_carried(self, T: pin.SE3) -> Mapping[str, pin.SE3]:
        """What follows the hand that drags a thing."""
        shapes = self._visitor.look.now.shapes
        return nodes_with(self._visitor.cell, self._thing.value, T, as_checked=shapes)

    def _move(self, T: pin.SE3) -> bool:
        thing, cell = self._thing.value, self._visitor.cell
        return self._visitor.ask(
            lambda: ChangeCell(
                move_frame(cell, thing, T), EditText.MOVED(thing=thing), was=cell.digest
            )
        )
