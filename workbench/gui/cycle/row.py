"""The plans of a row: how many are wanted, what each takes, and the way to carry out fewer."""

from html import escape

import viser

from workbench.app.core.command import Command
from workbench.app.core.cycle.rows import ShortenRow
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.state import Phase, State
from workbench.gui.shared.look import View
from workbench.gui.shared.views import clearance_words, line, sentence, short
from workbench.gui.shared.visitor import Visitor, whole
from workbench.gui.texts.cycle import CyclePageText
from workbench.gui.texts.labels import LabelText
from workbench.model.cell import MOST_PICKS, Cell
from workbench.model.derived.row_parts import parts_taken
from workbench.model.messages.message import FoundPart, Message, all_of
from workbench.model.plan import Proven
from workbench.words.words import IN_ENGLISH, Words

SAYS = "Several picks after one scan, as long as the scan holds; one approval for all of them."


class RowInputs:
    """How many plans are wanted after one scan, and the row that the last planning has brought.

    Concurrency: clicks give commands; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor):
        """Nothing is added yet."""
        self._visitor = visitor

    def add_wanted(self) -> None:
        """Add the field for how many are wanted, in cells that say which parts may move."""
        gui, policy = self._visitor.gui, self._visitor.cell.policy
        self._wanted = gui.add_number(
            "Picks",
            policy.picks,
            min=1,
            max=MOST_PICKS,
            step=1,
            visible=can_have_rows(self._visitor.cell),
            hint=SAYS,
        )
        self._line = gui.add_html("", visible=False)

    def add_row(self) -> None:
        """Add what the row is, unseen while there is none."""
        gui, visitor = self._visitor.gui, self._visitor
        self._table = gui.add_html("", visible=False)
        self._mark = gui.add_html(line("Length of the row:", kind="hint", span=1), visible=False)
        self._fewer = gui.add_button(
            "Leave out last",
            icon=viser.Icon.MINUS,
            color="gray",
            visible=False,
            hint="The row ends one plan earlier; what was approved has to be approved again.",
        )
        self._more = gui.add_button(
            "Bring back",
            icon=viser.Icon.PLUS,
            color="gray",
            visible=False,
            hint="The plan that was left out last is carried out again; it has to be played first.",
        )
        visitor.on_press(self._fewer, lambda: self._other(-1))
        visitor.on_press(self._more, lambda: self._other(1))

    @property
    def picks(self) -> int | None:
        """How many plans are wanted; None where the cell has no rows."""
        return whole(self._wanted.value) if self._wanted.visible else None

    def _other(self, by: int) -> Command:
        state = self._visitor.bench.state
        digest = "" if state.plan is None else state.plan.digest
        return ShortenRow(digest, 1 + len(state.row) + by)

    def show(self, new: View) -> None:
        """Bring it up to date."""
        state, visitor = new.state, self._visitor
        words = row_words(state, visitor.words)
        self._wanted.visible = can_have_rows(state.cell)
        self._wanted.disabled = new.is_recorded or bool(visitor.lacks(state, TakeScan))
        self._line.visible = self._wanted.visible or bool(words)
        shown = f"{sentence(words)}." if words else SAYS
        self._line.content = line(shown, kind="result" if words else "hint", span=2)
        self._table.visible = bool(state.row or state.left_out or state.sent_before)
        self._table.content = row_html(state, visitor.words) if self._table.visible else ""
        is_open = bool(state.row or state.left_out) and state.phase in (
            Phase.PLANNED,
            Phase.APPROVED,
        )
        for control in (self._mark, self._fewer, self._more):
            control.visible = is_open and not new.is_recorded
        if is_open:
            for button, by in ((self._fewer, -1), (self._more, 1)):
                problem = visitor.refusal(state, self._other(by), new.at)
                visitor.allow(button, visitor.words.render(problem))


def can_have_rows(cell: Cell) -> bool:
    """Whether a cell says which parts may move when one is taken."""
    return cell.policy.pair_gap > 0


def row_html(state: State, words: Words = IN_ENGLISH) -> str:
    """What each plan of the row takes, how long that is, and how near it comes to anything."""
    rows = "".join(
        _row(state, number, proven_plan, words)
        for number, proven_plan in enumerate((*state.whole_row, *state.left_out))
    )
    heads = "".join(f"<th>{title}</th>" for title in ("", "Takes", "Time", "Proof"))
    return (
        f'<div class="wb-span3"><table class="wb-facts wb-plans"><thead><tr>{heads}</tr></thead>'
        f"<tbody>{rows}</tbody></table></div>"
    )


def row_words(state: State, words: Words = IN_ENGLISH) -> str:
    """How long the row is, and why it ends there; empty where one plan alone was asked for."""
    count = len(state.plans)
    facts = [CyclePageText.PICKS(count=count)]
    if any(plan.stations for plan in state.plans):
        facts.append(CyclePageText.OVER_STATION())
    if state.left_out:
        facts.append(CyclePageText.LEFT_OUT(count=len(state.left_out)))
    if count + len(state.left_out) < 2 and (not count or not state.row_ends):
        return ""
    return words.render(all_of((LabelText.LIST(items=facts), state.row_ends)))


def _row(state: State, number: int, proven_plan: Proven, words: Words) -> str:
    now, count = len(state.sent_before), len(state.plans)
    is_out = number >= count
    mark = str(number + 1)
    if number < now or (number == now and state.phase is Phase.DONE):
        mark = "✓"
    elif number == now and state.phase is Phase.SENDING:
        mark = "▶"
    takes = words.render(_takes(state, proven_plan))
    proof = (
        clearance_words(proven_plan.proof, words) if proven_plan.proof.holds else "does not hold"
    )
    plan, proof_digest = short(proven_plan.plan.digest), short(proven_plan.proof.digest)
    title = words.render(CyclePageText.DIGESTS(plan=plan, proof=proof_digest))
    style = ' style="opacity:.5;text-decoration:line-through"' if is_out else ""
    return (
        f'<tr title="{escape(title)}"{style}><td>{mark}</td><td>{escape(takes)}</td>'
        f'<td class="wb-number">{proven_plan.plan.cycle_seconds:.1f} s</td>'
        f"<td>{escape(proof)}</td></tr>"
    )


def _takes(state: State, proven_plan: Proven) -> Message:
    """The parts that a plan of the row takes, by the numbers of the scan, and with which arm."""
    numbers = parts_taken(state.plans[0], proven_plan.plan)
    pairs = zip(numbers, proven_plan.plan.picks, strict=True)
    return LabelText.LIST(
        items=[
            CyclePageText.TAKES_TO_STATION(part=FoundPart(part), arm=arm.arm, station=arm.station)
            if arm.station
            else CyclePageText.TAKES(part=FoundPart(part), arm=arm.arm)
            for part, arm in pairs
        ]
    )
