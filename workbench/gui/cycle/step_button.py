"""The button that lets one step of a plan run, while one is sent step by step."""

import viser

from workbench.app.core.cycle.sending import NextStep
from workbench.app.core.state import Phase
from workbench.gui.shared.look import View
from workbench.gui.shared.visitor import Visitor
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.messages.message import as_message

TWO_COLUMNS_MARK = '<div class="wb-wide"></div>'
"""A mark that has the control after it take two columns, see the style sheet."""


class StepButton:
    """Allows the step that it names; pressed once for each step, without a keyboard shortcut.

    Each step has its own button.  So a late press is for the button of a past step, and is refused.
    It may come over a slow network, or from a person who missed that the step ran.
    """

    def __init__(self, visitor: Visitor, folder: viser.GuiFolderHandle):
        """Add the first button, in `folder`; to be seen only while a plan is sent step by step."""
        self._visitor, self._folder, self._number = visitor, folder, 0
        self._wide = visitor.gui.add_html(TWO_COLUMNS_MARK, visible=False)
        self._button = self._make(0, None)
        self._used: list[viser.GuiButtonHandle] = []

    def _make(self, number: int, order: float | None) -> viser.GuiButtonHandle:
        button = self._visitor.gui.add_button(
            "Run",
            icon=viser.Icon.PLAYER_TRACK_NEXT,
            color="green",
            visible=number > 0,
            order=order,
        )
        self._visitor.on_press(button, lambda: NextStep(number))
        return button

    def _exchange(self, number: int) -> None:
        """Another button in the place of the one that is there."""
        old, self._number = self._button, number
        if number == 1:
            # Of the plan before: what a browser is still told of a control must find it.
            for button in self._used:
                button.remove()
            self._used.clear()
        old.visible = False
        self._used.append(old)
        with self._folder:
            self._button = self._make(number, old.order)

    def show(self, new: View) -> bool:
        """Bring it up to date; whether it is there."""
        state, approval, plan = new.state, new.state.approval, new.state.plan
        is_stepped = approval is not None and approval.is_stepped
        is_there = state.phase is Phase.SENDING and is_stepped and not new.is_recorded
        if plan is None or not is_there:
            self._wide.visible = self._button.visible = False
            self._number = 0
            return False
        if state.waits not in (0, self._number):
            self._exchange(state.waits)
        self._wide.visible = True
        button, steps = self._button, plan.sequence
        problem = self._visitor.refusal(state, NextStep(state.waits or 1), new.at)
        button.visible = True
        self._visitor.allow(button, self._visitor.words.render(problem))
        text = CyclePageText.BEFORE_STEP(total=len(steps))
        if number := state.waits or state.let:
            text = (CyclePageText.RUN_STEP if state.waits else CyclePageText.STEP_RUNS)(
                number=number, total=len(steps), legs=as_message(steps[number - 1].words)
            )
        label = self._visitor.words.render(text)
        if button.label != label:
            button.label = label
        return True
