"""The bar under the scene that plays the plan: play, speed, loop, and its legs over the time."""

import math
from html import escape

import viser

from workbench.app.core.state import Phase, State
from workbench.gui.drawing.play_button import PlayButton, play_problem
from workbench.gui.plan.curves import bands_html
from workbench.gui.shared.look import AFTER_CYCLE, View
from workbench.gui.shared.plots import cursor_style
from workbench.gui.shared.viser_server import element_id
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.plan import PlanText

TO_START, END_PREVIEW = "To the start", "End preview"
"""What the button says: after a cycle the robot is not at the plan's start to be viewed."""

SLIDER_STEP = 0.01
"""[s] Of the slider."""

SPEEDS = {"0.25 x": 0.25, "0.5 x": 0.5, "1 x": 1.0, "2 x": 2.0, "4 x": 4.0}
"""Seconds of the plan in a second, by what the page calls them."""

FOLDER_NAME = "Preview"
"""Of its folder, whose heading is out of sight: it is a bar, not a group of a tab."""

MARK = '<div class="wb-transport"></div>'
"""Has its folder laid over the foot of the scene, see `static/panel.css`."""


class Transport:
    """Moves the arms in the scene along the plan, or of a row along all its plans.

    Concurrency: clicks and drags only change the shared look; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the bar, out of sight until there is a plan."""
        self._visitor = visitor
        self._end = 0.0
        gui = visitor.gui
        self._folder = gui.add_folder(FOLDER_NAME, visible=False)
        with self._folder:
            gui.add_html(MARK)
            self._start = gui.add_button(TO_START, icon=viser.Icon.PLAYER_SKIP_BACK, color="gray")
            self._play = PlayButton(visitor)
            self._bands = gui.add_html("")
            self._time = gui.add_slider(
                "Time [s]", min=0.0, max=1.0, step=SLIDER_STEP, initial_value=0.0
            )
            self._speed = gui.add_dropdown(
                "Speed",
                tuple(SPEEDS),
                initial_value="1 x",
                hint="What plays faster than the robot moves does not count as watched.",
            )
            self._loops = gui.add_checkbox("Loop", False)
            self._cursor = gui.add_html("")
            self._clock = gui.add_html("")
        self.slider = element_id(self._time)
        """What a click into a plot moves."""
        visitor.by_hand(self._time, self._go_to)
        visitor.by_hand(self._speed, lambda said: visitor.look.change(speed=SPEEDS.get(said, 1.0)))
        visitor.by_hand(self._loops, lambda is_on: visitor.look.change(loops=bool(is_on)))
        visitor.on_key("K", "Play or pause the plan", self._play.press)
        self._start.on_click(lambda _: self._go_back())

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state, look = new.state, new.look
        if old is None or old.state.plans != state.plans:
            self._draw_plan(new)
        if old is None or old.state is not state:
            self._show_clock(new)
            problem = play_problem(self._visitor, state)
            for control in (self._time, self._speed, self._loops):
                control.disabled = bool(problem)
            self._visitor.allow(self._start, problem)
            self._start.label = END_PREVIEW if self._ends_preview(state) else TO_START
        if new.runs and (old is None or old.runs is not new.runs or old.look.time != look.time):
            self._cursor.content = cursor_style(look.time, new.plan_seconds)
            # The browser that drags knows best where its own slider stands.
            if look.by != self._visitor.number:
                self._time.value = round(look.time, 2)
        if old is None or (old.look.speed, old.look.loops) != (look.speed, look.loops):
            self._speed.value = next(
                (words for words, speed in SPEEDS.items() if speed == look.speed), "1 x"
            )
            self._loops.value = look.loops
        self._play.show(old, new)

    def _draw_plan(self, view: View) -> None:
        state, seconds = view.state, view.plan_seconds
        self._folder.visible = state.plan is not None
        self._end = seconds
        # To the next step: the end can be reached, whatever comes after its second decimal.
        self._time.max = max(
            round(math.ceil(round(seconds / SLIDER_STEP, 6)) * SLIDER_STEP, 2), SLIDER_STEP
        )
        if state.plan is None:
            self._bands.content = self._cursor.content = ""
            self._time.value = 0.0
            return
        words = self._visitor.words
        self._bands.content = bands_html(state.cell, view.runs, seconds, words)

    def _show_clock(self, view: View) -> None:
        """How long the plan is; and that the mark is no preview while it follows the robot."""
        is_sent = view.state.phase is Phase.SENDING and not view.is_recorded
        text = PlanText.ROBOT_OF_SECONDS if is_sent else PlanText.OF_SECONDS
        total = escape(self._visitor.words.render(text(total=view.plan_seconds)))
        kind = " wb-follows" if is_sent else ""
        html = f'<div class="wb-clock{kind}">{total}</div>' if view.state.plan else ""
        if html != self._clock.content:
            self._clock.content = html

    def _ends_preview(self, state: State) -> bool:
        """Whether there is a robot to view again that does not stand at the plan's start."""
        return state.phase in AFTER_CYCLE and not self._visitor.is_recorded

    def _go_to(self, time: float) -> None:
        # The last step of the slider may lie beyond the end.
        time = max(0.0, min(float(time), self._end))
        self._visitor.look.change(time=time, is_playing=False, by=self._visitor.number)

    def _go_back(self) -> None:
        look = self._visitor.look
        if self._ends_preview(self._visitor.bench.state):
            look.change(**look.now.real_moment)
        else:
            look.change(time=0.0, is_playing=False, by=None)
