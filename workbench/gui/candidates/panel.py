"""The tab that shows every grasp that was judged, and why it can or cannot be taken."""

from collections.abc import Callable
from dataclasses import replace
from functools import partial

from workbench.app.core.cycle.scanning import TakeScan
from workbench.gui.drawing.flight import CameraFlight
from workbench.gui.scene.fix_inputs import FixInputs
from workbench.gui.shared.colours import VERDICT_KINDS
from workbench.gui.shared.look import View
from workbench.gui.shared.tables import (
    COLUMNS,
    MOST_PARTS,
    PAGE,
    CandidateOrder,
    Column,
    by_part_html,
    candidates_html,
    chosen_html,
    funnel_html,
    holds,
    on_page,
    order_candidates,
    pages,
    stages_html,
)
from workbench.gui.shared.views import line, sentence
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.page import PageText
from workbench.model.candidate import Candidate, Reason
from workbench.model.messages.message import as_message
from workbench.model.scan import Detection

CHOOSE = "Choose a row: why it fails, and the nearest fix, are stated here."
"""Below the table while no row is chosen."""


class CandidatesPanel:
    """Counts by verdict as filters, the table, and the candidate shown in the scene.

    Concurrency: clicks come from viser's threads and only replace `_order`, or change the
    shared look; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor, redraw: Callable[[], None]):
        """Add the controls.

        Args:
            visitor: whose browser.
            redraw: has `show` called soon.
        """
        self._visitor = visitor
        self._redraw = redraw
        self._flight = CameraFlight(visitor)
        self._order = self._drawn = CandidateOrder()
        self._shown: tuple[int, ...] = ()
        self._pointed: Detection | None = None
        gui = visitor.gui
        self._by_part = gui.add_html("")
        self._funnel = gui.add_html("")
        self._words = gui.add_text(
            "Filter",
            "",
            hint="Words that a row must have: part-2, left, side-1, approach, bin_wall_back.",
        )
        self._table = gui.add_html("")
        self._mark = gui.add_html(chosen_html(None))
        gui.add_html('<div class="wb-buttons wb-three"></div>')
        self._foot = gui.add_html("")
        self._back = gui.add_button("Previous", color="gray")
        self._forth = gui.add_button("Next", color="gray")
        self._clear = gui.add_button("Hide in scene", color="gray")
        # Below all that is pressed: nothing moves when a row is chosen.
        self._pose_line = gui.add_html("")
        self._fix_line = gui.add_html("", visible=False)
        self._fix = FixInputs(visitor)
        self._pose = gui.add_slider(
            "Pose",
            min=0,
            max=1,
            step=1,
            initial_value=0,
            visible=False,
            hint="Through the poses of the chosen candidate; the elbow turns, the tool stays.",
        )
        self._sure_line = gui.add_html("", visible=False)
        self._filters = {
            kind: visitor.unseen(partial(self._filter, kind)) for kind in (None, *VERDICT_KINDS)
        }
        self._parts = [visitor.unseen(partial(self._show_part, part)) for part in range(MOST_PARTS)]
        self._headings: dict[Column, str] = {
            column: visitor.unseen(partial(self._sort, column)) for column in COLUMNS
        }
        self._rows = [visitor.unseen(partial(self._choose, place)) for place in range(PAGE)]
        visitor.hide([*self._filters.values(), *self._parts, *self._headings.values(), *self._rows])
        self._words.on_update(lambda _: self._on_typed())
        self._back.on_click(lambda _: self._turn(-1))
        self._forth.on_click(lambda _: self._turn(1))
        self._clear.on_click(lambda _: visitor.look.change(candidate=None, pose=0))
        visitor.by_hand(
            self._pose, lambda pose: visitor.look.change(pose=int(pose), by=visitor.number)
        )

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        candidates = new.state.candidates or ()
        are_others = old is None or old.state.candidates is not new.state.candidates
        self._follow_click(new)
        if are_others or self._order is not self._drawn:
            self._draw(candidates, are_others)
        chosen = new.look.candidate
        place = self._shown.index(chosen) if chosen in self._shown else None
        self._mark.content = chosen_html(place)
        lacks = self._visitor.lacks(new.state, TakeScan)
        missing = "no candidate is chosen" if chosen is None else ""
        self._visitor.allow(self._clear, lacks or missing)
        self._pose.disabled = bool(lacks)
        if are_others or old is None or old.pose is not new.pose:
            self._draw_pose(old, new)
        if old is None or old.fix is not new.fix:
            self._fix_line.content = line(
                sentence(self._visitor.words.render(new.fix.words)), kind="warn"
            )
            self._fix_line.visible = bool(new.fix.words)
        if old is None or old.sure != new.sure:
            self._sure_line.content = line(
                sentence(self._visitor.words.render(new.sure)), kind="hint"
            )
            self._sure_line.visible = bool(new.sure)
        self._fix.show(old, new, new.fix)

    def _follow_click(self, view: View) -> None:
        """Show the candidates of the part that was clicked on in the scene since, or of all."""
        pointed, found = self._visitor.own.now.pointed, view.state.detections or ()
        if pointed is self._pointed:
            return
        self._pointed = pointed
        part = next((number for number, each in enumerate(found) if each is pointed), None)
        self._order = replace(self._order, part=part, only=None, page=0)

    def _draw_pose(self, old: View | None, new: View) -> None:
        count = len(new.poses)
        if old is None or old.poses is not new.poses:
            self._pose.visible = count > 1
            self._pose.max = max(count - 1, 1)
        if new.look.by != self._visitor.number:
            self._pose.value = min(new.look.pose, max(count - 1, 0))
        pose = new.pose
        words, text = self._visitor.words, ""
        if pose is not None:
            label, note = as_message(pose.label), as_message(pose.note)
            number = new.look.pose + 1
            text = words.render(
                PageText.LINE_OF(label=label, number=number, total=count, note=note)
            )
        is_bad = pose is not None and bool(pose.meets)
        has_any = bool(new.state.candidates)
        hint = line(CHOOSE, kind="hint") if has_any and new.look.candidate is None else ""
        kind = "bad" if is_bad else "result"
        self._pose_line.content = line(sentence(text), kind=kind) if text else hint

    def _draw(self, candidates: tuple[Candidate, ...], are_others: bool) -> None:
        if are_others:
            self._order = replace(self._order, only=None, part=None, page=0)
        order, words = self._order, self._visitor.words
        self._drawn = order
        indices = order_candidates(candidates, order, words)
        count = pages(len(indices))
        page = min(order.page, count - 1)
        self._shown = on_page(indices, page)
        self._back.visible = self._forth.visible = count > 1
        self._back.disabled = page == 0
        self._forth.disabled = page >= count - 1
        shown, total = len(indices), len(candidates)
        foot = PageText.CANDIDATES(shown=shown, total=total)
        if count > 1:
            foot = PageText.CANDIDATES_PAGE(shown=shown, total=total, page=page + 1, pages=count)
        self._foot.content = line(words.render(foot) if candidates else "", kind="hint")
        if not candidates:
            self._funnel.content = self._by_part.content = ""
            self._table.content = line(
                "Every grasp of every part with every arm appears here once a plan was made.",
                kind="hint",
            )
            return
        self._by_part.content = by_part_html(candidates, order.part, self._parts, words)
        held = [
            candidate
            for candidate in candidates
            if order.part in (None, candidate.detection) and holds(candidate, order.words, words)
        ]
        funnel = funnel_html(held, order.only, self._filters, words)
        self._funnel.content = funnel + stages_html(held, words)
        self._table.content = candidates_html(
            candidates,
            self._shown,
            order,
            headings=self._headings,
            rows=self._rows,
            words=words,
        )

    def _filter(self, kind: Reason | None) -> None:
        self._reorder(replace(self._order, only=kind, page=0))

    def _show_part(self, part: int) -> None:
        shown = None if self._order.part == part else part
        self._reorder(replace(self._order, part=shown, only=None, page=0))

    def _on_typed(self) -> None:
        self._reorder(replace(self._order, words=self._words.value, page=0))

    def _sort(self, column: Column) -> None:
        order = self._order
        turned = not order.is_descending if order.column == column else column == "verdict"
        self._reorder(replace(order, column=column, is_descending=turned, page=0))

    def _turn(self, step: int) -> None:
        self._reorder(replace(self._order, page=max(0, self._order.page + step)))

    def _reorder(self, order: CandidateOrder) -> None:
        self._order = order
        self._redraw()

    def _choose(self, place: int) -> None:
        visitor, shown = self._visitor, self._shown
        if place >= len(shown):
            return
        if problem := visitor.lacks(visitor.bench.state, TakeScan):
            visitor.notify("Refused", problem)
            return
        look = visitor.look
        visitor.own.change(thing="")
        chosen = None if look.now.candidate == shown[place] else shown[place]
        look.change(candidate=chosen, pose=0, by=None)
        candidates = visitor.bench.state.candidates or ()
        if chosen is not None and chosen < len(candidates):
            self._flight.fly_to(candidates[chosen].T_world_tcp.translation)
