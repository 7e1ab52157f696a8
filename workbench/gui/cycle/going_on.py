"""The button that begins the next cycle, after a finished one or while one runs.

It stands beside the scan that it begins with, and always: nothing that lets a robot move comes to
stand where another button was just pressed.
"""

from collections.abc import Callable

import viser

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
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

NOTHING_STAYS = (
    "Simulation: no part stays. Scan drops the pile of this seed again, the next cycle that of "
    "the next seed."
)
"""What becomes of parts that are left in the bin, where no real one lies there."""

AFTER_A_PICK = frozenset({Phase.SENDING, Phase.DONE, Phase.FAULT})
"""Phases in which a person asks what becomes of the parts that are left."""


class GoOnButton:
    """To be pressed while a plan is sent, and once a cycle has ended well.

    What it begins ends before anything is approved.
    """

    def __init__(
        self,
        visitor: Visitor,
        seed: viser.GuiInputHandle[int],
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
        self._stays = gui.add_html(line(NOTHING_STAYS, kind="hint"), visible=False)
        self.button.on_click(lambda _: self._on_pressed())

    def _on_pressed(self) -> None:
        # The same seed would let the same simulated pile fall again; it does lie there still where
        # the arm has but gone to another view.
        before, plan = whole(self._seed.value), self._visitor.bench.state.plan
        if isinstance(before, int) and (plan is None or not plan.is_view_plan):
            self._seed.value = (before + 1) % SEED_LIMIT
        if not self._visitor.ask(lambda: GoOn(*self._wanted())):
            self._seed.value = before

    def show(self, new: View) -> None:
        """Bring it up to date."""
        state, visitor = new.state, self._visitor
        self._line.visible = state.ahead is not None
        is_simulated = state.cell.scanner.source == "simulated" and not visitor.is_recorded
        is_asked = state.phase in AFTER_A_PICK or state.unscanned is not None
        has_picked = state.plan is None or bool(state.plan.picks)
        self._stays.visible = is_simulated and is_asked and has_picked
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


def _progress(state: State, ahead: Ahead) -> Message | str:
    """How far the next cycle is while this one moves."""
    if state.job is not None:
        return CyclePageText.RUNS_MEANWHILE(task=task_message(state.job.name))
    if ahead.brought:
        return "The next cycle is prepared; it counts once the plan has ended well."
    return AHEAD_HINT
