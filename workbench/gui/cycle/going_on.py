"""The button that begins the next cycle, after a finished one or while one runs.

It stands beside the scan that it begins with, and always: nothing that lets a robot move comes to
stand where another button was just pressed.
"""

from collections.abc import Callable
from typing import Any

import viser

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, left_pile
from workbench.app.core.picks import SimulatedPile
from workbench.app.core.state import Ahead, Phase, State
from workbench.app.core.value_checks import SEED_LIMIT
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor, whole
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.messages.message import Message
from workbench.model.messages.states import task_message

SAYS = "Scans, finds the parts and plans; then a person looks and approves."

NEXT_CYCLE, PREPARE = "Next cycle", "Prepare next cycle"
"""What the button is called; while the robot moves, no cycle begins: the next one is prepared."""

AHEAD_HINT = (
    "It begins as soon as the scanner sees past the arms, at the latest when the plan has ended."
)
"""What is said beside that while something is sent."""


class GoOnButton:
    """To be pressed while a plan is sent, and once a cycle has ended well.

    What it begins ends before anything is approved.
    """

    def __init__(
        self,
        visitor: Visitor,
        seed: viser.GuiInputHandle[Any],
        wanted: Callable[[], tuple[TakeScan, FindParts, MakePlan]],
    ):
        """Add the button.

        Args:
            visitor: whose it is.
            seed: the field with the seed, that of the next pile once this was pressed.
            wanted: what the buttons for each step would ask for.
        """
        self._visitor, self._seed, self._wanted = visitor, seed, wanted
        gui = visitor.gui
        self.button = gui.add_button(NEXT_CYCLE, icon=viser.Icon.REPEAT, hint=SAYS)
        self._line = gui.add_html("", visible=False)
        self._stays = gui.add_html("", visible=False)
        self._new = gui.add_button(
            "New parts",
            icon=viser.Icon.BOX,
            color="gray",
            visible=False,
            hint="Empties the simulated bin, lets the parts of the next seed fall, and scans.",
        )
        self.button.on_click(lambda _: self._on_pressed())
        self._new.on_click(lambda _: self._drop_new())

    def _on_pressed(self) -> None:
        # Parts that are left stay, and so does the pile where the arm has but gone to another view.
        state, before = self._visitor.bench.state, whole(self._seed.value)
        is_same = state.plan is not None and state.plan.is_view_plan
        if not is_same and left_pile(state, self._wanted()[0]) is None:
            self._seed.value = _after(before)
        if not self._visitor.ask(lambda: GoOn(*self._wanted())):
            self._seed.value = before

    def _drop_new(self) -> None:
        before = whole(self._seed.value)
        self._seed.value = _after(before)
        if not self._visitor.ask(lambda: self._wanted()[0]):
            self._seed.value = before

    def show(self, new: View) -> None:
        """Bring it up to date."""
        state, visitor = new.state, self._visitor
        self._line.visible = state.ahead is not None
        self._stays.visible = self._new.visible = state.pile is not None
        if state.pile is not None:
            self._stays.content = line(
                visitor.words.render(_parts_message(state, state.pile)), kind="hint", span=2
            )
            visitor.admit(self._new, state, TakeScan)
        if state.ahead is not None:
            self._line.content = line(
                visitor.words.render(_progress(state, state.ahead)), kind="hint"
            )
        label = PREPARE if state.phase is Phase.SENDING else NEXT_CYCLE
        if self.button.label != label:
            self.button.label = label
        problem = visitor.refusal(state, GoOn(), new.at)
        visitor.allow(self.button, visitor.words.render(problem))
        if state.phase is Phase.SENDING and not problem:
            visitor.explain(self.button, f"{SAYS} {AHEAD_HINT}")


def _parts_message(state: State, pile: SimulatedPile) -> Message | str:
    """What of a simulated pile the next scan shows."""
    left = left_pile(state, TakeScan(pile.seed, pile.parts, pile.part))
    if left is None:
        return "Simulation: no part is left after this plan; the next cycle drops new parts."
    return CyclePageText.PARTS_STAY(count=left.left)


def _after(seed: object) -> int:
    return (seed + 1) % SEED_LIMIT if isinstance(seed, int) else 0


def _progress(state: State, ahead: Ahead) -> Message | str:
    """How far the next cycle is while this one moves."""
    if state.job is not None:
        return CyclePageText.RUNS_MEANWHILE(task=task_message(state.job.name))
    if ahead.brought:
        return "The next cycle is prepared; it counts once the plan has ended well."
    return AHEAD_HINT
