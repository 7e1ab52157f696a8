"""The threshold: a slider that says, while it is dragged, what comes of it for the parts found."""

import math
import time
from collections.abc import Callable
from itertools import combinations
from typing import Any

import viser

from workbench.app.core.cycle.outcomes import avoided_parts
from workbench.app.core.cycle.planning import WantThreshold
from workbench.app.core.state import State
from workbench.gui.scene.slider_drag import SliderDrag
from workbench.gui.shared.views import forecast_line, line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.cell import Cell
from workbench.words.words import IN_ENGLISH, Words

TWO_COLUMNS_MARK = '<div class="wb-wide"></div>'
"""A mark that gives what comes next two columns."""


class ThresholdInput:
    """The slider, what it decides for these parts, and what a study says of it.

    Concurrency: any thread.
    """

    def __init__(self, visitor: Visitor, strategy: Callable[[], str]):
        """Add the slider.

        Args:
            visitor: whose browser.
            strategy: returns the one that is chosen; the threshold counts for `auto`.
        """
        self._visitor, self._strategy = visitor, strategy
        wanted = round(visitor.cell.policy.threshold * 1000)
        visitor.gui.add_html(TWO_COLUMNS_MARK)
        # A browser may send anything.
        self._slider: viser.GuiSliderHandle[Any] = visitor.gui.add_slider(
            "Threshold [mm]",
            min=0,
            max=max(farthest(visitor.cell), wanted),
            step=1,
            initial_value=wanted,
            hint="Parts that lie nearer to each other than this are taken one after the other.",
        )
        self._line = visitor.gui.add_html("")
        self._forecast: viser.GuiHtmlHandle | None = None
        self._drag = SliderDrag(self._ask)
        visitor.on_end(self._drag.drop)

        @self._slider.on_update
        def _(event: Any) -> None:
            # The renderer sets the slider too; only a person's hand comes with a browser.
            if event.client is not None:
                self.draw(visitor.bench.state, time.time())
                self._drag.note_move()

    def add_forecast(self) -> None:
        """Add the line that says what a study knows, where it is to stand."""
        self._forecast = self._visitor.gui.add_html("")

    @property
    def metres(self) -> float:
        """The threshold of the slider [m].

        Raises:
            TypeError: the browser has sent no number.
        """
        return self._slider.value / 1000

    def allow(self, *, is_allowed: bool) -> None:
        """Let it be dragged, or not."""
        self._slider.disabled = not is_allowed

    def finish(self) -> None:
        """Have what was dragged to asked for now: an approval, or a sending, comes after it."""
        self._drag.finish()

    def follow(self, old: State | None, new: State) -> None:
        """Show the threshold that is wanted now, whichever browser it was dragged in.

        Not under a hand: what was asked for when it rested would undo where it has gone since.
        """
        wanted = new.wanted_threshold
        if wanted is not None and (old is None or old.wanted_threshold != wanted):
            self.take(wanted)

    def take(self, wanted: float) -> None:
        """Show a threshold [m] that somebody wants, unless the slider is being dragged."""
        if self._drag.is_under_way:
            return
        shown = _millimetres(wanted)
        if self._slider.value != shown:
            self._slider.max = max(self._slider.max, shown)
            self._slider.value = shown

    def draw(self, state: State, at: float) -> None:
        """Say what comes of it at [s since the epoch], from what is known already."""
        typed = self._slider.value
        threshold = typed / 1000 if isinstance(typed, int | float) else 0.0
        self._line.content = decides_line(
            state, self._strategy(), threshold, at, self._visitor.words
        )
        if self._forecast is not None:
            # Of use between the parts and the plan.
            is_next = state.detections is not None and state.plan is None
            known = self._visitor.predictions if is_next else None
            self._forecast.content = forecast_line(
                state.cell, known, threshold, self._visitor.words
            )

    def _ask(self) -> None:
        """A plan that was made with another threshold is stale now."""
        state, visitor, typed = self._visitor.bench.state, self._visitor, self._slider.value
        if state.plan is None or visitor.obstacle(state, WantThreshold):
            return
        if state.wanted_threshold is None or typed != _millimetres(state.wanted_threshold):
            visitor.ask(lambda: WantThreshold(typed / 1000))


def _millimetres(metres: float) -> int:
    return round(metres * 1000)


def farthest(cell: Cell) -> int:
    """[mm] No two parts in the bin of a cell lie farther from each other; to the next 50."""
    return math.ceil(math.hypot(*cell.bin.size[:2]) / 0.05) * 50


def decides_line(
    state: State, strategy: str, threshold: float, at: float, words: Words = IN_ENGLISH
) -> str:
    """Whether the parts found could be taken at once, as far as the threshold decides that.

    Args:
        state: with the parts.
        strategy: that is asked for.
        threshold: [m] two parts count as apart from there on.
        at: [s since the epoch] when it is asked, for the parts that are avoided.
        words: of who reads it.
    """
    avoided = {number for number, _ in avoided_parts(state, at)}
    found = [detection for k, detection in enumerate(state.detections or ()) if k not in avoided]
    distances = sorted(
        math.dist(a.T_world_part.translation, b.T_world_part.translation)
        for a, b in combinations(found, 2)
    )
    if strategy != "auto":
        return line("The threshold counts for auto alone.", kind="hint", span=2)
    if not state.cell.moves_both_arms:
        return line("This cell does not move two arms at once.", kind="hint", span=2)
    if not distances:
        return line("Nearer parts are taken one after the other.", kind="hint", span=2)
    far = sum(distance >= threshold for distance in distances)
    text = CyclePageText.ALTERNATED(distance=distances[-1])
    if far:
        text = CyclePageText.COORDINATED(count=far, total=len(distances))
    return line(
        words.render(text),
        span=2,
        tip="Where two arms may work at once, auto takes the quicker plan.",
    )
