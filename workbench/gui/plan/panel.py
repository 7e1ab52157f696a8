"""The tab that plays a plan: scrubber, lanes, and curves over time."""

from typing import Any

import numpy as np
import viser

from workbench.app.core.commands import WatchPlan
from workbench.app.core.state import Phase
from workbench.gui.scene.nearest import PlanLinks, proof_html
from workbench.gui.shared.charts import (
    JOINTS,
    LEGS,
    axis,
    clearance_curves,
    cursor_html,
    curve,
    doing,
    joint_curves,
    lanes_html,
    speed_curve,
)
from workbench.gui.shared.colours import arm_colour
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line, outlines_html, plan_html
from workbench.gui.shared.visitor import Visitor

NOTHING = np.array([0.0, 1.0])


class PlanPanel:
    """Moves the arms in the scene along the plan.

    Concurrency: clicks and drags only change the shared look; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        cell = visitor.cell
        gui = visitor.gui
        self._summary = gui.add_html("")
        self._nearest = gui.add_html("")
        self._lanes = gui.add_html("")
        self._cursor = gui.add_html("")
        self._time = gui.add_slider(
            "Time [s]",
            min=0.0,
            max=1.0,
            step=0.01,
            initial_value=0.0,
            hint="Drag to move the arms along the plan; it only shows, nothing is sent.",
        )
        self._links = PlanLinks(visitor)
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._play = gui.add_button("Play", icon=viser.Icon.PLAYER_PLAY)
        self._start = gui.add_button("To the start", icon=viser.Icon.PLAYER_SKIP_BACK, color="gray")
        has_two = len(cell.arms) > 1
        self._clearance = gui.add_uplot(
            (NOTHING, NOTHING, NOTHING, NOTHING)[: 3 + has_two],
            (
                curve("time [s]"),
                curve("free legs (up to 100 mm)"),
                curve("straight ways (up to 100 mm)", LEGS["extract"]),
                curve("between the arms (up to 400 mm)", JOINTS[3]),
            )[: 3 + has_two],
            scales={"x": {"time": False}},
            axes=(axis("time [s]"), axis("kept at least [mm]")),
            height=170,
            visible=False,
        )
        self._speed = gui.add_uplot(
            (NOTHING, *(NOTHING for _ in cell.arms)),
            (
                curve("time [s]"),
                *(curve(arm.name, arm_colour(k)) for k, arm in enumerate(cell.arms)),
            ),
            scales={"x": {"time": False}, "y": {"range": (0.0, 105.0)}},
            axes=(axis("time [s]"), axis("fastest axis [%]")),
            height=150,
            visible=False,
        )
        self._joints = {
            arm.name: gui.add_uplot(
                (NOTHING, *(NOTHING for _ in arm.joints)),
                (
                    curve("time [s]"),
                    *(curve(f"{k + 1}", JOINTS[k % len(JOINTS)]) for k in range(len(arm.joints))),
                ),
                scales={"x": {"time": False}},
                axes=(axis("time [s]"), axis(f"{arm.name} axes [deg]")),
                height=170,
                visible=False,
            )
            for arm in cell.arms
        }
        self._react()

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        is_other = old is None or old.state.outlines is not new.state.outlines
        if is_other or (old is not None and old.state.plan is not new.state.plan):
            self._draw_plan(new)
        if old is None or old.state is not new.state:
            # While a plan is sent, its picture follows the robot.
            is_free = new.state.plan is not None and new.state.phase is not Phase.SENDING
            # Viewers see what those see who act.
            is_free = is_free and not self._visitor.lacks(new.state, WatchPlan)
            for control in (self._time, self._play, self._start):
                control.disabled = not is_free
        is_moved = old is None or old.runs is not new.runs or old.look.time != new.look.time
        if is_moved and new.runs:
            now = doing(new.state.cell, new.runs, new.look.time)
            self._cursor.content = cursor_html(
                new.look.time, new.plan_seconds, now, len(new.state.cell.arms)
            )
            # The browser that drags knows best where its own slider stands.
            if new.look.by != self._visitor.number:
                self._time.value = round(new.look.time, 2)
        if old is None or old.look.is_playing != new.look.is_playing:
            self._play.label = "Pause" if new.look.is_playing else "Play"
            self._play.icon = (
                viser.Icon.PLAYER_PAUSE if new.look.is_playing else viser.Icon.PLAYER_PLAY
            )

    def _draw_plan(self, view: View) -> None:
        state, runs, seconds = view.state, view.runs, view.plan_seconds
        cell = state.cell
        has_plan = state.plan is not None
        for plot in (self._clearance, self._speed, *self._joints.values()):
            plot.visible = has_plan
        if state.plan is None:
            hint = line("A plan can be played here once it was made.", kind="hint")
            self._summary.content = hint + outlines_html(state.outlines)
            self._lanes.content = self._cursor.content = self._nearest.content = ""
            self._time.value = 0.0
            return
        self._summary.content = plan_html(cell, state.plan, state.seconds) + outlines_html(
            state.outlines
        )
        self._lanes.content = lanes_html(cell, runs, seconds)
        self._time.max = max(round(seconds, 2), 0.01)
        if state.proof is not None:
            curves = clearance_curves(runs, state.proof)
            self._clearance.data = curves[: 3 + (len(cell.arms) > 1)]
            self._nearest.content = proof_html(state, state.plan, state.proof, self._links)
        speeds = [speed_curve(arm, cell, runs, seconds) for arm in cell.arms]
        self._speed.data = (np.linspace(0.0, max(seconds, 1e-3), len(speeds[0])), *speeds)
        for arm in cell.arms:
            self._joints[arm.name].data = joint_curves(arm, runs, seconds)

    def _react(self) -> None:
        look, number = self._visitor.look, self._visitor.number

        @self._time.on_update
        async def _(event: Any) -> None:
            # The renderer sets the slider too; only a person's hand comes with a browser.
            if event.client is not None:
                look.change(time=float(event.target.value), is_playing=False, by=number)

        self._play.on_click(lambda _: self._play_or_pause())
        self._visitor.on_key("K", "Play or pause the plan", self._play_or_pause)
        self._start.on_click(lambda _: look.change(time=0.0, is_playing=False, by=None))

    def _play_or_pause(self) -> None:
        visitor, look = self._visitor, self._visitor.look
        if not self._play.disabled:
            visitor.own.end()
            look.change(is_playing=not look.now.is_playing, by=None, browser=visitor.number)
