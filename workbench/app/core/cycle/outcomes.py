"""Results of a sending: outcomes of the picks, and which parts are avoided for a while."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import ClassVar

from workbench.app.core.cell.kits import lacks_message, with_kit_part, without_kit_part
from workbench.app.core.command import SAFE, Asked, Command, Decision, Entry, Right, refuse
from workbench.app.core.cycle.empty_hand import with_hand_used
from workbench.app.core.hands import arms_that_may_hold
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import Avoided, Outcome, SendingEnd
from workbench.app.core.state import (
    Phase,
    ScanState,
    State,
    before_a_scan,
    begin_stage,
    is_remembered,
    plans_begun,
    sent_for,
)
from workbench.app.core.value_checks import check_says
from workbench.model.cell import Cell
from workbench.model.derived.by_bin import bin_around
from workbench.model.derived.row_parts import number_in, parts_taken
from workbench.model.digest import LATER
from workbench.model.errors import CommandRefused
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import FoundPart, Message, all_of
from workbench.model.messages.refusals import Refusal
from workbench.model.messages.states import NextText, StateText
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.plan import Plan
from workbench.model.release import PartReport, PickResult, result_of
from workbench.model.scan import Detection

AVOID_SCANS = 3
"""Number of further scans during which a part is avoided after its pick has failed."""


AVOID_MINUTES = 10.0

SAME_PLACE = 0.015
"""[m] A part found this near to the place of a failed pick counts as the same part."""


MOST_FAILURES = 3
"""Failed picks in a row that stop the cycle until somebody has looked."""


SAID: Mapping[PickResult, StateText] = {
    PickResult.PICKED: StateText.PICKED,
    PickResult.FAILED: StateText.PICK_FAILED,
    PickResult.DROPPED: StateText.PART_DROPPED,
    PickResult.DOUBLE: StateText.TWO_PARTS,
}


@dataclass(frozen=True, slots=True, eq=False)
class ReportPick(Command):
    """What became of a part of the plan, as a person saw it or a gripper felt it.

    `detection` is the part's index in the plan, of a row in the first one; `why` is what is known
    about a failure.  `result` says more than `is_picked`.
    """

    right: ClassVar[Right] = Right(
        CommandText.REPORT_PICK,
        frozenset({Phase.SENDING, Phase.DONE, Phase.FAULT}),
        NextText.NOTHING_SENT,
        by_anybody=True,
        without_control=True,
    )

    detection: int
    is_picked: bool
    why: Message | str = ""
    result: PickResult | None = field(default_factory=lambda: None, metadata=LATER)

    @property
    def became(self) -> PickResult:
        """What became of the part."""
        return result_of(self.is_picked, self.result)

    @classmethod
    def is_in_phase(cls, state: State) -> bool:
        # Its plan is gone, and no scan shows the bin as it is now.
        is_unscanned = state.phase is Phase.IDLE and state.unscanned is not None
        return is_unscanned or state.phase in cls.right.phases

    def check(self, state: State, asked: Asked) -> None:
        check_says("why", self.why)
        refuse(outcome_problem(state, self))

    def apply(self, state: State, entry: Entry) -> Decision:
        return _in_kit(with_outcome(state, self, entry.actor, entry.at), self), ()


@dataclass(frozen=True, slots=True, eq=False)
class ForgetAvoided(Command):
    """No part is avoided any more because its pick has failed."""

    right: ClassVar[Right] = Right(CommandText.FORGET_AVOIDED, SAFE)

    def check(self, state: State, asked: Asked) -> None:
        if not state.avoided:
            raise CommandRefused(Refusal.NOTHING_AVOIDED())

    def apply(self, state: State, entry: Entry) -> Decision:
        return replace(state, avoided=(), message=StateText.NOTHING_AVOIDED()), ()


@dataclass(frozen=True, slots=True, eq=False)
class AcknowledgeFault(Command):
    """A person has seen the fault and cleared the cell."""

    right: ClassVar[Right] = Right(
        CommandText.ACKNOWLEDGE_FAULT, frozenset({Phase.FAULT}), NextText.NO_FAULT
    )

    def apply(self, state: State, entry: Entry) -> Decision:
        # Nobody knows how the bin looks after a fault: only a new scan can tell.
        text = StateText.FAULT_HANDS if arms_that_may_hold(state) else StateText.FAULT_ACKNOWLEDGED
        message = text(person=entry.actor)
        after = replace(before_a_scan(state), failures=0, earlier=None)
        return begin_stage(after, ScanState, message=message), ()


def after_sending(state: State, ended: SendingEnd, at: float) -> State:
    """The state after the robot link was closed.

    Args:
        state: while something was sent.
        ended: the report of the link.
        at: time of the end [s since the epoch].
    """
    # After a fault nobody knows: no other part is put where one may lie, and none onto it.
    placed = ended.placed or ()
    if ended.fault:
        placed = tuple(map(_doubt, placed))
    state = replace(state, placed=(*_still_placed(state, ended), *placed))
    for part in ended.parts:
        if part.is_picked is not None:
            said = ReportPick(_in_row(state, part), part.is_picked, part.why)
            # What somebody has reported meanwhile is not counted a second time, and a person who
            # saw the part fall has seen more than the gripper felt.
            if not (outcome_problem(state, said) or _is_doubted(state, said.detection)):
                state = with_outcome(state, said, ROBOT_LINK, at)
    state = _with_doubts(state)
    placed = state.parts_placed + (0 if _goes_on(state.plan) else ended.parts_placed)
    state = replace(state, parts_placed=placed, part_reports=ended.parts, waits=0)
    if not ended.fault and not _goes_on(state.plan):
        state = _with_placed_in_kit(state, ended)
    if ended.fault:
        message = StateText.FAULT_WHILE_SENDING(fault=ended.fault)
        return replace(state, phase=Phase.FAULT, fault=ended.fault, message=message)
    state = replace(state, is_over=True)
    if state.plan is not None and (state.plan.is_stir_plan or state.plan.is_drop_plan):
        return with_hand_used(state, state.plan)
    expected = sum(len(plan.picks) for plan in plans_begun(state) if not _goes_on(plan))
    failed = [
        StateText.ARM_FAILED(arm=part.arm, why=part.why)
        for part in ended.parts
        if part.is_picked is False
    ]
    finished = _finished_message(state, placed, expected)
    message = all_of((finished, *failed, lacks_message(state)))
    return stop_after_failures(replace(state, phase=Phase.DONE, message=message))


def _finished_message(state: State, placed: int, expected: int) -> Message:
    """The number of parts placed; or that the scanner is at its view, or its arm at home."""
    carrier = state.cell.scanner.on_arm
    if carrier is None or state.plan is None or not state.plan.is_view_plan:
        return StateText.CYCLE_FINISHED(count=placed, total=expected)
    if carrier.leads_home(state.plan.arms[0].legs[0].q):
        return StateText.REACHED_HOME(arm=carrier.arm)
    return StateText.REACHED_VIEW(arm=carrier.arm, view=carrier.view.name)


def _with_placed_in_kit(state: State, ended: SendingEnd) -> State:
    """The state with the placed parts of a plan in the kit.

    Without a report on each part, all count as placed if the number of placed parts agrees.
    """
    if state.plan is None or not state.plan.picks:
        return state
    first, arms = state.plans[0], state.plan.arms
    reported = {part.detection: part.is_picked for part in ended.parts}
    are_all_placed = ended.parts_placed == len(arms)
    for number, arm in zip(parts_taken(first, state.plan), arms, strict=True):
        is_picked = reported.get(arm.detection)
        came = are_all_placed if is_picked is None else is_picked
        if came and not _has_failed(state, number):
            state = with_kit_part(state, first.digest, number, first.detections[number].part)
    return state


def _in_kit(state: State, command: ReportPick) -> State:
    """The state after a report on a part; a part in motion counts only when it is placed."""
    sent = sent_for(state)
    if sent is None:
        return state
    first = sent.plans[0]
    if not command.is_picked:
        return without_kit_part(state, first.digest, command.detection)
    if state.phase is Phase.SENDING:
        return state
    part = first.detections[command.detection].part
    return with_kit_part(state, first.digest, command.detection, part)


def _has_failed(state: State, detection: int) -> bool:
    """Whether a report states that the part was not placed."""
    return any(
        outcome.detection == detection and not outcome.is_picked for outcome in state.outcomes
    )


def _is_doubted(state: State, detection: int) -> bool:
    """Whether a report states anything other than a success for the part."""
    return any(
        outcome.detection == detection and outcome.became is not PickResult.PICKED
        for outcome in state.outcomes
    )


def _with_doubts(state: State) -> State:
    """The state in which the place of each part is in doubt that was reported as not picked."""
    sent = sent_for(state)
    doubted = [
        sent.plans[0].detections[outcome.detection]
        for outcome in (() if sent is None else sent.outcomes)
        if sent is not None and outcome.became is not PickResult.PICKED
    ]
    placed = tuple(
        _doubt(part) if any(_was(part, found) for found in doubted) else part
        for part in state.placed
    )
    return replace(state, placed=placed)


def _doubt(placed: Detection) -> Detection:
    """A part that may or may not be at its place."""
    return replace(placed, score=0.0)


def _was(placed: Detection, found: Detection) -> bool:
    """Whether a part was put down that had been found like this."""
    T = placed.T_world_found
    is_there = T is not None and T.isApprox(found.T_world_part, 1e-6)
    return placed.part == found.part and bool(is_there)


def _goes_on(plan: Plan | None) -> bool:
    """Whether a plan puts its parts where the next one takes them: they are not placed by it."""
    return plan is not None and bool(plan.stations)


def _still_placed(state: State, ended: SendingEnd) -> tuple[Detection, ...]:
    """What was placed before, without what the plan has taken from a station."""
    is_each_picked = bool(ended.parts) and all(part.is_picked is True for part in ended.parts)
    if state.plan is None or ended.fault or not is_each_picked:
        return state.placed
    detections = (state.plan.detections[arm.detection] for arm in state.plan.picks)
    taken = [
        detection.T_world_part.translation
        for detection in detections
        if detection.T_world_found is not None
    ]
    return tuple(
        detection
        for detection in state.placed
        if all(math.dist(detection.T_world_part.translation, p) >= SAME_PLACE for p in taken)
    )


def outcome_problem(state: State, command: ReportPick) -> Message | None:
    """Why an outcome cannot be taken; None when it can."""
    sent = sent_for(state)
    if sent is None:
        return Refusal.NOTHING_PICKED()
    if command.is_picked not in (True, False):
        return Refusal.NO_OUTCOME(value=repr(command.is_picked))
    if command.became.is_picked != command.is_picked:
        return Refusal.OTHER_RESULT(result=command.became, is_picked=str(command.is_picked).lower())
    taken = [number for number, _ in parts_sent_for(state)]
    if command.detection not in taken:
        return Refusal.OTHER_PARTS(parts=tuple(map(FoundPart, taken)))
    has_stopped = state.phase is not Phase.SENDING and not sent.is_over
    for outcome in sent.outcomes:
        if has_stopped and outcome.is_early and outcome.became is PickResult.PICKED:
            # It may have been in the hand; now somebody states that it is there no more.
            continue
        if (outcome.detection, outcome.became) == (command.detection, command.became):
            return Refusal.SAID_ALREADY(person=outcome.by)
    return None


def with_outcome(state: State, command: ReportPick, actor: str, at: float) -> State:
    """The state after a report on a part.

    A later report replaces an earlier one for the same part.

    Args:
        state: the state, whose plan was sent.
        command: the report.
        actor: who reports.
        at: time of the report [s since the epoch].
    """
    sent = sent_for(state)
    if sent is None:
        return state
    detection = sent.plans[0].detections[command.detection]
    said = command.detection, command.is_picked, actor, command.why, command.result
    outcome = Outcome(*said, is_early=state.phase is Phase.SENDING)
    others = tuple(earlier for earlier in sent.outcomes if earlier.detection != command.detection)
    said_of = {"outcomes": (*others, outcome)}
    if is_remembered(state):
        said_of = {"unscanned": replace(sent, outcomes=(*others, outcome))}
    is_placed = command.is_picked and not sent.plans[-1].stations
    elsewhere = tuple(entry for entry in state.avoided if not _is_at(state.cell, detection, entry))
    state = replace(
        state,
        failures=0 if is_placed else state.failures + (not command.is_picked),
        avoided=elsewhere,
        message=_outcome_message(command, actor),
        **said_of,
    )
    state = _with_doubts(state)
    if not command.is_picked:
        # Another bin may have been chosen since.
        box = bin_around(state.cell, detection.T_world_part.translation)
        x, y, z = box.T_world_bin.actInv(detection.T_world_part.translation)
        place = (float(x), float(y), float(z))
        until = at + AVOID_MINUTES * 60.0
        mark = Avoided(detection.part, place, until, AVOID_SCANS, command.why, box.name)
        state = replace(state, avoided=(*elsewhere, mark))
    return stop_after_failures(state)


def _outcome_message(command: ReportPick, actor: str) -> Message:
    said = SAID[command.became](part=FoundPart(command.detection), person=actor)
    return StateText.SINCE(what=said, why=command.why) if command.why else said


def parts_sent_for(state: State) -> tuple[tuple[int, str], ...]:
    """Each part of every plan that was sent, by its index in the first one, and the arm for it."""
    sent = sent_for(state)
    if sent is None:
        return ()
    return tuple(
        (number, arm.arm)
        for plan in sent.plans
        for number, arm in zip(parts_taken(sent.plans[0], plan), plan.picks, strict=True)
    )


def _in_row(state: State, part: PartReport) -> int:
    """The part's index in the first plan of the row."""
    if state.plan is None or not state.sent_before:
        return part.detection
    return number_in(state.plans[0], state.plan.detections[part.detection])


def stop_after_failures(state: State) -> State:
    """The state, stopped with a fault when a cycle ends and too many picks in a row have failed."""
    if state.phase is not Phase.DONE or state.failures < MOST_FAILURES:
        return state
    fault = StateText.PICKS_FAILED(count=state.failures)
    return replace(state, phase=Phase.FAULT, fault=fault, message=fault)


def avoided_parts(state: State, at: float) -> tuple[tuple[int, Message], ...]:
    """Indices of the detections to avoid at a time [s since the epoch], with the reasons."""
    found: list[tuple[int, Message]] = []
    for number, detection in enumerate(state.detections or ()):
        for entry in state.avoided:
            if at < entry.until and _is_at(state.cell, detection, entry):
                why = VerdictNote.PICK_FAILED()
                if entry.why:
                    why = VerdictNote.PICK_FAILED_SINCE(why=entry.why)
                found.append((number, why))
                break
    return tuple(found)


def _is_at(cell: Cell, detection: Detection, avoided: Avoided) -> bool:
    p_world = detection.T_world_part.translation
    box = bin_around(cell, p_world)
    is_there = math.dist(box.T_world_bin.actInv(p_world), avoided.p_bin) < SAME_PLACE
    return (detection.part, box.name) == (avoided.part, avoided.bin) and is_there
