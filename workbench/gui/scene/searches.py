"""Searches for parts in one scan, side by side: other seeds and settings, table and scene."""

from collections.abc import Sequence
from html import escape

import numpy as np
import viser

from workbench.app.core.command import Command
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.state import State
from workbench.app.core.value_checks import DETAIL, SEED_LIMIT
from workbench.gui.scene.contacts import add_body
from workbench.gui.shared.colours import COMPARED
from workbench.gui.shared.look import View
from workbench.gui.shared.tables import clickable, mark_attribute
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor, whole
from workbench.gui.texts.scene import SearchText
from workbench.model.errors import InputError
from workbench.model.messages.commands import EditText
from workbench.model.messages.message import all_of, plain
from workbench.model.scan import SearchOverrides, SearchRecord
from workbench.words.words import IN_ENGLISH, Words

MOST_ROWS = 6

CHOOSE = "choose a search in the table first"


class SearchInputs:
    """What the next search does otherwise, the table of all, and which of them is taken.

    Concurrency: as `PartsPanel`.
    """

    def __init__(self, visitor: Visitor):
        """Add the controls to the folder that is open."""
        self._visitor = visitor
        gui = visitor.gui
        self._detail = gui.add_slider(
            "Detail [%]",
            min=DETAIL[0] * 100,
            max=DETAIL[1] * 100,
            step=10,
            initial_value=100,
            hint="Resolution of the search: a finer one finds small features and takes longer.",
        )
        self._least = gui.add_slider(
            "Least score",
            min=0.0,
            max=1.0,
            step=0.05,
            initial_value=0.0,
            hint="Parts that explain less of what is seen are left out.",
        )
        self._seed = gui.add_number(
            "Seed",
            1,
            min=0,
            max=SEED_LIMIT - 1,
            step=1,
            hint="Another one looks from other points: parts found by every seed are sure.",
        )
        gui.add_html('<div class="wb-buttons wb-two"></div>')
        self._search = gui.add_button(
            "Search again",
            icon=viser.Icon.SEARCH,
            hint="What it finds is drawn beside the parts found; where there are none it is taken.",
        )
        self._take = gui.add_button("Take this one", icon=viser.Icon.CHECK, color="gray")
        self._table = gui.add_html("")
        self._asked: int | None = None
        self._rows = visitor.rows(MOST_ROWS, self._choose)
        self._search.on_click(lambda _: self._search_again())
        visitor.on_press(self._take, self._take_search)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        chosen = new.look.search
        if old is not None and old.state is new.state and old.look.search == chosen:
            return
        state = new.state
        if find_search(state, self._asked) is not None:
            # Who has asked for it wants to compare it.
            self._visitor.look.change(search=self._asked, searcher=self._visitor.number)
            self._asked = None
        missing = "" if state.scan is not None else "take a scan first"
        self._visitor.admit(self._search, state, FindParts, otherwise=missing)
        missing = "" if find_search(state, chosen) is not None else CHOOSE
        self._visitor.admit(self._take, state, UseDetections, otherwise=missing)
        self._table.content = searches_html(state.searches, chosen, self._rows, self._visitor.words)

    def _choose(self, place: int) -> None:
        """Look at a search of the table, or away from it."""
        visitor, look = self._visitor, self._visitor.look
        searches = visitor.bench.state.searches
        if place >= len(searches):
            return
        if problem := visitor.lacks(visitor.bench.state, TakeScan):
            visitor.notify("Refused", problem)
            return
        number = searches[place].number
        chosen = None if look.now.search == number else number
        look.change(search=chosen, searcher=visitor.number)

    def _search_again(self) -> None:
        if self._visitor.ask(self._make_command):
            job = self._visitor.bench.state.job
            self._asked = None if job is None else job.number

    def _make_command(self) -> Command:
        overrides = SearchOverrides(float(self._detail.value) / 100, float(self._least.value))
        is_compared = bool(self._visitor.bench.state.detections)
        return FindParts(whole(self._seed.value), overrides, is_compared)

    def _take_search(self) -> Command:
        state = self._visitor.bench.state
        search = find_search(state, self._visitor.look.now.search)
        if search is None:
            raise InputError(CHOOSE)
        self._visitor.look.change(search=None)
        place = state.searches.index(search) + 1
        return UseDetections(search.detections, EditText.SEARCH_TAKEN(search=place))


def find_search(state: State, number: int | None) -> SearchRecord | None:
    """The search with that number, if it is one of this scan."""
    return next((search for search in state.searches if search.number == number), None)


def searches_html(
    searches: Sequence[SearchRecord],
    chosen: int | None,
    rows: Sequence[str],
    words: Words = IN_ENGLISH,
) -> str:
    """A row for each search in this scan."""
    if not searches:
        return line("Each search in this scan appears here, to be compared.", kind="hint")
    heads = ("Search", "Detail", "Seed", "Parts", "Score", "Lead", "Time")
    head = "".join(f'<th class="wb-number">{title}</th>' for title in heads)
    body = "".join(
        _row(place, search, search.number == chosen, rows[place], words)
        for place, search in enumerate(searches[: len(rows)])
    )
    return (
        f'<div class="wb-rows wb-poses"><table class="wb-table wb-searches"><thead><tr>{head}</tr>'
        f"</thead><tbody>{body}</tbody></table></div>"
        + line("A row that is clicked draws its parts beside the others.", kind="hint")
    )


def _row(place: int, search: SearchRecord, is_chosen: bool, button: str, words: Words) -> str:
    found = search.detections
    gaps = [detection.gap for detection in found if detection.gap is not None]
    values = (
        str(place + 1),
        f"{search.overrides.detail:.0%}",
        str(search.seed),
        str(len(found)),
        f"{np.mean([detection.score for detection in found]):.2f}" if found else "",
        f"{np.mean(gaps):.2f}" if gaps else "",
        f"{search.seconds:.2f} s",
    )
    cells = "".join(f'<td class="wb-number">{escape(value)}</td>' for value in values)
    scores, least = [f"{detection.score:.2f}" for detection in found], search.overrides.least_score
    texts = [SearchText.SCORES(scores=scores) if found else plain("no part")]
    if least > 0:
        texts.append(SearchText.NONE_ABOVE(score=least))
    tip = words.render(all_of(texts))
    return f'<tr{mark_attribute(is_chosen)} title="{escape(tip)}" {clickable(button)}>{cells}</tr>'


def draw_search(scene: viser.SceneApi, state: State, number: int | None) -> None:
    """The parts of a search beside those found, in a colour of their own."""
    scene.remove_by_name("/searched")
    search = find_search(state, number)
    for k, detection in enumerate(search.detections if search is not None else ()):
        mesh = state.cell.part(detection.part).mesh
        add_body(scene, f"/searched/{k}", mesh, detection.T_world_part, COMPARED, 0.55)
