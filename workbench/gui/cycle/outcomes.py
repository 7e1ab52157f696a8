"""What became of each part that was sent for: two rows a part, with a button for each result."""

import viser

from workbench.app.core.command import Command
from workbench.app.core.cycle.outcomes import ReportPick, parts_sent_for
from workbench.app.core.picks import Outcome
from workbench.app.core.state import Phase, State, sent_for
from workbench.app.core.value_checks import LONGEST_TEXT
from workbench.gui.help.groups import help_html
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.errors import InputError
from workbench.model.messages.message import FoundPart, as_message
from workbench.model.plan import ArmPlan, Plan
from workbench.model.release import PickResult
from workbench.words.words import Words

AFTER_ROWS = 1e12
"""Where the field for a reason stands in its folder: below all rows; viser counts these upwards."""


LABELS = {
    PickResult.PICKED: CyclePageText.PICKED,
    PickResult.FAILED: CyclePageText.FAILED,
    PickResult.DROPPED: CyclePageText.DROPPED,
    PickResult.DOUBLE: CyclePageText.DOUBLE,
}

PART_TEXTS = {
    PickResult.PICKED: CyclePageText.PART_PICKED,
    PickResult.FAILED: CyclePageText.PART_FAILED,
    PickResult.DROPPED: CyclePageText.PART_DROPPED,
    PickResult.DOUBLE: CyclePageText.PART_DOUBLE,
}

HINTS = {
    PickResult.PICKED: "The part came to its place.",
    PickResult.FAILED: "The hand held nothing.",
    PickResult.DROPPED: "The part was lost on the way: look where it lies.",
    PickResult.DOUBLE: "A second part came with it: take that out of the place.",
}


NOT_YET = {
    PickResult.PICKED: "The robot still moves: the part is not at its place yet.",
    PickResult.FAILED: "The hand has not closed on this part yet.",
    PickResult.DROPPED: "The hand has not closed on this part yet.",
    PickResult.DOUBLE: "The robot still moves: the part is not at its place yet.",
}
"""Why a result cannot be reported while a plan is sent."""

AFTER_GRIP = frozenset({PickResult.FAILED, PickResult.DROPPED})
"""What a person can see, and report, as soon as the hand has closed on the part."""


class OutcomeInputs:
    """Shown once something was sent; what is said can be corrected until the next scan.

    Concurrency: clicks give commands; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor, row: str):
        """Add the controls, unseen; `row` marks a folder of three columns."""
        self._visitor = visitor
        gui = visitor.gui
        self._folder = gui.add_folder("Result of each pick", visible=False)
        self._rows: list[_PartRow] = []
        with self._folder:
            gui.add_html(help_html("Result of each pick"))
            gui.add_html(row)
            self._why = gui.add_text(
                "Why it failed",
                "",
                hint="Kept with a failure: the part is left alone in the next scans.",
                order=AFTER_ROWS,
            )

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state = new.state
        if old is not None and old.state is state:
            return
        is_scanned = old is not None and state.scan is not None and old.state.scan is not state.scan
        if is_scanned and self._why.value:
            self._why.value = ""
        sent = None if self._visitor.obstacle(state, ReportPick) else sent_for(state)
        self._folder.visible = sent is not None
        parts = () if sent is None else parts_sent_for(state)
        with self._folder:
            for _, arm in parts[len(self._rows) :]:
                self._rows.append(_PartRow(self._visitor, self._why, arm))
        said = {} if sent is None else {outcome.detection: outcome for outcome in sent.outcomes}
        for row in self._rows[len(parts) :]:
            row.hide()
        first = "" if sent is None else sent.plans[0].digest
        early = too_early(state)
        for row, (number, arm) in zip(self._rows, parts, strict=False):
            row.show(first, number, arm, said.get(number), early.get(number, frozenset()))


class _PartRow:
    """A part by its number in the scan, and the two buttons for what became of it."""

    def __init__(self, visitor: Visitor, why: viser.GuiTextHandle, arm: str):
        """Add the controls to the folder that is open; `why` has the reason typed."""
        self._visitor, self._why = visitor, why
        self._shown: tuple[str, int] = ("", 0)
        gui = visitor.gui
        self._text = gui.add_html("")
        self._buttons: dict[PickResult, viser.GuiButtonHandle] = {}
        self._add_button(arm, PickResult.PICKED)
        self._add_button(arm, PickResult.FAILED)
        self._below = gui.add_html('<div class="wb-span1"></div>')
        self._add_button(arm, PickResult.DROPPED)
        self._add_button(arm, PickResult.DOUBLE)

    def _add_button(self, arm: str, result: PickResult) -> None:
        button = self._visitor.gui.add_button(
            _label(arm, result, self._visitor.words), color="gray", hint=HINTS[result]
        )
        self._buttons[result] = button
        button.on_click(lambda _: self._press(result))

    def _press(self, result: PickResult) -> None:
        is_taken = self._visitor.ask(lambda: self._report(result))
        if is_taken and result is not PickResult.PICKED:
            # The next failure has a reason of its own.
            self._why.value = ""

    def _report(self, result: PickResult) -> Command:
        first, number = self._shown
        sent = sent_for(self._visitor.bench.state)
        if sent is None or sent.plans[0].digest != first:
            raise InputError("another plan was sent meanwhile; look again")
        is_plain = result in (PickResult.PICKED, PickResult.FAILED)
        why = "" if result is PickResult.PICKED else self._why.value.strip()[:LONGEST_TEXT]
        return ReportPick(number, result.is_picked, why, None if is_plain else result)

    @property
    def _controls(self) -> tuple[viser.GuiHtmlHandle | viser.GuiButtonHandle, ...]:
        return (self._text, self._below, *self._buttons.values())

    def hide(self) -> None:
        """Take it out of sight."""
        for control in self._controls:
            control.visible = False

    def show(
        self,
        first: str,
        number: int,
        arm: str,
        said: Outcome | None,
        early: frozenset[PickResult] = frozenset(),
    ) -> None:
        """Show a part of what was sent.

        Args:
            first: digest of the first plan, in whose list the part is.
            number: its index there.
            arm: that was to take it.
            said: what became of it, None while nobody has said so.
            early: results that nobody can know yet.
        """
        self._shown = first, number
        words = self._visitor.words
        for result, button in self._buttons.items():
            button.label = _label(arm, result, words)
            is_said = said is not None and said.became is result
            button.disabled = is_said or result in early
            self._visitor.explain(button, NOT_YET[result] if result in early else "")
        part, kind, tip = FoundPart(number), "result", ""
        text = str(part)
        if said is not None:
            kind = "result" if said.became is PickResult.PICKED else "bad"
            text = words.render(PART_TEXTS[said.became](part=part))
            by = CyclePageText.REPORTED_BY(person=said.by)
            if said.why:
                by = CyclePageText.REPORTED_BY_WHY(person=said.by, why=as_message(said.why))
            tip = words.render(by)
        self._text.content = line(text, kind=kind, span=1, tip=tip)
        for control in self._controls:
            control.visible = True


def too_early(state: State) -> dict[int, frozenset[PickResult]]:
    """The results that nobody can know yet, by the parts' numbers, while a plan is sent.

    A link that reports no steps says nothing before the end.
    """
    if state.phase is not Phase.SENDING or state.plan is None:
        return {}
    picks = state.plan.picks
    step = max((receipt.step for receipt in state.receipts), default=0)
    # The parts of the plan on its way are the last ones that were sent for.
    numbers = [number for number, _ in parts_sent_for(state)[-len(picks) :]] if picks else []
    early: dict[int, frozenset[PickResult]] = {}
    for number, arm in zip(numbers, picks, strict=True):
        is_gripped = step >= _first_step_with_part(state.plan, arm)
        early[number] = frozenset(PickResult) - (AFTER_GRIP if is_gripped else frozenset())
    return early


def _first_step_with_part(plan: Plan, arm: ArmPlan) -> int:
    """The number, from 1, of the step in which an arm first moves with its part."""
    return next(
        number
        for number, step in enumerate(plan.sequence, 1)
        if any(name == arm.arm and arm.leg(leg).holding for name, leg in step.runs)
    )


def _label(arm: str, result: PickResult, words: Words) -> str:
    return words.render(LABELS[result](arm=arm.capitalize()))
