"""The tab that runs a cycle: scan, find, plan, approve, send."""

import time
from dataclasses import replace
from typing import Any

import viser

from workbench.app.core.after_a_miss import is_rest_known
from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.command import Command
from workbench.app.core.cycle.approval import Approve, standing_votes
from workbench.app.core.cycle.arm_scanner import is_at_view
from workbench.app.core.cycle.correcting import CorrectPart
from workbench.app.core.cycle.empty_hand import PlanStir
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan, Stop
from workbench.app.core.cycle.standing import moved_away
from workbench.app.core.state import Phase, State
from workbench.app.core.value_checks import MOST_PARTS, SEED_LIMIT
from workbench.app.picking.facts import bin_check_of
from workbench.gui.cycle.approval import ApprovalDialog, row_of
from workbench.gui.cycle.approval_views import approval_line
from workbench.gui.cycle.bins import BinInput
from workbench.gui.cycle.empty_hand import DropButton, StirButton, ToolButton, ViewButton
from workbench.gui.cycle.going_on import GoOnButton
from workbench.gui.cycle.kit import KitInputs
from workbench.gui.cycle.outcomes import OutcomeInputs
from workbench.gui.cycle.overrides import OverridesInputs
from workbench.gui.cycle.plan_views import plan_line
from workbench.gui.cycle.recipe import RecipeInput
from workbench.gui.cycle.row import RowInputs
from workbench.gui.cycle.sending_views import send_line
from workbench.gui.cycle.step_button import StepButton
from workbench.gui.cycle.strategies import strategy_hint, strategy_words
from workbench.gui.cycle.threshold import ThresholdInput
from workbench.gui.drawing.in_view import hidden_message
from workbench.gui.drawing.play_button import PlayButton, watched_message
from workbench.gui.help.groups import THREE_COLUMNS_MARK, group
from workbench.gui.scene.fix_inputs import FixInputs
from workbench.gui.shared.calibration_views import bin_html
from workbench.gui.shared.link_views import NO_SAFETY
from workbench.gui.shared.look import View
from workbench.gui.shared.movable_frames import BIN, move_frame
from workbench.gui.shared.views import (
    line,
    parts_line,
    scan_line,
    sentence,
)
from workbench.gui.shared.visitor import Visitor, whole
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import kit_of, strategy_of
from workbench.model.errors import InputError
from workbench.model.messages.commands import EditText
from workbench.model.messages.refusals import Refusal
from workbench.model.scan import ALL_KINDS

STAYS = '<div class="wb-stays"></div>'
"""A mark that keeps its folder in view, at the bottom, however long what stands above it is."""


class CyclePanel:
    """The five steps, each with its inputs, its result and its button."""

    def __init__(self, visitor: Visitor):
        """Add the controls."""
        self._visitor = visitor
        gui = visitor.gui
        self._drop = DropButton(visitor)
        self._add_scan(gui)
        self._add_parts(gui)
        self._add_plan(gui)
        self._add_sending(gui)
        self._outcomes = OutcomeInputs(visitor, THREE_COLUMNS_MARK)
        with group(gui, "How it is planned", expand_by_default=False):
            gui.add_html(THREE_COLUMNS_MARK)
            self._overrides = OverridesInputs(gui, visitor.cell.policy)
        self._dialog = ApprovalDialog(visitor)
        self._react()

    def _add_scan(self, gui: viser.GuiApi) -> None:
        with group(gui, "1 · Scan"):
            self._recipe = RecipeInput(self._visitor, self._follow_recipe)
            self._bin = BinInput(self._visitor)
            self._kit = KitInputs(self._visitor)
            gui.add_html(THREE_COLUMNS_MARK)
            parts, seed = self._visitor.look.now.scan_asked
            self._kind = gui.add_dropdown(
                "Which part", _kinds(self._visitor.cell), hint="Falls into the simulated bin."
            )
            self._parts = gui.add_number(
                "Parts",
                parts,
                min=1,
                max=MOST_PARTS,
                step=1,
                hint="How many parts fall into the bin.",
            )
            self._seed = gui.add_number(
                "Seed",
                seed,
                min=0,
                max=SEED_LIMIT - 1,
                step=1,
                hint="The same seed gives the same pile; another seed drops new parts.",
            )
            # Beside the kinds there is no room for the button: it goes below, to the right.
            self._gap = gui.add_html('<div class="wb-span2"></div>', visible=False)
            self._scan = gui.add_button("Scan", icon=viser.Icon.SCAN)
            self._scan_line = gui.add_html("")
            self._view = ViewButton(self._visitor)
            self._go_on = GoOnButton(self._visitor, self._seed, self._wanted_next)
            self._bin_line = gui.add_html("")
            self._move_bin = gui.add_button(
                "Move bin",
                icon=viser.Icon.ARROWS_MOVE,
                color="gray",
                visible=False,
                hint="Moves the bin of the cell to where it is seen; Undo is in the Cell tab.",
            )

    def _add_parts(self, gui: viser.GuiApi) -> None:
        with group(gui, "2 · Find parts"):
            gui.add_html(THREE_COLUMNS_MARK)
            self._parts_line = gui.add_html("")
            self._find = gui.add_button("Find parts", icon=viser.Icon.SEARCH)
            self._wrong: tuple[str, ...] = ()
            self._beside_correct = gui.add_html('<div class="wb-span2"></div>', visible=False)
            self._correct = gui.add_button(
                "·",
                icon=viser.Icon.RULER_2,
                color="gray",
                visible=False,
                hint="Makes the part as the scan shows it, in its file too, and searches again; "
                "Undo is in the Cell tab.",
            )

    def _add_plan(self, gui: viser.GuiApi) -> None:
        with group(gui, "3 · Plan"):
            gui.add_html(THREE_COLUMNS_MARK)
            self._strategies = strategy_words(self._visitor.cell, self._visitor.words)
            self._strategy = gui.add_dropdown(
                "Strategy", tuple(self._strategies), hint=strategy_hint(self._visitor.cell)
            )
            self._threshold = ThresholdInput(self._visitor, self._strategy_asked)
            self._plan = gui.add_button("Plan", icon=viser.Icon.ROUTE)
            self._row = RowInputs(self._visitor)
            self._row.add_wanted()
            self._threshold.add_forecast()
            self._plan_line = gui.add_html("")
            self._help_line = gui.add_html("", visible=False)
            self._fix = FixInputs(self._visitor)
            self._row.add_row()
            self._stir = StirButton(self._visitor, self._seed)
            self._tool = ToolButton(self._visitor, self._seed)

    def _add_sending(self, gui: viser.GuiApi) -> None:
        with group(gui, "4 · Approve, 5 · Send to the robot") as sending:
            gui.add_html(THREE_COLUMNS_MARK)
            gui.add_html(STAYS)
            self._approval_line = gui.add_html("")
            self._watched_line = gui.add_html("")
            self._play = PlayButton(self._visitor)
            self._approve = gui.add_button("Approve", icon=viser.Icon.USER_CHECK)
            self._send_line = gui.add_html("")
            self._step = StepButton(self._visitor, sending)
            self._stop = gui.add_button(
                "Stop", icon=viser.Icon.HAND_STOP, color="red", hint=NO_SAFETY
            )
            self._send = gui.add_button("Send", icon=viser.Icon.SEND)

    def show(self, old: View | None, new: View) -> None:
        """Bring what is shown from `old` to `new`."""
        state = new.state
        visitor = self._visitor
        self._outcomes.show(old, new)
        if old is None or old.help is not new.help:
            self._help_line.content = line(
                sentence(visitor.words.render(new.help.words)), kind="warn"
            )
            self._help_line.visible = bool(new.help.words)
        self._fix.show(old, new, new.help)
        self._play.show(old, new)
        watched = visitor.words.render(watched_message(new, visitor.person.name))
        words = line(watched, kind="hint", span=1)
        if words != self._watched_line.content:
            self._watched_line.content = words
        if old is not None and old.state is state and _passing(old) == _passing(new):
            return
        before = None if old is None else old.state
        self._recipe.show(before, state)
        self._bin.show(new)
        self._kit.show(new)
        self._show_kinds(state.cell)
        self._threshold.follow(before, state)
        self._threshold.draw(state, new.at)
        self._show_seen(new)
        self._plan_line.content = plan_line(state, visitor.words)
        self._row.show(new)
        self._show_buttons(new)
        follows = visitor.is_recorded or bool(visitor.lacks(state, TakeScan))
        for field in (self._kind, self._parts, self._seed, self._strategy):
            field.disabled = follows
        self._overrides.allow(is_allowed=not follows)
        is_decisive = state.cell.moves_both_arms
        self._threshold.allow(is_allowed=is_decisive and not follows)
        self._dialog.show(new)

    def _show_seen(self, new: View) -> None:
        """What the scan shows: its points, the bin and the parts found."""
        state, check, words = new.state, new.bin_check, self._visitor.words
        self._scan_line.content = scan_line(state, words)
        self._bin_line.content = bin_html(state, check, new.at, words)
        self._move_bin.visible = check is not None and check.is_elsewhere
        self._visitor.admit(self._move_bin, state, ChangeCell)
        sizes = new.live.wrong_sizes(state.detections)
        self._parts_line.content = parts_line(state, sizes, check, words)
        self._show_wrong(state, new.live.wrong_parts(state.detections))

    def _show_buttons(self, new: View) -> None:
        """What each button lacks, and which one is the next step."""
        state, visitor, joints = new.state, self._visitor, new.live.joints
        approval = Approve(_digest(state), row=row_of(state))
        why = visitor.refusal(state, approval, new.at, joints)
        is_next = why is not None and why.mentions(Refusal.NOT_PLAYED)
        problem = visitor.words.render(
            hidden_message(new.hidden) if is_next and new.hidden else why
        )
        self._approval_line.content = approval_line(
            state, new.at, problem, is_next=is_next, words=visitor.words
        )
        self._send_line.content = send_line(state, visitor.words)
        has_rest = is_rest_known(state)
        self._plan.label = visitor.words.render("Plan the rest" if has_rest else "Plan")
        self._go_on.show(new)
        begin = self._view.button if self._view.show(new) else self._scan
        hands = self._drop.show(new)
        is_stepped = self._step.show(new)
        # The button beside Stop lets the robot move, and none stands where Send was just pressed.
        self._send.visible = self._send_line.visible = not is_stepped
        stirs_next = self._stir.show(state)
        self._tool.show(new)
        buttons = (
            (self._scan, TakeScan()),
            (self._find, FindParts()),
            (self._plan, MakePlan()),
            (self._stir.button, PlanStir()),
            (self._approve, approval),
            (self._send, SendPlan(_digest(state))),
            (self._stop, Stop()),
        )
        for button, command in buttons:
            problem = visitor.words.render(visitor.refusal(state, command, new.at, joints))
            button.disabled = bool(problem)
            visitor.explain(button, problem)
        after_end = begin if _has_moved_scanner(state) else self._go_on.button
        after_finding = self._stir.button if stirs_next else self._plan
        if state.disturbed and state.verdict is not None:
            after_finding = begin
        next_step = {
            Phase.IDLE: begin,
            Phase.SCANNED: self._find,
            Phase.LOCALIZED: after_finding,
            Phase.PLANNED: self._play.button if is_next else self._approve,
            Phase.APPROVED: self._send,
            Phase.DONE: self._plan if has_rest else after_end,
        }
        # The question what a hand holds comes before all else.
        visitor.emphasise(hands or next_step.get(state.phase))

    def _follow_recipe(self, cell: Cell) -> None:
        """Have the strategy of the recipe planned with, until a person chooses another one."""
        wanted = strategy_of(cell)
        self._strategy.value = next(
            words for words, known in self._strategies.items() if known == wanted
        )
        self._threshold.take(cell.policy.threshold)

    def _show_kinds(self, cell: Cell) -> None:
        kinds = _kinds(cell)
        if self._kind.options != kinds:
            self._kind.options = kinds
        self._kind.visible = self._gap.visible = (
            len(kinds) > 1 and cell.scanner.source == "simulated" and not kit_of(cell)
        )

    def _show_wrong(self, state: State, wrong: tuple[str, ...]) -> None:
        """Offer to correct the first of the parts whose size or surface the scan shows off."""
        self._wrong = wrong
        self._correct.visible = self._beside_correct.visible = bool(wrong)
        if wrong:
            label = CyclePageText.CORRECT_PART(part=wrong[0])
            self._correct.label = self._visitor.words.render(label)
            self._visitor.admit(self._correct, state, CorrectPart)

    def _react(self) -> None:
        visitor = self._visitor

        @self._strategy.on_update
        def _(_: Any) -> None:
            self._threshold.draw(visitor.bench.state, time.time())

        visitor.on_press(self._scan, self._wanted_scan)
        visitor.on_press(self._find, self._wanted_parts)
        visitor.on_press(self._move_bin, self._wanted_bin)
        visitor.on_press(self._correct, lambda: CorrectPart(next(iter(self._wrong), "")))
        visitor.on_press(self._plan, self._wanted_plan)
        visitor.on_key("N", "New scan", lambda: visitor.ask(self._wanted_scan))
        visitor.on_key("F", "Find parts", lambda: visitor.ask(self._wanted_parts))
        visitor.on_key("P", "Plan", lambda: visitor.ask(self._wanted_plan))
        visitor.on_press(self._send, self._wanted_sending)
        visitor.on_press(self._stop, Stop)
        self._approve.on_click(lambda _: self._open_dialog())

    def _open_dialog(self) -> None:
        self._threshold.finish()
        self._dialog.open()

    def _strategy_asked(self) -> str:
        """A browser may send one that the cell does not have: that is refused with the plan."""
        return self._strategies.get(str(self._strategy.value), "")

    def _wanted_next(self) -> tuple[TakeScan, FindParts, MakePlan]:
        return self._wanted_scan(), self._wanted_parts(), self._wanted_plan()

    def _wanted_scan(self) -> TakeScan:
        parts, seed = whole(self._parts.value), whole(self._seed.value)
        if parts in range(1, MOST_PARTS + 1) and seed in range(SEED_LIMIT):
            self._visitor.look.change(scan_asked=(parts, seed))
        kind = "" if kit_of(self._visitor.bench.state.cell) else self._kind.value
        return TakeScan(seed, parts, kind, stays=True)

    def _wanted_bin(self) -> Command:
        state = self._visitor.bench.state
        check = bin_check_of(state)
        if check is None or check.T_world_bin is None:
            raise InputError("the bin is not seen anywhere")
        says = EditText.BIN_MOVED(shift=check.shift)
        after = move_frame(state.cell, BIN, check.T_world_bin)
        return ChangeCell(after, says, was=state.cell.digest)

    def _wanted_parts(self) -> FindParts:
        return FindParts(whole(self._seed.value))

    def _wanted_plan(self) -> MakePlan:
        return MakePlan(
            self._strategies[self._strategy.value],
            self._threshold.metres,
            whole(self._seed.value),
            replace(self._overrides.overrides, picks=self._row.picks),
        )

    def _wanted_sending(self) -> Command:
        self._threshold.finish()
        return SendPlan(_digest(self._visitor.bench.state))


def _kinds(cell: Cell) -> tuple[str, ...]:
    names = tuple(part.name for part in cell.parts)
    return (*names, ALL_KINDS) if len(names) > 1 else names


def _digest(state: State) -> str:
    return state.plan.digest if state.plan is not None else ""


def _has_moved_scanner(state: State) -> bool:
    """Whether what was sent has only taken the scanner to its view, or home."""
    return state.plan is not None and state.plan.is_view_plan


def _passing(view: View) -> tuple[bool, int, str, bool, tuple[tuple[float, float], ...]]:
    """What changes while the state stays: approvals lapse, the robot is moved, a plan is played."""
    state, approval = view.state, view.state.approval
    moved = None if state.plan is None else moved_away(state.cell, state.plan, view.live.joints)
    has_run_out = approval is not None and view.at >= approval.until
    is_let_out = state.phase in (Phase.PLANNED, Phase.APPROVED)
    votes = len(standing_votes(state, view.at))
    # Not at every drawing while it goes on.
    hidden = () if view.look.is_playing else view.hidden
    return (
        has_run_out,
        votes,
        str(moved or "") if is_let_out else "",
        is_at_view(state.cell, view.live.joints),
        hidden,
    )
