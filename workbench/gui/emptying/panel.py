"""The tab that empties piles in simulation: what is asked, what came of it, and the film of it."""

import math
from functools import partial
from typing import Any

import viser

from workbench.app.core.cell.emptying import TryEmptying
from workbench.app.core.command import Command
from workbench.app.core.state import State
from workbench.app.core.value_checks import MOST_PARTS, MOST_PILES, SEED_LIMIT
from workbench.app.emptying.summary import summary
from workbench.app.emptying.what_if import rank_changes
from workbench.gui.emptying.curves import end_of, taken_plot
from workbench.gui.emptying.film_controls import FilmControls
from workbench.gui.emptying.views import (
    COLUMNS,
    NOTHING_YET,
    Column,
    PileOrder,
    changes_html,
    left_html,
    order_piles,
    piles_html,
    summary_html,
)
from workbench.gui.help.groups import group
from workbench.gui.shared.look import View
from workbench.gui.shared.plots import legend_html, plot_html
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor, whole
from workbench.model.cell import Cell
from workbench.model.prediction import CHANGE_KINDS, Emptying, Seen
from workbench.model.scan import ALL_KINDS

THREE_COLUMNS_MARK = '<div class="wb-row"></div>'
"""A mark that has its folder laid out in three columns, see the style sheet."""

POSES: dict[str, Seen] = {"true poses": "truth", "simulated scans": "scan"}

NO_CHANGE, EVERY_CHANGE = "none", "all"

LONGEST_STEP = 3600.0
"""[s] A scan or an approval takes no longer."""


class EmptyingPanel:
    """What piles are emptied, what came of them, and a film of the one that is chosen.

    Concurrency: clicks come from viser's threads and only replace `_order`, `_pile` or the own
    look; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        self._order, self._pile = PileOrder(), 0
        self._drawn: tuple[Any, ...] = ()
        gui = visitor.gui
        with group(gui, "Piles to empty"):
            gui.add_html(THREE_COLUMNS_MARK)
            self._kind = gui.add_dropdown(
                "Which part", _kinds(visitor.cell), hint="Falls into the simulated bin."
            )
            self._parts = gui.add_number(
                "Parts", 15, min=1, max=MOST_PARTS, step=1, hint="Number of parts in a pile."
            )
            self._piles = gui.add_number(
                "Piles", 3, min=1, max=MOST_PILES, step=1, hint="Each has the next seed."
            )
            self._seed = gui.add_number(
                "Seed",
                0,
                min=0,
                max=SEED_LIMIT - MOST_PILES,
                step=1,
                hint="Of the first pile: the same seed gives the same pile and the same end.",
            )
            self._poses = gui.add_dropdown(
                "Planned with",
                tuple(POSES),
                hint="Simulated scans are searched as real ones are, and bring mistakes as those.",
            )
            self._changes = gui.add_dropdown(
                "Changes to try",
                (NO_CHANGE, EVERY_CHANGE, *CHANGE_KINDS),
                hint="The same piles are emptied once more with each single change of the cell.",
            )
            gui.add_html('<div class="wb-span2"></div>')
            self._start = gui.add_button(
                "Empty piles",
                icon=viser.Icon.PLAYER_PLAY,
                hint="Everything is simulated: no robot moves, and nothing of the cycle changes.",
            )
        with group(gui, "What came of it"):
            self._summary = gui.add_html(line(NOTHING_YET, kind="hint"))
            self._table = gui.add_html("")
        self._film = FilmControls(visitor)
        with group(gui, "How the piles went empty") as self._went:
            self._plot = gui.add_html("")
        with group(gui, "What changes bring", expand_by_default=False) as self._brought:
            self._ranked = gui.add_html("")
        with group(gui, "Seconds of people and scanner", expand_by_default=False):
            self._scan_seconds = gui.add_number(
                "A scan takes [s]", 1.0, min=0.0, max=LONGEST_STEP, step=0.1
            )
            self._approval_seconds = gui.add_number(
                "An approval takes [s]", 0.0, min=0.0, max=LONGEST_STEP, step=0.1
            )
        self._headings: dict[Column, str] = {
            column: visitor.unseen(partial(self._sort, column)) for column in COLUMNS
        }
        visitor.hide(self._headings.values())
        self._rows = visitor.rows(MOST_PILES, self._choose)
        self._left_rows = visitor.rows(MOST_PARTS, self._choose_part)
        visitor.on_press(self._start, self._make_command)
        visitor.emphasise(self._start, "Emptying")
        for seconds in (self._scan_seconds, self._approval_seconds):
            visitor.by_hand(seconds, lambda _: visitor.own.change())

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state, visitor = new.state, self._visitor
        if old is None or old.state is not state:
            kinds = _kinds(state.cell)
            if self._kind.options != kinds and kinds:
                names = (part.name for part in state.cell.parts)
                made = [name for name in names if name not in self._kind.options]
                self._kind.options = kinds
                if made:
                    # A part that was just made is what one wants to see emptied.
                    self._kind.value = made[0]
            visitor.admit(self._start, state, TryEmptying)
            follows = visitor.is_recorded or bool(visitor.lacks(state, TryEmptying))
            for field in (self._parts, self._piles, self._seed, self._kind, self._poses):
                field.disabled = follows
            self._changes.disabled = follows
        found = state.emptying
        if found is not None and (old is None or old.state.emptying is not found):
            self._pile = 0
        self._draw(state, found, new)
        self._film.show(old, new, self._pile)

    def _draw(self, state: State, found: Emptying | None, new: View) -> None:
        chosen = None if new.own.film is None else new.own.film.chosen
        seconds = self._seconds()
        drawn = (found, state.cell.digest, self._order, self._pile, chosen, *seconds)
        if self._drawn == drawn:
            return
        self._drawn = drawn
        self._went.visible = found is not None
        self._brought.visible = found is not None and len(found.plain) < len(found.piles)
        if found is None:
            self._summary.content = line(NOTHING_YET, kind="hint")
            self._table.content = ""
            return
        plain, words = found.plain, self._visitor.words
        pile = min(self._pile, len(plain) - 1)
        takes = {"scan_seconds": seconds[0], "approval_seconds": seconds[1]}
        is_stale = found.cell_digest != state.cell.digest
        self._summary.content = summary_html(found, summary(plain, **takes), is_stale, words)
        shown = order_piles(plain, self._order)
        self._table.content = piles_html(
            plain,
            shown,
            self._order,
            pile,
            headings=self._headings,
            rows=self._rows,
            words=words,
        )
        plot = taken_plot(plain, words)
        self._plot.content = plot_html(plot, end_of(plot)) + legend_html(plot)
        self._film.show_left(left_html(plain[pile], chosen, self._left_rows, words))
        if self._brought.visible:
            self._ranked.content = changes_html(rank_changes(found.piles, **takes), words)

    def _seconds(self) -> tuple[float, float]:
        """What a scan and an approval take; a browser may send any number."""
        typed = (float(self._scan_seconds.value), float(self._approval_seconds.value))
        first, second = (
            min(max(seconds, 0.0), LONGEST_STEP) if math.isfinite(seconds) else 0.0
            for seconds in typed
        )
        return first, second

    def _sort(self, column: Column) -> None:
        order = self._order
        is_same = order.column == column
        self._order = PileOrder(column, not order.is_descending if is_same else column != "seed")
        self._visitor.own.change()

    def _choose(self, place: int) -> None:
        found = self._visitor.bench.state.emptying
        if found is None or place >= len(found.plain):
            return
        self._pile = order_piles(found.plain, self._order)[place]
        self._film.change_to(self._pile)

    def _choose_part(self, place: int) -> None:
        found = self._visitor.bench.state.emptying
        if found is None or self._pile >= len(found.plain):
            return
        left = found.plain[self._pile].left
        if place < len(left):
            self._film.show_part(self._pile, left[place].part)

    def _make_command(self) -> Command:
        kind, changes = str(self._kind.value), str(self._changes.value)
        wanted = {NO_CHANGE: (), EVERY_CHANGE: CHANGE_KINDS}.get(changes, (changes,))
        return TryEmptying(
            () if kind == ALL_KINDS else (kind,),
            whole(self._parts.value),
            whole(self._piles.value),
            whole(self._seed.value),
            # A browser may send what is not to be chosen: the rules refuse it by its name.
            POSES.get(str(self._poses.value), str(self._poses.value)),  # type: ignore[arg-type]
            wanted,
        )


def _kinds(cell: Cell) -> tuple[str, ...]:
    names = tuple(part.name for part in cell.parts)
    return (ALL_KINDS, *names) if len(names) > 1 else names
