"""Prepares the next cycle while a plan still runs, apart from the state until the plan has ended.

A person commands `GoOn` while a plan is sent.  The scan is taken as soon as the robot reports a
step from which on the arms are out of the scanner's view.  Then parts are searched and planned for
the state after a successful end.  Scan and plan enter the state only after such an end; any doubt
discards them.  Nothing here sends.
"""

from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from workbench.app.core.after_a_miss import is_rest_known, with_rest
from workbench.app.core.command import Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.arm_scanner import standing_joints, view_problem
from workbench.app.core.cycle.outcomes import after_sending
from workbench.app.core.cycle.parts import FindParts, check_search
from workbench.app.core.cycle.planning import MakePlan, check_planning, make_plan
from workbench.app.core.cycle.results import (
    continue_cycle,
    from_next_bin,
    is_exhausted,
    with_result,
)
from workbench.app.core.cycle.scanning import TakeScan, check_scan, take_scan
from workbench.app.core.effects import StartJob, StopJob
from workbench.app.core.picks import SendingEnd
from workbench.app.core.state import Ahead, Phase, State
from workbench.app.core.tasks import Begun
from workbench.model.derived.assembling import looks_again
from workbench.model.digest import LATER, digest_of
from workbench.model.errors import CommandRefused
from workbench.model.messages.cells import SlotText
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message, all_of, as_message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import AheadText, RowStop, StateText
from workbench.model.release import PartReport, PickResult
from workbench.model.scan import Detection

Ended = tuple[State, tuple[StartJob | StopJob, ...]]


@dataclass(frozen=True, slots=True, eq=False)
class GoOn(Command):
    """After a finished cycle: scan, find parts and plan, each as soon as the one before is done.

    After a missed grip it begins with the plan where the policy has `retry_without_scan`.

    It ends with a plan that waits for its approval, or earlier: with whatever needs a person, and
    when who has asked for it gives control away or has gone.  It approves and sends nothing.

    Given while something is sent, it begins with the last plan's step `sees_from`, from 1, where
    the scanner sees past the arms (0: with its end).  `placed` will lie on pallets by then.
    """

    right: ClassVar[Right] = Right(
        CommandText.GO_ON, frozenset({Phase.SENDING, Phase.DONE}), plans=True
    )

    scan: TakeScan = field(default_factory=TakeScan)
    find: FindParts = field(default_factory=FindParts)
    plan: MakePlan = field(default_factory=MakePlan)
    sees_from: int | None = field(default_factory=lambda: None, metadata=LATER)
    placed: tuple[Detection, ...] | None = field(default_factory=lambda: None, metadata=LATER)

    @classmethod
    def obstacle(cls, state: State) -> Message | None:
        if state.plan is not None and state.plan.is_tool_plan:
            return SlotText.CHANGING(arm=state.plan.arms[0].arm)
        return None if state.ahead is None else Refusal.NEXT_CYCLE_ASKED()

    def check(self, state: State, asked: Asked) -> None:
        check_scan(state.cell, self.scan)
        check_search(self.find)
        check_planning(state.cell, self.plan)
        carrier = state.cell.scanner.on_arm
        if carrier is not None and state.phase is Phase.SENDING:
            raise CommandRefused(Refusal.SCANS_AFTER_THE_END(arm=carrier.arm))
        refuse(view_problem(state.cell, standing_joints(state.cell, asked.joints)))
        if self.find.is_compared:
            raise CommandRefused(Refusal.ONLY_COMPARED())

    def apply(self, state: State, entry: Entry) -> Decision:
        state = replace(state, kit=replace(state.kit, bins_without=()))
        if state.phase is Phase.SENDING:
            return request_ahead(state, self, entry)
        return _without_scan(state, self, entry) or take_scan(state, entry, self.scan, then=self)


def _without_scan(state: State, wanted: GoOn, entry: Entry) -> Begun | None:
    """The planning for the remaining parts after a missed grip; None if a scan is needed first."""
    if not (state.cell.policy.retry_without_scan and is_rest_known(state)):
        return None
    return make_plan(with_rest(state), entry, wanted.plan, then=wanted)


def request_ahead(state: State, wanted: GoOn, entry: Entry) -> Begun:
    """The state with the next cycle requested while a plan is sent."""
    message = StateText.NEXT_CYCLE_AT_END()
    if wanted.sees_from:
        message = StateText.NEXT_CYCLE_FROM(step=wanted.sees_from)
    return scan_ahead(replace(state, ahead=Ahead(wanted), message=message), entry)


def scan_ahead(state: State, entry: Entry) -> Begun:
    """Trigger the scanner once the robot reports a step at which the arms are out of its view."""
    ahead = state.ahead
    if ahead is None or ahead.brought or state.job is not None or not _is_view_clear(state, ahead):
        return state, ()
    begun, effects = take_scan(state, entry, ahead.wanted.scan, then=ahead.wanted)
    message = StateText.OUT_OF_VIEW()
    return replace(state, job=begun.job, message=message), effects


def take_result_ahead(state: State, number: int, result: Any, entry: Entry) -> Decision:
    """The state with a task's result for the next cycle, and the task that follows from it."""
    job, ahead = state.job, state.ahead
    if job is None or ahead is None or job.number != number:
        return state, ()
    ahead = replace(ahead, brought=(*ahead.brought, (job, result, entry.at)))
    state = replace(state, ahead=ahead)
    foreseen = _with_results(_as_if_ended(state, entry.at), ahead)
    following, effects = continue_cycle(state, foreseen, entry)
    message = StateText.NEXT_CYCLE(message=as_message(following.message))
    return replace(state, job=following.job, message=message), effects


def discard_ahead(state: State, why: Message) -> Ended:
    """The state without the prepared cycle and without the request for it."""
    if state.ahead is None:
        return state, ()
    effects = () if state.job is None else (StopJob(state.job.number),)
    message = all_of((as_message(state.message), StateText.NOT_AHEAD(why=why)))
    return replace(state, ahead=None, job=None, message=message), effects


def finish_ahead(before: State, after: State, entry: Entry) -> Decision:
    """Take the prepared cycle into the state, or discard it, when a plan has ended.

    Args:
        before: the state while the plan was sent.
        after: the state after its end, in which the next plan of the row may already be sent.
        entry: the journal entry of the end.
    """
    ahead = before.ahead
    if ahead is None or after.phase is Phase.SENDING:
        return after, ()
    if why := _in_doubt(before, after, entry.at):
        after, effects = discard_ahead(after, why)
        begun, tasks = _without_scan(after, ahead.wanted, entry) or (after, ())
        return begun, (*effects, *tasks)
    if not ahead.brought and before.job is None:
        begun, effects = take_scan(after, entry, ahead.wanted.scan, then=ahead.wanted)
        message = all_of((as_message(after.message), StateText.SCANNING()))
        return replace(begun, ahead=None, message=message), effects
    taken = _with_results(replace(after, ahead=None), ahead)
    if before.job is not None and before.job.name == "plan":
        taken = replace(taken, wanted_threshold=before.job.threshold)
    message = after.message
    if ahead.brought:
        message = all_of((as_message(after.message), as_message(taken.message)))
    taken = replace(taken, job=before.job, message=message)
    if taken.job is None and is_exhausted(taken):
        begun, effects = from_next_bin(taken, entry, ahead.wanted)
        message = all_of((as_message(after.message), as_message(begun.message)))
        return replace(begun, message=message), effects
    return taken, ()


def _is_view_clear(state: State, ahead: Ahead) -> bool:
    """Whether the robot reports that the last plan has reached the step from which a scan works."""
    if looks_again(state.cell):
        # A base that is on its way there has to be in the next scan.
        return False
    sees_from, receipts = ahead.wanted.sees_from, state.receipts
    if state.row or state.stopped_by or not sees_from or _has_failed(state):
        return False
    return max((report.step for report in receipts), default=0) >= sees_from


def _has_failed(state: State) -> bool:
    """Whether the robot or a person has reported a failed pick."""
    reports = (receipt.part for receipt in state.receipts if receipt.part is not None)
    has_failed_part = any(part.is_picked is False for part in (*reports, *state.part_reports))
    return has_failed_part or any(
        outcome.became is not PickResult.PICKED for outcome in state.outcomes
    )


def _as_if_ended(state: State, at: float) -> State:
    """The state that a successful end of the current plan would leave, `at` [s since the epoch]."""
    if state.plan is None or state.ahead is None:
        return state
    parts = tuple(PartReport(arm.arm, arm.detection, True) for arm in state.plan.picks)
    ended = SendingEnd("", len(parts), parts, state.ahead.wanted.placed)
    return replace(after_sending(state, ended, at), job=None, ahead=None)


def _with_results(state: State, ahead: Ahead) -> State:
    """The state with all results of the prepared cycle, as if its jobs had begun after the end."""
    for job, result, at in ahead.brought:
        if job.name == "plan":
            state = replace(state, wanted_threshold=job.threshold)
        state = with_result(replace(state, job=job), job.number, result, at)
    return state


def _in_doubt(before: State, after: State, at: float) -> Message | None:
    """Why the prepared cycle does not fit the state after the end; None when it does."""
    if after.phase is not Phase.DONE:
        return AheadText.NOT_AS_PLANNED()
    if after.stopped_by:
        return RowStop.STOPPED_BY(person=after.stopped_by)
    if before.row:
        return AheadText.ROW_ENDED()
    # A person may have seen more than the gripper felt afterwards.
    if _has_failed(before) or _has_failed(after):
        return AheadText.PICK_FAILED()
    if before.job is None and before.ahead is not None and not before.ahead.brought:
        return None
    picks = () if after.plan is None else after.plan.picks
    if sum(part.is_picked is True for part in after.part_reports) < len(picks):
        return AheadText.NOT_ALL_PICKED()
    if digest_of(after.placed) != digest_of(_as_if_ended(before, at).placed):
        return AheadText.OTHER_PLACES()
    return None
