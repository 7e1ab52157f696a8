"""After a grip that closed on nothing: whether other parts of the same scan can be planned for.

The robot must report the miss, and nothing else may be in doubt.  Then only the missed part, and
parts onto which it may have fallen, may have moved.  These become obstacles.
"""

from dataclasses import replace

from workbench.app.core.cell.kits import kit_problem
from workbench.app.core.people import ROBOT_LINK
from workbench.app.core.picks import SendingEnd
from workbench.app.core.state import Phase, PlanState, State, begin_stage
from workbench.model.messages.message import all_of, as_message
from workbench.model.messages.states import StateText
from workbench.model.release import PickResult


def is_sure(state: State, ended: SendingEnd) -> bool:
    """Whether the robot reports nothing wrong with the plan except a miss.

    Args:
        state: while the plan was sent, whose end it is.
        ended: what the link reports of the end.
    """
    plan, cell = state.plan, state.cell
    if plan is None or not plan.picks or ended.fault or ended.row_ends or state.stopped_by:
        return False
    # Parts from outside, and scans of a scanner on an arm, belong to one moment.
    is_scanned = state.scan is not None and state.scene_digest == state.scan.digest
    if not is_scanned or cell.scanner.on_arm is not None or cell.policy.pair_gap <= 0:
        return False
    if cell.controller.motion.sends_poses or any(each.stations for each in state.plans):
        return False
    reports = {part.detection: part for part in ended.parts}
    if sorted(reports) != sorted(arm.detection for arm in plan.picks):
        return False
    is_each_known = all(part.is_picked or part.is_missed for part in reports.values())
    return is_each_known and any(part.is_missed for part in reports.values())


def with_end(state: State, after: State, ended: SendingEnd) -> State:
    """The state after a sending, which states which parts a miss may have moved.

    Args:
        state: while the plan was sent, whose end it is.
        after: that, as its end leaves it.
        ended: what the link reports of the end.
    """
    if after.phase is not Phase.DONE or ended.may_have_moved is None or not is_sure(state, ended):
        return after
    after = replace(after, may_have_moved=ended.may_have_moved)
    if not is_rest_known(after):
        return after
    count = len(with_rest(after).detections or ())
    message = all_of((as_message(after.message), StateText.REST_KNOWN(count=count)))
    return replace(after, message=message)


def is_rest_known(state: State) -> bool:
    """Whether a plan can be made without a new scan for parts that are left after a miss."""
    if state.phase is not Phase.DONE or state.may_have_moved is None or state.stopped_by:
        return False
    # A person who reports anything but a pick has seen more than the gripper felt.
    for outcome in state.outcomes:
        is_reported = outcome.became is PickResult.FAILED and outcome.by == ROBOT_LINK
        if outcome.became is not PickResult.PICKED and not is_reported:
            return False
    missed = [part.detection for part in state.part_reports if part.is_missed]
    failed = sum(outcome.became is PickResult.FAILED for outcome in state.outcomes)
    rest = with_rest(state)
    return failed == len(missed) and bool(rest.detections) and kit_problem(rest) is None


def with_rest(state: State) -> State:
    """The state with the parts that lie as scanned; the others become obstacles."""
    if state.plan is None or state.may_have_moved is None:
        return state
    picked = {part.detection for part in state.part_reports if part.is_picked}
    moved = set(state.may_have_moved) - picked
    parts = state.plan.detections
    after = replace(
        state,
        detections=tuple(part for number, part in enumerate(parts) if number not in moved | picked),
        disturbed=(*state.disturbed, *(parts[number] for number in sorted(moved))),
        # An undo would bring them back.
        parts_before=(),
    )
    return begin_stage(after, PlanState, phase=Phase.LOCALIZED)
