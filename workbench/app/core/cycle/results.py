"""Results of the worker's jobs, and the steps that follow automatically."""

from dataclasses import replace
from typing import TYPE_CHECKING, Any

from workbench.app.core.cell.bins import choose_bin, next_bin
from workbench.app.core.cell.emptying import emptying_words
from workbench.app.core.cell.kits import kit_problem, lacks_of
from workbench.app.core.cell.views import (
    choose_view,
    missing_view,
    next_view,
    next_view_message,
    with_nothing_seen,
)
from workbench.app.core.command import Decision, Entry
from workbench.app.core.cycle.arm_scanner import (
    path_problem,
    scan_problem,
    standing_joints,
    view_problem,
)
from workbench.app.core.cycle.empty_hand import (
    may_stir,
    plan_path,
    plan_stir,
    with_change_plan,
    with_drop_plan,
    with_stir_plan,
    with_view_plan,
)
from workbench.app.core.cycle.parts import add_search, find_parts, with_detections
from workbench.app.core.cycle.planning import make_plan, with_plan
from workbench.app.core.cycle.scanning import TakeScan, take_scan, with_scan
from workbench.app.core.state import Job, Phase, State
from workbench.model.calibration import BallScan, PlateObservation
from workbench.model.errors import JobCancelled, WorkbenchError
from workbench.model.messages.calibration import VerifyText
from workbench.model.messages.cells import BinChoiceText
from workbench.model.messages.message import Message, all_of, as_message
from workbench.model.messages.states import StateText, task_message
from workbench.model.messages.work import JobText
from workbench.model.plan import PlanResult
from workbench.model.prediction import Emptying
from workbench.model.scan import Scan, SearchRecord

if TYPE_CHECKING:
    from workbench.app.core.cycle.ahead import GoOn

FAILURES = (
    StateText.TASK_FAILED,
    StateText.NOTHING_FOUND,
    StateText.POSES_REFUSED,
    StateText.CELL_REFUSED,
    StateText.NO_PLAN,
    StateText.NO_STIR,
    StateText.NOT_PROVEN,
    StateText.NO_PROOF,
)
"""Messages of a state that report a failure."""


def is_failure(message: Message | str) -> bool:
    """Whether a message of a state reports a failure."""
    return isinstance(message, Message) and any(map(message.mentions, FAILURES))


def with_result(state: State, number: int, result: Any, at: float) -> State:
    """The state after the running task has ended, at [s since the epoch]; others change nothing."""
    job = state.job
    if job is None or job.number != number:
        return state
    state = replace(state, job=None)
    match (job.name, result):
        case (_, JobCancelled()):
            return replace(state, message=StateText.TASK_CANCELLED(task=task_message(job.name)))
        case (_, WorkbenchError()):
            return replace(state, message=_failure_message(job, result.message))
        case ("scan", Scan()):
            return with_scan(replace(state, pile=job.pile), result, at)
        case ("localize", tuple()):
            search = SearchRecord(
                job.number, job.seed, job.overrides, result, max(0.0, at - job.at)
            )
            return (add_search if job.is_compared else with_detections)(state, search)
        case ("sight", PlateObservation()):
            observations = (*state.observations, result)
            message = StateText.PLATE_SEEN(pose=result.name, count=len(observations))
            return replace(state, observations=observations, message=message)
        case ("balls", BallScan()):
            scans = (*state.ball_scans, result)
            message = VerifyText.SCAN_SEEN(scan=result.name, count=len(scans))
            return replace(state, ball_scans=scans, message=message)
        case ("emptying", Emptying()):
            return replace(state, emptying=result, message=emptying_words(result))
        case ("plan", PlanResult()):
            return with_plan(state, result, job)
        case ("view", PlanResult()):
            return with_view_plan(state, result)
        case ("stir", PlanResult()):
            return with_stir_plan(state, result)
        case ("drop", PlanResult()):
            return with_drop_plan(state, result)
        case ("change", PlanResult()):
            return with_change_plan(state, result)
        case _:
            wrong = type(result).__name__
            return replace(state, message=_failure_message(job, JobText.WRONG_RESULT(kind=wrong)))


def _failure_message(job: Job, why: Message) -> Message:
    return StateText.TASK_FAILED(task=task_message(job.name), why=why)


def continue_cycle(before: State, after: State, entry: Entry) -> Decision:
    """The step that follows automatically when the job of `before` has ended, if requested."""
    job = before.job
    if job is None or job.then is None or after.job is not None:
        return after, ()
    is_ahead = before.phase is Phase.SENDING
    match job.name, after.phase:
        case "scan", Phase.SCANNED if name := missing_view(after):
            return _from_view(name, after, entry, job.then)
        case "scan", Phase.SCANNED:
            return find_parts(after, entry, job.then.find, then=job.then)
        case "localize", Phase.LOCALIZED:
            joints = standing_joints(after.cell, entry.joints)
            if problem := scan_problem(after.cell, after.scan, joints):
                return _ended(replace(after, message=problem)), ()
            if problem := kit_problem(after):
                after = replace(after, message=problem)
                return _without_kit_part(after, entry, job.then, is_ahead=is_ahead)
            return make_plan(after, entry, job.then.plan, then=job.then)
        case "plan", _ if after.disturbed and after.verdict is not None and after.plan is None:
            return take_scan(after, entry, job.then.scan, then=job.then)
        case "localize" | "plan", _ if is_nothing_taken(after) and next_view(after):
            return _from_view(next_view(after), after, entry, job.then)
        case "plan", _ if is_nothing_taken(after) and may_stir(after):
            return _stir(after, entry, job.then)
        case "stir", _ if after.plan is None and may_stir(after):
            # The task itself has failed.
            return _ended(after), ()
        case "stir", _ if after.plan is None and kit_problem(after):
            return _past_views(after, entry, job.then, is_ahead=is_ahead)
        case _ if is_exhausted(after) and not is_ahead:
            return from_next_bin(after, entry, job.then)
        case "scan" | "localize", _:
            return _ended(after), ()
        case _:
            return after, ()


def from_next_bin(state: State, entry: Entry, then: "GoOn") -> Decision:
    """Continue the cycle with the next bin if the chosen one is empty, or end it."""
    if name := next_bin(state):
        emptied = BinChoiceText.EMPTY(name=state.cell.bin.name)
        return _from_bin(name, state, entry, then, why=emptied)
    is_every = all(box.name in state.empty_bins for box in state.cell.bins)
    said = BinChoiceText.ALL_EMPTY() if is_every else None
    return _ended(replace(state, message=all_of((as_message(state.message), said)))), ()


def _from_view(name: str, state: State, entry: Entry, then: "GoOn") -> Decision:
    """Continue the cycle with another view: scan if the arm is there, else plan the path."""
    why = as_message(state.message)
    after, effects = choose_view(state, name)
    carrier, joints = after.cell.scanner.on_arm, standing_joints(after.cell, entry.joints)
    if carrier is None or view_problem(after.cell, joints) is None:
        begun, tasks = take_scan(after, entry, then.scan, then=then)
    elif problem := path_problem(after.cell, carrier, joints):
        return _ended(replace(after, message=all_of((why, problem)))), effects
    else:
        begun, tasks = plan_path(after, entry, seed=then.plan.seed)
    said = all_of((why, as_message(begun.message)))
    return replace(begun, message=said), (*effects, *tasks)


def _stir(state: State, entry: Entry, then: "GoOn") -> Decision:
    """Continue the cycle with a plan to stir the parts, as no part can be picked."""
    begun, effects = plan_stir(state, entry, then.plan.seed, then)
    said = all_of((as_message(state.message), as_message(begun.message)))
    return replace(begun, message=said), effects


def _without_kit_part(state: State, entry: Entry, then: "GoOn", *, is_ahead: bool) -> Decision:
    """Continue the cycle without a part for the kit: next view, stirring, or next bin."""
    if not lacks_of(state):
        return _ended(state), ()
    after = with_nothing_seen(state)
    if name := next_view(after):
        message = all_of((as_message(state.message), next_view_message(after)))
        return _from_view(name, replace(after, message=message), entry, then)
    return _past_views(after, entry, then, is_ahead=is_ahead)


def _past_views(state: State, entry: Entry, then: "GoOn", *, is_ahead: bool) -> Decision:
    """Continue the cycle when no view shows a part for the kit: stirring, or next bin.

    While a plan is sent (`is_ahead`), its bin stays the chosen bin.
    """
    if may_stir(state):
        return _stir(state, entry, then)
    passed = (*state.kit.bins_without, state.cell.bin.name)
    after = replace(state, kit=replace(state.kit, bins_without=passed))
    if not is_ahead and (name := next_bin(after)):
        return _from_bin(name, after, entry, then, why=as_message(state.message))
    return _ended(after), ()


def _from_bin(name: str, state: State, entry: Entry, then: "GoOn", *, why: Message) -> Decision:
    """Continue the cycle with a scan of that bin; end it if the arm must first go to the view."""
    after, effects = choose_bin(state, name)
    joints = standing_joints(after.cell, entry.joints)
    if problem := view_problem(after.cell, joints):
        said = all_of((why, as_message(after.message), problem))
        return _ended(replace(after, message=said)), effects
    # A simulated bin that follows is not empty.
    scan = replace(then.scan, parts=then.scan.parts or TakeScan().parts)
    begun, tasks = take_scan(after, entry, scan, then=replace(then, scan=scan))
    said = all_of((why, as_message(after.message), as_message(begun.message)))
    return replace(begun, message=said), (*effects, *tasks)


def is_exhausted(state: State) -> bool:
    """Whether the last search or planning has shown that the chosen bin of several is empty."""
    return is_nothing_taken(state) and state.cell.bin.name in state.empty_bins


def is_nothing_taken(state: State) -> bool:
    """Whether the last search or planning found nothing to pick."""
    return state.detections == () or (state.verdict is not None and state.plan is None)


def _ended(state: State) -> State:
    message = all_of((as_message(state.message), StateText.ENDS_HERE()))
    return replace(state, message=message)
