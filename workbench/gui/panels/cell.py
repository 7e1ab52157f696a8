"""The tab that shows what the cell is made of: to move things, jog the robot, and save."""

from typing import Any

import numpy as np
import viser

from workbench.app.commands import ChangeCell, Command, RedoCell, SaveCell, UndoCell
from workbench.app.rights import obstacle
from workbench.gui.cell_views import cell_line, measured_line
from workbench.gui.jogging import JogControls
from workbench.gui.look import View
from workbench.gui.measure import met
from workbench.gui.robot import place, pose_of_node, quaternion
from workbench.gui.things import moved, pose_of, shown_pose, things, typed_pose
from workbench.gui.visitor import Visitor
from workbench.model.cell import Cell

NOBODY = "not shown"
GIZMO = 0.18
"""[m] Size of the gizmo that moves a thing."""


class CellPanel:
    """Things with their poses, the robot by hand, undo, redo and save.

    Concurrency: callbacks of viser change this browser's gizmo and controls, the shared look, or
    give commands; the renderer's thread draws what came of them.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._gizmo: viser.TransformControlsHandle | None = None
        self._clicked: Any = None
        gui, cell = visitor.gui, visitor.cell
        with gui.add_folder("Things in the cell"):
            self._thing = gui.add_dropdown(
                "Thing", things(cell), hint="What the numbers and the gizmo below move."
            )
            self._position = gui.add_vector3(
                "Position [mm]", (0.0, 0.0, 0.0), step=1.0, hint="In the world frame."
            )
            self._angles = gui.add_vector3(
                "Angles [deg]", (0.0, 0.0, 0.0), step=1.0, hint="Roll, pitch, yaw: fixed axes."
            )
            gui.add_html('<div class="wb-buttons wb-two"></div>')
            self._apply = gui.add_button("Move it there", icon=viser.Icon.CHECK)
            self._show_gizmo = gui.add_button("Show gizmo", color="gray")
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
                (NOBODY, *(arm.name for arm in cell.arms)),
                hint="Where an arm gets its tool pointing straight down, whatever stands there: "
                "green at any turn of the tool, orange at some.",
            )
            self._measure = gui.add_button(
                "Measure",
                icon=viser.Icon.RULER,
                color="gray",
                hint="Then click on two points in the scene.",
            )
            self._measured = gui.add_html("")
        with gui.add_folder("Robot by hand"):
            self._jog = JogControls(visitor)
        with gui.add_folder("Cell file"):
            self._remark = gui.add_text(
                "Remark", "", hint="Why the cell was changed; kept in changes.log beside it."
            )
            self._save = gui.add_button("Save", icon=viser.Icon.DEVICE_FLOPPY)
            self._line = gui.add_html("")
        self._show_pose(cell)
        self._react()

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state, cell = new.state, new.state.cell
        if old is None or old.state.cell is not cell:
            names = things(cell)
            if self._thing.options != names:
                self._thing.options = names
            self._show_pose(cell)
        if old is None or old.state is not state:
            cannot = bool(obstacle(state, ChangeCell))
            self._apply.disabled = cannot
            self._undo.disabled = cannot or not state.before
            self._redo.disabled = cannot or not state.undone
            self._save.disabled = bool(obstacle(state, SaveCell)) or state.saved == cell.digest
            self._line.content = cell_line(state)
        for box, value in ((self._shapes, new.look.shapes), (self._frames, new.look.frames)):
            if box.value != value:
                box.value = value
        if old is None or old.look.measured is not new.look.measured:
            self._measured.content = measured_line(new.look.measured)
        if self._reach.value != (new.look.reach or NOBODY):
            self._reach.value = new.look.reach or NOBODY
        self._jog.show(old, new)

    def _show_pose(self, cell: Cell) -> None:
        """The pose of the chosen thing in the numbers and the gizmo."""
        T = pose_of(cell, self._thing.value)
        self._position.value, self._angles.value = shown_pose(T)
        if self._gizmo is not None:
            place(self._gizmo, T)

    def _react(self) -> None:
        visitor, look = self._visitor, self._visitor.look
        self._thing.on_update(lambda _: self._show_pose(visitor.cell))
        visitor.on_press(self._apply, self._wanted_move)
        visitor.on_press(self._undo, UndoCell)
        visitor.on_press(self._redo, RedoCell)
        visitor.on_press(self._save, lambda: SaveCell(self._remark.value))
        self._show_gizmo.on_click(lambda _: self._turn_gizmo())
        self._measure.on_click(lambda _: self._begin_to_measure())

        @self._reach.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                chosen = event.target.value
                look.change(reach="" if chosen == NOBODY else chosen)

        @self._shapes.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                look.change(shapes=bool(event.target.value))

        @self._frames.on_update
        async def _(event: Any) -> None:
            if event.client is not None:
                look.change(frames=bool(event.target.value))

    def _begin_to_measure(self) -> None:
        """The next two clicks into the scene are points to measure between."""
        scene, look = self._visitor.client.scene, self._visitor.look
        if self._clicked is not None:
            return
        look.change(measured=())
        self._measure.label = "Click on two points"

        @scene.on_click()
        def clicked(event: Any) -> None:
            state = self._visitor.bench.state
            points = np.zeros((0, 3)) if state.scan is None else state.scan.points_world
            p = met(
                np.array(event.ray_origin),
                np.array(event.ray_direction),
                state.cell,
                look.now.jog or {},
                points,
            )
            if p is None:
                return
            look.change(measured=(*look.now.measured, p)[:2])
            if len(look.now.measured) == 2:
                scene.remove_click_callback(self._clicked)
                self._clicked, self._measure.label = None, "Measure"

        self._clicked = clicked

    def _wanted_move(self) -> Command:
        thing = self._thing.value
        T = typed_pose(self._position.value, self._angles.value)
        return ChangeCell(moved(self._visitor.cell, thing, T), f"the {thing} is moved")

    def _turn_gizmo(self) -> None:
        """Show the gizmo in this browser, or take it away."""
        if self._gizmo is not None:
            self._gizmo.remove()
            self._gizmo, self._show_gizmo.label = None, "Show gizmo"
            return
        T = pose_of(self._visitor.cell, self._thing.value)
        gizmo = self._visitor.client.scene.add_transform_controls(
            "/cell_gizmo",
            GIZMO,
            position=T.translation,
            wxyz=quaternion(T),
            depth_test=False,
        )
        self._gizmo, self._show_gizmo.label = gizmo, "Hide gizmo"

        @gizmo.on_update
        def _(event: Any) -> None:
            # From the numbers that are shown: what a person reads is what is meant.
            position, angles = shown_pose(pose_of_node(gizmo))
            self._position.value, self._angles.value = position, angles
            if event.phase != "end":
                return
            thing = self._thing.value
            T = typed_pose(position, angles)
            was_done = self._visitor.ask(
                lambda: ChangeCell(moved(self._visitor.cell, thing, T), f"the {thing} is moved")
            )
            if not was_done:
                self._show_pose(self._visitor.cell)
