"""Buttons that plan motions without a part: to a view, stirring, another tool, a drop back."""

from collections.abc import Mapping
from typing import Any

import viser

from workbench.app.core.cell.views import ChooseView
from workbench.app.core.cycle.arm_scanner import is_at_view
from workbench.app.core.cycle.empty_hand import PlanStir, PlanToolChange, PlanView, may_stir
from workbench.app.core.drop_back import ConfirmHandsEmpty, PlanDropBack
from workbench.app.core.hands import arms_that_may_hold, hands_message, is_drop_next, may_hold
from workbench.app.core.state import State
from workbench.gui.help.groups import THREE_COLUMNS_MARK, group
from workbench.gui.shared.look import View
from workbench.gui.shared.views import line
from workbench.gui.shared.visitor import Visitor, whole
from workbench.model.cell import Cell
from workbench.model.derived.by_view import view_name, views_of
from workbench.model.errors import InputError
from workbench.model.robot import HOME
from workbench.model.tools.held_body import HeldAmount
from workbench.model.tools.slots import stands_in_slot

SAYS = "Plans the path of the arm with the scanner between home and view; then a person approves."

CHOOSE_AMOUNT = "choose first"
"""What the list shows first: nobody plans with an amount that no person has stated."""

NO_AMOUNT = "state first what the hand holds: look at it"

AMOUNTS: Mapping[str, HeldAmount] = {
    "one part": HeldAmount.ONE,
    "two parts": HeldAmount.TWO,
    "unknown": HeldAmount.UNKNOWN,
}
"""What people choose from."""

TO_VIEW, TO_HOME = "Go to view", "Go back home"

NO_VIEW = NO_TOOL_THERE = "-"


class StirButton:
    """Below **Plan**, to be seen where none of the parts found can be taken."""

    def __init__(self, visitor: Visitor, seed: viser.GuiInputHandle[int]):
        """Add the button; `seed` is the field with the seed of the request."""
        gui = visitor.gui
        self._gap = gui.add_html('<div class="wb-span2"></div>', visible=False)
        self.button = gui.add_button(
            "Stir parts",
            icon=viser.Icon.TORNADO,
            color="gray",
            visible=False,
            hint="Plans how a hand goes through the parts, so that they lie otherwise; then a "
            "person approves.",
        )
        visitor.on_press(self.button, lambda: PlanStir(whole(seed.value)))

    def show(self, state: State) -> bool:
        """Bring it up to date; whether it is the next step."""
        is_stuck = bool(state.detections) and state.verdict is not None and state.plan is None
        self.button.visible = self._gap.visible = is_stuck
        return is_stuck and may_stir(state)


class DropButton:
    """A group of its own, to be seen where a hand may hold something that it should not.

    With the button by which a person states that no hand does.
    """

    def __init__(self, visitor: Visitor):
        """Add the group with its question, the list and the buttons."""
        self._visitor = visitor
        with group(visitor.gui, "Does a hand hold a part?") as self._group:
            self._add(visitor.gui)
        self._group.visible = False
        self._view: View | None = None
        visitor.on_press(self.button, self.command)
        visitor.on_press(self.empty, ConfirmHandsEmpty)

        @self._held.on_update
        def _(_: Any) -> None:
            if self._view is not None:
                self._allow(self._view)

    def _add(self, gui: viser.GuiApi) -> None:
        gui.add_html(THREE_COLUMNS_MARK)
        self._line = gui.add_html("")
        self._held: Any = gui.add_dropdown(
            "In the hand",
            (CHOOSE_AMOUNT, *AMOUNTS),
            initial_value=CHOOSE_AMOUNT,
            hint="One part as it was gripped, in any orientation; two parts; or unknown: the plan "
            "keeps more room.",
        )
        self.button = gui.add_button(
            "Drop back",
            icon=viser.Icon.ARROW_BACK_UP,
            hint="Plans how the arm carries back what it holds, from where it stands, and opens "
            "its hand there; then a person approves. The scan is void.",
        )
        self.empty = gui.add_button(
            "Hands are empty",
            icon=viser.Icon.CHECK,
            color="gray",
            hint="States that you have looked and that no hand holds a part.",
        )

    def command(self) -> PlanDropBack:
        """What a press asks for.

        Raises:
            InputError: no person has chosen an amount.
        """
        held = AMOUNTS.get(str(self._held.value))
        if held is None:
            raise InputError(NO_AMOUNT)
        return PlanDropBack(str(held))

    def show(self, new: View) -> viser.GuiButtonHandle | None:
        """Bring it up to date; the button that is the next step, None where neither is."""
        self._view, state = new, new.state
        self._group.visible = may_hold(state)
        if not self._group.visible:
            # Another hand, another time: that is stated anew.
            if self._held.value != CHOOSE_AMOUNT:
                self._held.value = CHOOSE_AMOUNT
            return None
        words = self._visitor.words
        asked = words.render(hands_message(state) or "")
        self._line.content = line(asked, kind="warn", span=3)
        self._visitor.admit(self.empty, state, ConfirmHandsEmpty)
        can_drop = self._allow(new)
        if state.plan is not None and state.plan.is_drop_plan:
            return None
        if not is_drop_next(state) and not (state.hands_open and arms_that_may_hold(state)):
            return None
        return self.button if can_drop else self.empty

    def _allow(self, view: View) -> bool:
        """Let it be pressed, or have it say why not; whether nothing but the amount is missing."""
        visitor, held = self._visitor, AMOUNTS.get(str(self._held.value))
        asked = PlanDropBack() if held is None else PlanDropBack(str(held))
        problem = visitor.refusal(view.state, asked, view.at, view.live.joints)
        missing = NO_AMOUNT if held is None else ""
        visitor.allow(self.button, visitor.words.render(problem) or missing)
        return problem is None


class ToolButton:
    """Below **Plan**, to be seen where a tool of an arm stands in its slot."""

    def __init__(self, visitor: Visitor, seed: viser.GuiInputHandle[int]):
        """Add the list and the button; `seed` is the field with the seed of the request."""
        self._visitor, self._seed = visitor, seed
        self._choices = _standing(visitor.cell)
        self._chosen: Any = visitor.gui.add_dropdown(
            "Tool in its slot",
            tuple(self._choices) or (NO_TOOL_THERE,),
            visible=False,
            hint="What the arm takes instead of the tool that it carries.",
        )
        self._button = visitor.gui.add_button(
            "Change tool",
            color="gray",
            visible=False,
            hint="Plans how the arm puts down its tool and takes the other one; then a person "
            "approves. The scan is void then.",
        )
        visitor.on_press(self._button, self.command)

    def command(self) -> PlanToolChange:
        """What a press asks for."""
        arm, tool = self._choices.get(str(self._chosen.value), ("", str(self._chosen.value)))
        return PlanToolChange(tool, arm, whole(self._seed.value))

    def show(self, new: View) -> None:
        """Bring it up to date."""
        visitor, names = self._visitor, tuple(self._choices)
        self._choices = _standing(new.state.cell)
        if tuple(self._choices) != names and self._choices:
            self._chosen.options = tuple(self._choices)
        self._chosen.visible = self._button.visible = bool(self._choices)
        if self._choices:
            problem = visitor.refusal(new.state, self.command(), new.at, new.live.joints)
            visitor.allow(self._button, visitor.words.render(problem))


def _standing(cell: Cell) -> dict[str, tuple[str, str]]:
    """Arm and tool of all tools in their slots, by what people call them."""
    found = [
        (arm.name, slot.tool)
        for arm in cell.arms
        for slot in arm.tool_slots
        if stands_in_slot(arm, slot.tool)
    ]
    is_one = len(cell.arms) == 1
    return {tool if is_one else f"{arm}: {tool}": (arm, tool) for arm, tool in found}


class ViewButton:
    """Next to the scan, which is taken at the view; to be seen where an arm carries the scanner.

    Where the bin has several views, a list chooses one.
    """

    def __init__(self, visitor: Visitor):
        """Add the button and the list."""
        self._visitor = visitor
        self.button = visitor.gui.add_button(
            TO_VIEW, icon=viser.Icon.SCAN_EYE, visible=False, hint=SAYS
        )
        self._goal = ""
        visitor.on_press(self.button, lambda: PlanView(self._goal))
        # A browser may send anything.
        self._chosen: Any = visitor.gui.add_dropdown(
            "View",
            _names(visitor.cell) or (NO_VIEW,),
            visible=False,
            hint="Scans are taken from it. The scan and the plan are void when another one is "
            "chosen; then the arm has to go there.",
        )

        @self._chosen.on_update
        def _(event: Any) -> None:
            # The renderer sets it, too; only a person's hand comes with a browser.
            if event.client is None:
                return
            name, now = str(self._chosen.value), view_name(visitor.bench.state.cell)
            if name != now and not visitor.ask(lambda: ChooseView(name)):
                self._chosen.value = view_name(visitor.bench.state.cell)

    def show(self, new: View) -> bool:
        """Bring it up to date; whether it is what comes before a scan."""
        state, visitor = new.state, self._visitor
        self._show_views(state)
        self.button.visible = state.cell.scanner.on_arm is not None
        if not self.button.visible:
            return False
        self._goal = HOME if is_at_view(state.cell, new.live.joints) else ""
        label = TO_HOME if self._goal else TO_VIEW
        if self.button.label != label:
            self.button.label = label
        problem = visitor.refusal(state, PlanView(self._goal), new.at, new.live.joints)
        visitor.allow(self.button, visitor.words.render(problem))
        return problem is None and not self._goal

    def _show_views(self, state: State) -> None:
        """Show the view that is chosen now, where there are several."""
        names, chosen = _names(state.cell), self._chosen
        chosen.visible = len(names) > 1
        if not chosen.visible:
            return
        if chosen.options != names:
            chosen.options = names
        if chosen.value != view_name(state.cell):
            chosen.value = view_name(state.cell)
        self._visitor.admit(chosen, state, ChooseView)


def _names(cell: Cell) -> tuple[str, ...]:
    return tuple(view.name for view in views_of(cell))
