"""The tab that shows a plan: facts, lanes, and curves over time."""

import viser

from workbench.app.core.cell.part_edits import EditPart
from workbench.app.core.cycle.planning import MOST_OUTLINES, MakePlan
from workbench.app.filling.found_grips import make_found_commands
from workbench.gui.drawing.nearest import PlanLinks, proof_html
from workbench.gui.plan.curves import doing, lanes_html, now_html, plots_of
from workbench.gui.plan.views import outlines_html, plan_html
from workbench.gui.shared.look import View
from workbench.gui.shared.plots import Plot, legend_html, plot_html
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor


class PlanPanel:
    """Shows the plan over time; a click into a curve goes to its moment.

    Concurrency: clicks and drags only change the shared look; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor, slider: str):
        """Add the controls.

        Args:
            visitor: whose browser.
            slider: id of the slider of the time, which a click into a curve moves.
        """
        self._slider = slider
        self._visitor = visitor
        cell = visitor.cell
        gui = visitor.gui
        self._summary = gui.add_html("")
        self._add_found = gui.add_button(
            "Add the found grasp to the library",
            icon=viser.Icon.PLUS,
            color="gray",
            hint="The next plan tries it before it searches. This plan is void then. "
            "Undo takes it back.",
            visible=False,
        )
        self._add_found.on_click(lambda _: self._keep_grips())
        self._nearest = gui.add_html("")
        self._lanes = gui.add_html("")
        self._cursor = gui.add_html("")
        self._links = PlanLinks(visitor)
        self._plans = visitor.rows(MOST_OUTLINES, self._again)
        # A plot and its legend for clearance, the arms' distance, speeds, and each arm's axes.
        count = 2 + (len(cell.arms) > 1) + len(cell.arms)
        self._drawn = [(gui.add_html(""), gui.add_html("")) for _ in range(count)]
        self._plots: tuple[Plot, ...] = ()

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        is_other = old is None or old.state.outlines is not new.state.outlines
        if is_other or (old is not None and old.state.plans != new.state.plans):
            self._draw_plan(new)
        is_moved = old is None or old.runs is not new.runs or old.look.time != new.look.time
        if is_moved and new.runs:
            now = doing(new.runs, new.look.time)
            self._cursor.content = now_html(
                new.look.time, new.plan_seconds, now, self._visitor.words
            )
            # Values are read when it stands still.
            if not new.look.is_playing:
                self._show_values(new.look.time)

    def _draw_plan(self, view: View) -> None:
        state, runs, seconds = view.state, view.runs, view.plan_seconds
        cell, taken = state.cell, "" if state.plan is None else state.plan.digest
        outlines = outlines_html(state.outlines, taken, self._plans, self._visitor.words)
        may_add = not self._visitor.obstacle(state, EditPart)
        self._add_found.visible = (
            may_add and state.plan is not None and any(arm.found for arm in state.plan.arms)
        )
        if state.plan is None:
            hint = line("A plan can be played here once it was made.", kind="hint")
            self._summary.content = hint + outlines
            self._lanes.content = self._cursor.content = self._nearest.content = ""
            self._plots = ()
            self._clear_plots(0)
            return
        self._summary.content = plan_html(state, self._visitor.words) + outlines
        self._lanes.content = lanes_html(cell, runs, seconds, self._visitor.words)
        self._nearest.content = proof_html(state, self._links) if state.whole_row else ""
        self._plots = plots_of(
            cell,
            runs,
            seconds,
            [proven_plan.proof for proven_plan in state.whole_row],
            self._visitor.words,
        )
        for (drawn, _), plot in zip(self._drawn, self._plots, strict=False):
            drawn.content = plot_html(plot, seconds, self._slider)
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

    def _keep_grips(self) -> None:
        """Add the grips that the plan's search has found to the libraries of their parts."""
        state = self._visitor.bench.state
        for command in make_found_commands(state.cell, state.plan) if state.plan else ():
            self._visitor.ask(lambda command=command: command)

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
