"""What a sending brings, what became of the parts, and which are left alone for a while after."""

import math
from dataclasses import replace

from workbench.app.core.commands import LinkEnded, ReportPick
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.state import Avoided, Outcome, Phase, SentFor, State, counted
from workbench.model.cell import Cell
from workbench.model.messages.message import Message, plain
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.plan import Plan, number_in, parts_taken
from workbench.model.release import PartReport, Receipt
from workbench.model.scan import Detection

AVOID_SCANS = 3
"""For so many further scans a part is left alone after its pick has failed."""

AVOID_MINUTES = 10.0

SAME_PLACE = 0.015
"""[m] A part found this near to where a pick has failed is taken for the same one."""

MOST_FAILURES = 3
"""So many failed picks in a row stop the cycle until somebody has looked."""


def with_receipt(state: State, receipt: Receipt) -> State:
    """The state after one more message went out."""
    state = replace(state, receipts=(*state.receipts, receipt))
    steps = () if state.plan is None else state.plan.sequence
    if state.plan is not None and 0 < receipt.waits == state.let + 1 <= len(steps):
        message = f"the robot waits before {step_said(state.plan, receipt.waits)}"
        return replace(state, waits=receipt.waits, message=message)
    if state.let:
        # What is told of a step is who has let it run.
        return state
    step = step_reported(state)
    if state.plan is not None and 0 < step <= len(steps):
        return replace(state, message=f"the robot runs {step_said(state.plan, step)}")
    return replace(state, message=f"{receipt.done} of {receipt.total} messages sent")


def step_reported(state: State) -> int:
    """The step that the robot has reported last, to run or to wait before it, counted from 1.

    0 where it has reported none, as links do that know no steps.
    """
    return max((receipt.step or receipt.waits for receipt in state.receipts), default=0)


def step_said(plan: Plan, number: int) -> str:
    """A step of a plan, counted from 1, for people."""
    return f"step {number} of {len(plan.sequence)}, {plan.sequence[number - 1].words}"


def step_problem(state: State, number: int, now: float) -> str:
    """Why a step may not run now; empty when it may."""
    if state.approval is None or not state.approval.is_stepped:
        return "the plan is not sent step by step"
    if not state.waits:
        return "the robot waits before no step now; wait until it stands"
    if number != state.waits:
        return f"the robot waits before step {state.waits}, not {number!r}: look and decide again"
    if not state.approval.at <= now < state.let_until:
        minutes = state.cell.policy.approval_minutes
        return (
            f"nobody has let a step run for {minutes:g} minutes, or the clock was set back: the "
            "approval holds no longer; stop, and begin with a new scan"
        )
    return ""


def with_step(state: State, number: int, actor: str, at: float) -> State:
    """The state after a person has let a step run, at [s since the epoch]."""
    if state.plan is None:
        return state
    message = f"{step_said(state.plan, number)}, let run by {actor}"
    until = at + state.cell.policy.approval_minutes * 60.0
    return replace(state, waits=0, let=number, let_until=until, message=message)


def after_sending(state: State, ended: LinkEnded, at: float) -> State:
    """The state after the robot link was closed.

    Args:
        state: while something was sent.
        ended: what the link says.
        at: when [s since the epoch].
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
            if not (outcome_problem(state, said) or (said.is_picked and _failed(state, said))):
                state = with_outcome(state, said, ROBOT_LINK, at)
    placed = state.parts_placed + (0 if _goes_on(state.plan) else ended.parts_placed)
    state = replace(state, parts_placed=placed, part_reports=ended.parts, waits=0)
    if ended.fault:
        message = f"fault while sending: {ended.fault}"
        return replace(state, phase=Phase.FAULT, fault=ended.fault, message=message)
    expected = sum(len(plan.arms) for plan in _plans_begun(state) if not _goes_on(plan))
    message = f"cycle finished, {placed} of {counted(expected, 'part')} reported placed"
    for part in ended.parts:
        if part.is_picked is False:
            message += f"; {part.arm} arm failed: {part.why}"
    return escalated(replace(state, phase=Phase.DONE, message=message))


def _failed(state: State, said: ReportPick) -> bool:
    """Whether somebody has said that the pick of the same part has failed."""
    return any(
        outcome.detection == said.detection and not outcome.is_picked for outcome in state.outcomes
    )


def _doubt(placed: Detection) -> Detection:
    """A part that was to be put down, of which nobody knows whether it is there."""
    return replace(placed, score=0.0)


def _was(placed: Detection, found: Detection) -> bool:
    """Whether a part was put down that had been found like this."""
    T = placed.T_world_found
    is_there = T is not None and T.isApprox(found.T_world_part, 1e-6)
    return placed.part == found.part and bool(is_there)


def _goes_on(plan: Plan | None) -> bool:
    """Whether a plan puts its parts where the next one takes them: they are not placed by it."""
    return plan is not None and bool(plan.stations)


def _still_placed(state: State, ended: LinkEnded) -> tuple[Detection, ...]:
    """What was placed before, without what the plan has taken from a station."""
    is_told = bool(ended.parts) and all(part.is_picked is True for part in ended.parts)
    if state.plan is None or ended.fault or not is_told:
        return state.placed
    detections = (state.plan.detections[arm.detection] for arm in state.plan.arms)
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


def outcome_problem(state: State, command: ReportPick) -> str:
    """Why an outcome cannot be taken; empty when it can."""
    sent = sent_for(state)
    if sent is None:
        return "there is no plan whose parts were picked"
    if command.is_picked not in (True, False):
        return f"a pick has succeeded or failed, {command.is_picked!r} is neither"
    taken = [number for number, _ in parts_sent_for(state)]
    if command.detection not in taken:
        parts = ", ".join(f"part-{number + 1}" for number in taken)
        return f"the plan does not take that part; it takes {parts}"
    for outcome in sent.outcomes:
        if (outcome.detection, outcome.is_picked) == (command.detection, command.is_picked):
            return f"{outcome.by} has said so already"
    return ""


def with_outcome(state: State, command: ReportPick, actor: str, at: float) -> State:
    """The state after somebody has said what became of a part.

    A later word replaces an earlier one for the same part.

    Args:
        state: whose plan was sent.
        command: what is said.
        actor: who says it.
        at: when [s since the epoch].
    """
    sent = sent_for(state)
    if sent is None:
        return state
    detection = sent.plans[0].detections[command.detection]
    outcome = Outcome(command.detection, command.is_picked, actor, command.why)
    others = tuple(earlier for earlier in sent.outcomes if earlier.detection != command.detection)
    said_of = {"outcomes": (*others, outcome)}
    if state.plan is None:
        said_of = {"unscanned": replace(sent, outcomes=(*others, outcome))}
    elsewhere = tuple(entry for entry in state.avoided if not _is_at(state.cell, detection, entry))
    said = "was picked" if command.is_picked else "failed"
    why = f": {command.why}" if command.why else ""
    state = replace(
        state,
        failures=0 if command.is_picked else state.failures + 1,
        avoided=elsewhere,
        message=f"part-{command.detection + 1} {said}, says {actor}{why}",
        **said_of,
    )
    if not command.is_picked:
        state = replace(
            state,
            placed=tuple(
                _doubt(placed_part) if _was(placed_part, detection) else placed_part
                for placed_part in state.placed
            ),
        )
        x, y, z = (state.cell.bin.T_world_bin.inverse() * detection.T_world_part).translation
        place = (float(x), float(y), float(z))
        until = at + AVOID_MINUTES * 60.0
        mark = Avoided(detection.part, place, until, AVOID_SCANS, command.why)
        state = replace(state, avoided=(*elsewhere, mark))
    return escalated(state)


def parts_sent_for(state: State) -> tuple[tuple[int, str], ...]:
    """Each part of every plan that was sent, by its index in the first one, and the arm for it."""
    sent = sent_for(state)
    if sent is None:
        return ()
    return tuple(
        (number, arm.arm)
        for plan in sent.plans
        for number, arm in zip(parts_taken(sent.plans[0], plan), plan.arms, strict=True)
    )


def sent_for(state: State) -> SentFor | None:
    """The plans of whose parts people can say what became of them; None where nothing was sent."""
    return state.unscanned if state.plan is None else SentFor(_plans_begun(state), state.outcomes)


def before_a_scan(state: State) -> State:
    """The state that remembers what was sent when its plan goes and no scan has come since."""
    if state.phase not in (Phase.DONE, Phase.FAULT):
        return state
    return replace(state, unscanned=sent_for(state))


def _plans_begun(state: State) -> tuple[Plan, ...]:
    """The plans that were sent, the one on its way among them."""
    return state.plans[: len(state.sent_before) + 1]


def _in_row(state: State, part: PartReport) -> int:
    """The part's index in the first plan of the row."""
    if state.plan is None or not state.sent_before:
        return part.detection
    return number_in(state.plans[0], state.plan.detections[part.detection])


def escalated(state: State) -> State:
    """The state, stopped with a fault when a cycle ends and too many picks in a row have failed."""
    if state.phase is not Phase.DONE or state.failures < MOST_FAILURES:
        return state
    fault = (
        f"{state.failures} picks in a row have failed; look at bin, grippers and grasps before "
        "going on"
    )
    return replace(state, phase=Phase.FAULT, fault=fault, message=fault)


def after_one_more_scan(avoided: tuple[Avoided, ...], at: float) -> tuple[Avoided, ...]:
    """What is still avoided in a new scan taken at [s since the epoch]."""
    return tuple(
        replace(entry, scans=entry.scans - 1)
        for entry in avoided
        if entry.scans > 0 and at < entry.until
    )


def avoided_parts(state: State, at: float) -> tuple[tuple[int, Message], ...]:
    """Indices of the parts found that are left alone at [s since the epoch], and why each."""
    found: list[tuple[int, Message]] = []
    for number, detection in enumerate(state.detections or ()):
        for entry in state.avoided:
            if at < entry.until and _is_at(state.cell, detection, entry):
                why = VerdictNote.PICK_FAILED()
                if entry.why:
                    why = VerdictNote.PICK_FAILED_SINCE(why=plain(entry.why))
                found.append((number, why))
                break
    return tuple(found)


def _is_at(cell: Cell, detection: Detection, avoided: Avoided) -> bool:
    p_bin = (cell.bin.T_world_bin.inverse() * detection.T_world_part).translation
    return detection.part == avoided.part and math.dist(p_bin, avoided.p_bin) < SAME_PLACE
