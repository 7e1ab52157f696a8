"""The controls that move the robot by hand, in one browser only: nothing is sent to it."""

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import viser

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.command import Command
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.state import Phase
from workbench.gui.cell.jog import lead_to
from workbench.gui.cell.views import contacts_html
from workbench.gui.dragging.gizmo_drag import add_gizmo
from workbench.gui.scene.robot import place, pose_of_node
from workbench.gui.shared.look import View
from workbench.gui.shared.movable_frames import shown_pose, typed_pose, with_home, with_places
from workbench.gui.shared.views import sentence
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.cell import CellPageText
from workbench.model.cell import Arm
from workbench.model.derived.controller_axes import (
    from_shown,
    shown_axes,
    shown_limits,
    shown_units,
)
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.commands import EditText
from workbench.planning.kinematics.chain import Chain, chain_of
from workbench.planning.kinematics.self_motion import self_motion

GIZMO = 0.15
"""[m] Size of the gizmo at the tool."""

WATCH = "while a plan is sent, everybody sees where the robot is"


class JogControls:
    """An arm, its axes as the controller counts them, its elbow, and a gizmo at its tool.

    Concurrency: as `CellPanel`; everything that callbacks leave is replaced as a whole.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls to the folder that is open."""
        self._visitor = visitor
        self._gizmo: viser.TransformControlsHandle | None = None
        self._is_dragged = False
        self._key: tuple[object, ...] = (None,) * 7
        self._drawn: Mapping[str, Floats] | None = None
        # What this browser has made of it: the whole, and whether it was by the axes' sliders.
        self._mine: Mapping[str, Floats] | None = None
        self._by_axes = False
        self._shown = ""
        self._elbows: tuple[Floats, Floats] | None = None
        gui, cell = visitor.gui, visitor.cell
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._switch = gui.add_button("Jog", icon=viser.Icon.HAND_MOVE)
        self._home = gui.add_button("Go home", icon=viser.Icon.HOME, color="gray")
        self._teach_home = gui.add_button("Teach as home", color="gray")
        self._teach_place = gui.add_button("Teach as place", color="gray")
        self._contacts = gui.add_html("")
        names = tuple(arm.name for arm in cell.arms)
        self._arm = gui.add_dropdown("Arm", names, visible=len(names) > 1)
        self._axes = {arm.name: self._sliders(gui, arm) for arm in cell.arms}
        self._elbow = gui.add_slider(
            "Elbow [%]",
            min=-100.0,
            max=100.0,
            step=1.0,
            initial_value=0.0,
            hint="Turns the elbow while the tool stays where it is.",
        )
        self._react()
        visitor.on_end(self._hide_gizmo, in_scene=True)

    def _sliders(self, gui: viser.GuiApi, arm: Arm) -> list[viser.GuiSliderHandle[float]]:
        cell, words = self._visitor.cell, self._visitor.words
        units, home = shown_units(cell, arm), shown_axes(cell, arm, arm.home)
        return [
            gui.add_slider(
                words.render(CellPageText.AXIS(number=axis, unit=unit)),
                min=math.ceil(round(low * 10, 6)) / 10,
                max=math.floor(round(high * 10, 6)) / 10,
                step=0.1,
                initial_value=round(float(value), 1),
            )
            for axis, (unit, low, high, value) in enumerate(
                zip(units, *shown_limits(cell, arm), home, strict=True), start=1
            )
        ]

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        if old is None or old.jogged is not new.jogged:
            self._contacts.content = contacts_html(new.jogged, self._visitor.words)
        jog = new.own.jog
        is_on, name = jog is not None, self._arm.value
        is_covered = new.overlay is not None
        is_sending = new.state.phase is Phase.SENDING
        is_preparing = new.live.getting_ready is not None
        key = (jog, name, new.state.cell, new.state.control, is_sending, is_preparing, is_covered)
        if all(cell is other for cell, other in zip(key, self._key, strict=True)):
            return
        self._key = key
        arm = new.state.cell.arm(name)
        has_spare = len(arm.joints) > 6
        self._switch.label = "End jogging" if is_on else "Jog"
        # It serves to teach and to scan: who may not do that has no use for it.
        problem = self._visitor.lacks(new.state, TakeScan) or (WATCH if is_sending else "")
        self._switch.disabled = bool(problem) or (is_preparing and not is_on)
        ready = new.live.getting_ready
        waits = "" if ready is None else sentence(self._visitor.words.render(ready.note))
        self._visitor.explain(self._switch, problem or waits)
        for button in (self._home, self._teach_home, self._teach_place):
            self._visitor.allow(button, problem or ("" if is_on else "press Jog first"))
        self._elbow.disabled = bool(problem)
        for owner, sliders in self._axes.items():
            for slider in sliders:
                slider.visible = is_on and owner == name
                slider.disabled = bool(problem)
        self._elbow.visible = is_on and has_spare
        if jog is not None and (jog is not self._drawn or name != self._shown):
            if jog is not self._mine:
                self._elbows = None
            if jog is not self._mine or not self._by_axes or name != self._shown:
                self._show_sliders(arm, jog[name])
            if self._elbows is None and self._elbow.value != 0.0:
                self._elbow.value = 0.0
        self._drawn, self._shown = jog, name
        self._show_gizmo(arm, is_on and not problem and not is_covered)

    def _show_sliders(self, arm: Arm, q: Floats) -> None:
        values = shown_axes(self._visitor.cell, arm, q)
        for slider, value in zip(self._axes[arm.name], values, strict=True):
            slider.value = min(max(round(float(value), 1), slider.min), slider.max)

    def _show_gizmo(self, arm: Arm, is_on: bool) -> None:
        """The gizmo follows the tool of the chosen arm; only this browser has it."""
        if not is_on or self._drawn is None:
            self._hide_gizmo()
            return
        T = self._chain(arm).pose(self._drawn[arm.name])
        if self._gizmo is None:
            self._gizmo = add_gizmo(self._visitor, "/jog_gizmo", GIZMO, T)
            self._gizmo.on_update(self._lead)
        elif not self._is_dragged:
            place(self._gizmo, T)

    def _hide_gizmo(self) -> None:
        gizmo, self._gizmo = self._gizmo, None
        if gizmo is not None:
            gizmo.remove()

    def _chain(self, arm: Arm) -> Chain:
        return chain_of(self._visitor.cell, arm)

    def _react(self) -> None:
        visitor = self._visitor
        self._switch.on_click(lambda _: self._turn())
        self._home.on_click(lambda _: self._move(np.asarray(self._chosen.home)))
        visitor.on_press(self._teach_home, self._wanted_home)
        visitor.on_press(self._teach_place, self._wanted_place)
        self._arm.on_update(lambda _: visitor.own.change())
        for name, sliders in self._axes.items():
            for slider in sliders:
                slider.on_update(partial(self._slid, name))
        visitor.by_hand(self._elbow, lambda percent: self._turn_elbow(float(percent) / 100))

    @property
    def _chosen(self) -> Arm:
        return self._visitor.cell.arm(self._arm.value)

    def _turn(self) -> None:
        visitor = self._visitor
        if visitor.own.now.jog is not None:
            visitor.own.change(jog=None)
            return
        visitor.turn_away()
        visitor.own.change(jog={arm.name: np.asarray(arm.home) for arm in visitor.cell.arms})

    def _move(
        self, q: Floats, *, by_axes: bool = False, elbows: tuple[Floats, Floats] | None = None
    ) -> None:
        """Move the chosen arm to `q` (n,), as far as its limits let it."""
        arm, own = self._chosen, self._visitor.own
        if own.now.jog is None or not np.all(np.isfinite(q)):
            return
        lower, upper, _ = self._visitor.cell.robot.limits(arm.joints)
        jog = {**own.now.jog, arm.name: np.clip(q, lower, upper)}
        # Where a joint at its limit counts in several axes, the other sliders have to follow.
        is_whole = bool(np.allclose(jog[arm.name], q))
        self._mine, self._by_axes, self._elbows = jog, by_axes and is_whole, elbows
        own.change(jog=jog)

    def _slid(self, name: str, event: Any) -> None:
        # The renderer sets sliders too; only a person's hand comes with a browser.
        jog = self._visitor.own.now.jog
        if event.client is None or jog is None or name != self._arm.value:
            return
        cell = self._visitor.cell
        arm = cell.arm(self._arm.value)
        shown = shown_axes(cell, arm, jog[name])
        for axis, slider in enumerate(self._axes[name]):
            if slider is event.target:
                shown[axis] = float(slider.value)
        self._move(from_shown(cell, arm, shown), by_axes=True)

    def _turn_elbow(self, share: float) -> None:
        """To a share of the way, -1..1, along what the elbow can do from where it was first."""
        jog, arm = self._visitor.own.now.jog, self._chosen
        if jog is None or not math.isfinite(share):
            return
        elbows = self._elbows
        if elbows is None:
            path = self_motion(self._chain(arm), jog[arm.name])
            middle = int(np.abs(path - jog[arm.name]).max(axis=1).argmin())
            elbows = (path[: middle + 1][::-1], path[middle:])
        side = elbows[1] if share > 0 else elbows[0]
        self._move(side[round(min(abs(share), 1.0) * (len(side) - 1))], elbows=elbows)

    async def _lead(self, event: Any) -> None:
        """The tool follows the gizmo as far as the arm reaches."""
        self._is_dragged = event.phase != "end"
        jog, arm, gizmo = self._visitor.own.now.jog, self._chosen, self._gizmo
        if jog is None or gizmo is None:
            return
        position, angles = shown_pose(pose_of_node(gizmo))
        q = lead_to(self._chain(arm), jog[arm.name], typed_pose(position, angles))
        if q is not None:
            self._move(q)
        if not self._is_dragged:
            # Out of reach the gizmo ran ahead: back to where the tool is.
            place(gizmo, self._chain(arm).pose(self._now(arm)))

    def _now(self, arm: Arm) -> Floats:
        """Where the arm stands."""
        jog = self._visitor.own.now.jog
        if jog is None:
            raise InputError("nobody jogs the robot")
        return jog[arm.name]

    def _wanted_home(self) -> Command:
        cell = self._visitor.cell
        arm = cell.arm(self._arm.value)
        home = cell.controller.motion.rounded(self._now(arm))
        after = with_home(cell, arm.name, home)
        return ChangeCell(after, EditText.HOME(arm=arm.name), was=cell.digest)

    def _wanted_place(self) -> Command:
        cell = self._visitor.cell
        arm = cell.arm(self._arm.value)
        T = typed_pose(*shown_pose(self._chain(arm).pose(self._now(arm))))
        after = with_places(cell, arm.name, (*arm.Ts_world_place, T))
        return ChangeCell(after, EditText.PLACE_ADDED(arm=arm.name), was=cell.digest)
