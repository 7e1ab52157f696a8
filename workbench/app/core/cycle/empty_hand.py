"""Motions of an empty hand: a scanner's path to its view and back, stirring, a change of tool."""

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, ClassVar

from workbench.app.core.cell.changes import Changed, with_carried
from workbench.app.core.command import (
    SAFE,
    Asked,
    Command,
    Decision,
    Entry,
    Right,
    refuse,
    refuse_input,
)
from workbench.app.core.cycle.arm_scanner import (
    path_problem,
    path_start,
    scan_problem,
    standing_joints,
    view_named,
)
from workbench.app.core.picks import SendingEnd
from workbench.app.core.state import (
    Phase,
    PlanState,
    ScanState,
    State,
    before_a_scan,
    begin_stage,
)
from workbench.app.core.tasks import Begun, begin_task
from workbench.app.core.value_checks import SEED_LIMIT, check_integer, check_text
from workbench.model.candidate import Reason
from workbench.model.cell import Cell
from workbench.model.derived.assembling import is_base_unseen
from workbench.model.derived.by_bin import part_beside_bin
from workbench.model.derived.policies import stir_problem
from workbench.model.messages.cells import ViewChoiceText
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import FoundPart, Message, all_of
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import ClearanceText, StateText, held_message
from workbench.model.motion import floor_distance
from workbench.model.plan import Plan, PlanResult
from workbench.model.robot import HOME
from workbench.model.tools.slots import arm_with_slot, change_problem

if TYPE_CHECKING:
    from workbench.app.core.cycle.ahead import GoOn


@dataclass(frozen=True, slots=True, eq=False)
class PlanView(Command):
    """Plan how the arm with the scanner goes from its home, or another view, to the chosen one.

    `view`: its name, or empty; `HOME`: back from it to the arm's home.
    """

    right: ClassVar[Right] = Right(CommandText.PLAN_VIEW, SAFE, plans=True)

    view: str = ""
    seed: int = 0

    def check(self, state: State, asked: Asked) -> None:
        check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        check_text("view", self.view)
        carrier = view_named(state.cell, self.view)
        joints = standing_joints(state.cell, asked.joints)
        refuse(path_problem(state.cell, carrier, joints, self.view))

    def apply(self, state: State, entry: Entry) -> Decision:
        return plan_path(state, entry, view=self.view, seed=self.seed)


@dataclass(frozen=True, slots=True, eq=False)
class PlanStir(Command):
    """Plan how an arm stirs the parts in the bin with its hand, where none can be taken."""

    right: ClassVar[Right] = Right(
        CommandText.PLAN_STIR,
        frozenset({Phase.LOCALIZED, Phase.PLANNED, Phase.APPROVED}),
        plans=True,
    )

    seed: int = 0

    def check(self, state: State, asked: Asked) -> None:
        check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        refuse(stir_refusal(state))
        refuse(scan_problem(state.cell, state.scan, standing_joints(state.cell, asked.joints)))

    def apply(self, state: State, entry: Entry) -> Decision:
        return plan_stir(state, entry, self.seed)


@dataclass(frozen=True, slots=True, eq=False)
class PlanToolChange(Command):
    """Plan how an arm puts down its tool and takes the one of that name.

    `arm`: its name; empty: the first one that has a slot for the tool.
    """

    right: ClassVar[Right] = Right(CommandText.PLAN_TOOL_CHANGE, SAFE, plans=True)

    tool: str
    arm: str = ""
    seed: int = 0

    def check(self, state: State, asked: Asked) -> None:
        check_integer("seed", self.seed, 0, SEED_LIMIT - 1)
        check_text("tool", self.tool)
        check_text("arm", self.arm)
        with refuse_input():
            refuse(change_problem(state.cell, self.arm_in(state.cell), self.tool))

    def apply(self, state: State, entry: Entry) -> Decision:
        arguments = {
            "arm": self.arm_in(state.cell),
            "tool": self.tool,
            "placed": state.placed,
            "seed": self.seed,
        }
        return begin_task(state, entry, "change", arguments, StateText.PLANNING())

    def arm_in(self, cell: Cell) -> str:
        """The name of the arm that is meant."""
        return self.arm or arm_with_slot(cell, self.tool)


def stir_refusal(state: State) -> Message | None:
    """Why no hand can stir the parts found; None when one can."""
    if not state.detections:
        return Refusal.NO_PARTS_TO_STIR()
    if state.disturbed:
        return Refusal.MOVED_BY_A_MISS()
    if (number := part_beside_bin(state.cell, state.detections)) is not None:
        return Refusal.STIR_BESIDE_BIN(part=FoundPart(number))
    return stir_problem(state.cell)


def may_stir(state: State) -> bool:
    """Whether the cell's rule lets a cycle stir the parts now, where none can be taken."""
    if is_base_unseen(state.obstacles):
        # The parts in the bin are not what is missing.
        return False
    is_late = state.verdict is not None and state.verdict.reason is Reason.OUT_OF_TIME
    return state.stirs < state.cell.policy.stirs and not is_late and stir_refusal(state) is None


def plan_stir(state: State, entry: Entry, seed: int, then: "GoOn | None" = None) -> Begun:
    """A plan by which an arm stirs the parts begins to be made; with `then` that of a cycle."""
    arguments = {
        "detections": state.detections,
        "scan_digest": state.scene_digest,
        "scan": state.scan,
        "placed": state.placed,
        "seed": seed,
    }
    return begin_task(state, entry, "stir", arguments, StateText.PLANNING(), seed=seed, then=then)


def with_stir_plan(state: State, result: PlanResult) -> State:
    """The state after stirring was planned; the verdicts on the parts stay.

    Without a plan no further one is asked for by itself.
    """
    plan, proof, most = result.plan, result.proof, state.cell.policy.stirs
    if plan is None or proof is None:
        message = StateText.NO_STIR(verdict=result.verdict.message)
        return replace(state, stirs=most, message=message)
    message = StateText.STIR_PLANNED(
        arm=plan.strategy.arm,
        cycle=plan.cycle_seconds,
        clearance=ClearanceText.FREE(free=floor_distance(proof.clearance)),
    )
    if not proof.holds:
        message = StateText.NOT_PROVEN(violation=proof.violations[0].message)
    return begin_stage(
        state,
        PlanState,
        phase=Phase.PLANNED,
        candidates=state.candidates,
        plan=plan,
        proof=proof,
        verdict=result.verdict,
        seconds=tuple(result.seconds.items()),
        obstacles=result.obstacles,
        outlines=state.outlines,
        planned_threshold=state.wanted_threshold,
        wanted_threshold=state.wanted_threshold,
        message=message,
    )


def with_change_plan(state: State, result: PlanResult) -> State:
    """The state after a change of tool was planned.

    With a plan the scan is void: the arm passes through what it shows, and the cell is another one
    afterwards.
    """
    plan, proof = result.plan, result.proof
    if plan is None or proof is None:
        return replace(state, message=StateText.NO_PLAN(verdict=result.verdict.message))
    message = StateText.CHANGE_PLANNED(
        arm=plan.strategy.arm,
        tool=plan.arms[0].tool,
        cycle=plan.cycle_seconds,
        clearance=ClearanceText.FREE(free=floor_distance(proof.clearance)),
    )
    return without_scan(state, result, message)


def with_drop_plan(state: State, result: PlanResult) -> State:
    """The state after a drop back was planned: with a plan the scan is void."""
    plan, proof = result.plan, result.proof
    if plan is None or proof is None:
        return replace(state, message=StateText.NO_DROP(verdict=result.verdict.message))
    message = StateText.DROP_PLANNED(
        arm=plan.strategy.arm,
        held=held_message(plan.arms[0].held),
        cycle=plan.cycle_seconds,
        clearance=ClearanceText.FREE(free=floor_distance(proof.clearance)),
    )
    return without_scan(state, result, message)


def with_hand_used(state: State, plan: Plan) -> State:
    """The state after a hand has stirred the parts, or has dropped one back among them.

    None lies where a scan has shown it.
    """
    chosen = state.cell.bin.name
    after = replace(
        state,
        phase=Phase.DONE,
        empty_bins=tuple(name for name in state.empty_bins if name != chosen),
        views_without=(),
        message=StateText.DROPPED_BACK(arm=plan.strategy.arm),
    )
    if plan.is_drop_plan:
        emptied = plan.strategy.arm
        is_open = tuple(arm for arm in state.hands_open if arm != emptied)
        return replace(after, hands_emptied=(*state.hands_emptied, emptied), hands_open=is_open)
    avoided = tuple(mark for mark in state.avoided if mark.bin != chosen)
    return replace(after, stirs=state.stirs + 1, avoided=avoided, message=StateText.STIRRED())


def with_new_tool(before: State, after: State, ended: SendingEnd) -> Changed:
    """The state once a plan has ended that changes a tool: the cell with what the arm carries.

    Args:
        before: while the plan was sent.
        after: once its end was taken in.
        ended: what the link says.
    """
    if before.plan is None or not before.plan.is_tool_plan:
        return after, ()
    (changed,) = before.plan.arms
    if ended.fault:
        unknown = (*(arm for arm in after.tools_unknown if arm != changed.arm), changed.arm)
        return replace(after, tools_unknown=unknown), ()
    message = StateText.TOOL_CHANGED(arm=changed.arm, tool=changed.tool)
    with_tool, effects = with_carried(after, changed.arm, changed.tool, message)
    # The plan was carried out: that it no longer fits the cell is no news.
    return replace(with_tool, stale=None), effects


def plan_path(state: State, entry: Entry, *, view: str = "", seed: int = 0) -> Begun:
    """The path to the chosen view begins to be planned, or with `HOME` the one back."""
    carrier = view_named(state.cell, view)
    joints = standing_joints(state.cell, entry.joints)
    start = path_start(state.cell, carrier, joints) or HOME
    arguments = {"view": view, "start": start, "placed": state.placed, "seed": seed}
    return begin_task(state, entry, "view", arguments, StateText.PLANNING())


def with_view_plan(state: State, result: PlanResult) -> State:
    """The state after the path to the view, or back, was planned.

    With a plan the scan is void: the arm leaves where it was taken.
    """
    plan, proof, carrier = result.plan, result.proof, state.cell.scanner.on_arm
    if plan is None or proof is None or carrier is None:
        return replace(state, message=StateText.NO_PLAN(verdict=result.verdict.message))
    facts = {
        "cycle": plan.cycle_seconds,
        "clearance": ClearanceText.FREE(free=floor_distance(proof.clearance)),
    }
    message = StateText.VIEW_PLANNED(view=carrier.view.name, **facts)
    if carrier.leads_home(plan.arms[0].legs[0].q):
        message = StateText.HOME_PLANNED(**facts)
    elif state.views_without:
        nothing = ViewChoiceText.NOTHING_FROM(views=state.views_without)
        message = all_of((nothing, message)) or message
    return without_scan(state, result, message)


def without_scan(state: State, result: PlanResult, message: Message) -> State:
    """The state with a plan that no scan is for."""
    plan, proof = result.plan, result.proof
    assert plan is not None and proof is not None
    if not proof.holds:
        message = StateText.NOT_PROVEN(violation=proof.violations[0].message)
    return begin_stage(
        before_a_scan(state),
        ScanState,
        phase=Phase.PLANNED,
        scene_digest=plan.scan_digest,
        plan=plan,
        proof=proof,
        verdict=result.verdict,
        seconds=tuple(result.seconds.items()),
        obstacles=result.obstacles,
        message=message,
    )
