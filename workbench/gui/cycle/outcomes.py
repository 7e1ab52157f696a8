"""What became of each part of a sent plan: a row an arm, with the two words for it."""

import viser

from workbench.app.core.commands import Command, ReportPick
from workbench.app.core.state import State
from workbench.app.core.value_checks import LONGEST_TEXT
from workbench.gui.help.groups import help_html
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor
from workbench.model.errors import InputError
from workbench.model.plan import parts_taken


class OutcomeInputs:
    """Shown once something was sent; what is said can be corrected until the next scan.

    Concurrency: clicks give commands; the renderer's thread draws.
    """

    def __init__(self, visitor: Visitor, row: str):
        """Add the controls, unseen; `row` marks a folder of three columns."""
        self._visitor = visitor
        gui = visitor.gui
        self._folder = gui.add_folder("What became of the parts", visible=False)
        with self._folder:
            gui.add_html(help_html("What became of the parts"))
            gui.add_html(row)
            self._rows = {arm.name: self._row(arm.name) for arm in visitor.cell.arms}
            self._why = gui.add_text(
                "Why it failed",
                "",
                hint="Kept with a failure: the part is left alone in the next scans.",
            )

    def _row(
        self, arm: str
    ) -> tuple[viser.GuiHtmlHandle, viser.GuiButtonHandle, viser.GuiButtonHandle]:
        gui, visitor = self._visitor.gui, self._visitor
        text = gui.add_html("")
        picked = gui.add_button(f"{arm.capitalize()} picked", color="green")
        failed = gui.add_button(f"{arm.capitalize()} failed", color="red")
        visitor.on_press(picked, lambda: self._word(arm, True))
        failed.on_click(lambda _: self._failed(arm))
        return text, picked, failed

    def _failed(self, arm: str) -> None:
        if self._visitor.ask(lambda: self._word(arm, False)):
            # The next failure has a reason of its own.
            self._why.value = ""

    def _word(self, arm: str, is_picked: bool) -> Command:
        number = _taken_last(self._visitor.bench.state, arm)
        if number is None:
            raise InputError(f"the {arm} arm had no part in the plan")
        why = "" if is_picked else self._why.value.strip()[:LONGEST_TEXT]
        return ReportPick(number, is_picked, why)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state = new.state
        if old is not None and old.state is state:
            return
        if old is not None and old.state.scan is not state.scan and self._why.value:
            self._why.value = ""
        is_sent = state.plan is not None and not self._visitor.obstacle(state, ReportPick)
        self._folder.visible = is_sent
        for arm, (text, picked, failed) in self._rows.items():
            number = _taken_last(state, arm) if is_sent else None
            for control in (text, picked, failed):
                control.visible = number is not None
            if number is None:
                continue
            said = next((o for o in state.outcomes if o.detection == number), None)
            picked.disabled = said is not None and said.is_picked
            failed.disabled = said is not None and not said.is_picked
            words = "" if said is None else (" picked" if said.is_picked else " failed")
            kind = "result" if said is None or said.is_picked else "bad"
            tip = "" if said is None else f"said by {said.by}; {said.why}"
            text.content = line(f"part-{number + 1}{words}", kind=kind, span=1, tip=tip)


def _taken_last(state: State, arm: str) -> int | None:
    """The part, by its number in the scan, that an arm takes last of all that was sent."""
    for plan in reversed(state.plans[: len(state.sent_before) + 1]):
        numbers = parts_taken(state.plans[0], plan)
        for number, one in zip(numbers, plan.arms, strict=True):
            if one.arm == arm:
                return number
    return None
