"""Tasks of the worker: how they end, or are cancelled."""

from dataclasses import dataclass, replace
from typing import Any, ClassVar

from workbench.app.core.cell.changes import change_whole
from workbench.app.core.cell.making import with_made
from workbench.app.core.command import EVERY_PHASE, Command, Decision, Entry, Right
from workbench.app.core.cycle.ahead import discard_ahead, take_result_ahead
from workbench.app.core.cycle.arm_scanner import plate_problem, scan_problem, standing_joints
from workbench.app.core.cycle.correcting import CORRECT, with_corrected
from workbench.app.core.cycle.results import continue_cycle, with_result
from workbench.app.core.effects import StopJob
from workbench.app.core.state import Phase, State
from workbench.model.calibration import BallScan, PlateObservation
from workbench.model.cell import Tool
from workbench.model.errors import InputError, WorkbenchError
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import AheadText, StateText, task_message
from workbench.model.part import Part
from workbench.model.plan import PlanResult
from workbench.model.prediction import Emptying
from workbench.model.scan import Detection, Scan

TaskResult = (
    Scan
    | tuple[Detection, ...]
    | PlanResult
    | PlateObservation
    | BallScan
    | Part
    | Tool
    | Emptying
    | WorkbenchError
)
"""What a task brings, or the error that ended it."""


@dataclass(frozen=True, slots=True, eq=False)
class JobEnded(Command):
    """The worker finished job `number`."""

    right: ClassVar[Right] = Right(
        CommandText.JOB_ENDED, EVERY_PHASE, beside_job=True, by_machine=True
    )

    number: int
    result: TaskResult

    def apply(self, state: State, entry: Entry) -> Decision:
        match self.result:
            case Part() as part if state.job is not None and state.job.name == CORRECT:
                return with_corrected(state, self.number, part, entry)
            case Part() | Tool() as made:
                return change_whole(state, lambda whole: with_made(whole, self.number, made))
            case _ if state.phase is Phase.SENDING:
                return take_result_ahead(state, self.number, self.result, entry)
            case _:
                result = _still_good(state, self.result, entry)
                after = with_result(state, self.number, result, entry.at)
                return continue_cycle(state, after, entry)


def _still_good(state: State, result: Any, entry: Entry) -> Any:
    """A result of the worker; an error instead of a scan during which its arm has moved."""
    carrier = state.cell.scanner.on_arm
    match result:
        case Scan():
            problem = scan_problem(state.cell, result, standing_joints(state.cell, entry.joints))
        case BallScan() if carrier is not None and len(result.q) == len(carrier.joints):
            problem = plate_problem(state.cell, carrier.arm, result.q, entry.joints)
        case PlateObservation():
            problem = plate_problem(state.cell, result.arm, result.q, entry.joints)
        case _:
            return result
    return result if problem is None else InputError(problem)


@dataclass(frozen=True, slots=True, eq=False)
class CancelJob(Command):
    """End the running task."""

    right: ClassVar[Right] = Right(CommandText.CANCEL_JOB, EVERY_PHASE, beside_job=True)

    @classmethod
    def obstacle(cls, state: State) -> Message | None:
        return Refusal.NO_TASK() if state.job is None and state.ahead is None else None

    def apply(self, state: State, entry: Entry) -> Decision:
        if state.ahead is not None:
            return discard_ahead(state, AheadText.CANCELLED(person=entry.actor))
        if state.job is None:
            return state, ()
        # The job leaves the state at once; whatever it still brings is recorded and not used.
        message = StateText.CANCELLED_BY(task=task_message(state.job.name), person=entry.actor)
        return replace(state, job=None, message=message), (StopJob(state.job.number),)
