"""The tab that plays a plan: scrubber, lanes, and curves over time."""

import math

import viser

from workbench.app.core.cycle.planning import MOST_OUTLINES, MakePlan
from workbench.app.core.state import State
from workbench.gui.drawing.play_button import PlayButton, play_problem
from workbench.gui.plan.curves import doing, lanes_html, now_html, plots_of
from workbench.gui.plan.views import outlines_html, plan_html
from workbench.gui.scene.nearest import PlanLinks, proof_html
from workbench.gui.shared.look import AFTER_CYCLE, View
from workbench.gui.shared.plots import Plot, cursor_style, legend_html, plot_html
from workbench.gui.shared.views import line
from workbench.gui.shared.viser_server import element_id
from workbench.gui.shared.visitor import Visitor

TO_START, END_PREVIEW = "To the start", "End preview"
"""What the button says: after a cycle the robot is not at the plan's start to be viewed."""

STEP = 0.01
"""[s] Of the slider."""


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
            step=STEP,
            initial_value=0.0,
            hint="Drag to move the arms along the plan; it only shows, nothing is sent.",
        )
        self._links = PlanLinks(visitor)
        self._plans = visitor.rows(MOST_OUTLINES, self._again)
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._play = PlayButton(visitor)
        self._start = gui.add_button(TO_START, icon=viser.Icon.PLAYER_SKIP_BACK, color="gray")
        self._at = gui.add_html("")
        # A plot and its legend for clearance, the arms' distance, speeds, and each arm's axes.
        count = 2 + (len(cell.arms) > 1) + len(cell.arms)
        self._drawn = [(gui.add_html(""), gui.add_html("")) for _ in range(count)]
        self._plots: tuple[Plot, ...] = ()
        self._end = 0.0
        self._react()

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        is_other = old is None or old.state.outlines is not new.state.outlines
        if is_other or (old is not None and old.state.plans != new.state.plans):
            self._draw_plan(new)
        if old is None or old.state is not new.state:
            problem = play_problem(self._visitor, new.state)
            self._time.disabled = bool(problem)
            self._visitor.allow(self._start, problem)
            self._start.label = END_PREVIEW if self._ends_preview(new.state) else TO_START
        is_moved = old is None or old.runs is not new.runs or old.look.time != new.look.time
        if is_moved and new.runs:
            now = doing(new.runs, new.look.time)
            self._cursor.content = now_html(
                new.look.time, new.plan_seconds, now, self._visitor.words
            )
            self._at.content = cursor_style(new.look.time, new.plan_seconds)
            # Values are read when it stands still.
            if not new.look.is_playing:
                self._show_values(new.look.time)
            # The browser that drags knows best where its own slider stands.
            if new.look.by != self._visitor.number:
                self._time.value = round(new.look.time, 2)
        self._play.show(old, new)

    def _ends_preview(self, state: State) -> bool:
        """Whether there is a robot to look at again that does not stand at the plan's start."""
        return state.phase in AFTER_CYCLE and not self._visitor.is_recorded

    def _draw_plan(self, view: View) -> None:
        state, runs, seconds = view.state, view.runs, view.plan_seconds
        cell, taken = state.cell, "" if state.plan is None else state.plan.digest
        outlines = outlines_html(state.outlines, taken, self._plans, self._visitor.words)
        if state.plan is None:
            hint = line("A plan can be played here once it was made.", kind="hint")
            self._summary.content = hint + outlines
            self._lanes.content = self._cursor.content = self._nearest.content = ""
            self._plots = ()
            self._clear_plots(0)
            self._time.value = 0.0
            return
        self._summary.content = plan_html(state, self._visitor.words) + outlines
        self._lanes.content = lanes_html(cell, runs, seconds, self._visitor.words)
        self._end = seconds
        # To the next step: the end can be reached, whatever comes after its second decimal.
        self._time.max = max(round(math.ceil(round(seconds / STEP, 6)) * STEP, 2), STEP)
        self._nearest.content = proof_html(state, self._links) if state.whole_row else ""
        self._plots = plots_of(
            cell,
            runs,
            seconds,
            [proven_plan.proof for proven_plan in state.whole_row],
            self._visitor.words,
        )
        slider = element_id(self._time)
        for (drawn, _), plot in zip(self._drawn, self._plots, strict=False):
            drawn.content = plot_html(plot, seconds, slider)
        self._clear_plots(len(self._plots))
        self._show_values(view.look.time)

    def _clear_plots(self, first: int) -> None:
        """Take away the plots from the `first` on: of a plan before, or that had a proof."""
        for pair in self._drawn[first:]:
            for html in pair:
                html.content = ""

    def _show_values(self, time: float) -> None:
        for (_, legend), plot in zip(self._drawn, self._plots, strict=False):
            legend.content = legend_html(plot, time)

    def _react(self) -> None:
        self._visitor.by_hand(self._time, self._go_to)
        self._visitor.on_key("K", "Play or pause the plan", self._play.press)
        self._start.on_click(lambda _: self._go_back())

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

    def _again(self, number: int) -> None:
        """Make a plan of the table once more: what is taken is always the plan made last."""
        visitor = self._visitor
        state = visitor.bench.state
        if number >= len(state.outlines):
            return
        if problem := visitor.obstacle(state, MakePlan):
            visitor.notify("Refused", problem)
            return
        outline = state.outlines[number]
        visitor.ask(
            lambda: MakePlan(outline.asked, outline.threshold, outline.seed, outline.overrides)
        )
