"""What must hold before a plan goes out, besides digests that agree.

It was watched to its end, enough people have approved it, its threshold is still the one wanted,
and the robot stands where it starts.  Pure functions; `rules` and the page ask them.
"""

import math
import unicodedata
from collections.abc import Mapping, Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np

from workbench.app.core.commands import Started
from workbench.app.core.people import NOBODY
from workbench.app.core.rights import changes_said
from workbench.app.core.state import Phase, State, counted
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.plan import Plan
from workbench.model.release import Approval, Manner, Vote

LEAST_MOVED = 0.001
"""[m] So far the robot may be from where a plan starts also where no margin is kept: it rounds."""

NOT_PLAYED = "the plan has not been played to its end; play it first"
"""What is to be done next with a new plan; nothing is wrong."""

SAME_THRESHOLD = 0.0005
"""[m] Thresholds are typed in whole millimetres."""


def is_same_person(first: str, second: str) -> bool:
    """Whether two names are one: case, spaces and ways to write a letter make no other person."""
    return _plain(first) == _plain(second)


def _plain(name: str) -> str:
    return " ".join(unicodedata.normalize("NFKC", name).casefold().split())


def standing_votes(state: State, now: float) -> tuple[Vote, ...]:
    """The votes for the current plan that have not lapsed at `now` [s since the epoch]."""
    valid = state.cell.policy.approval_minutes * 60.0
    digest = state.plan.digest if state.plan is not None else ""
    return tuple(
        vote
        for vote in state.votes
        if vote.plan_digest == digest and vote.at <= now < vote.at + valid
    )


def votes_of_others(state: State, actor: str, now: float, manner: Manner) -> tuple[Vote, ...]:
    """Those of the standing votes that count beside the vote of `actor`, the latest last.

    Votes for another manner of sending (speed share, whether step by step) do not.
    """
    others = [
        vote
        for vote in standing_votes(state, now)
        if not is_same_person(vote.actor, actor) and vote.manner == manner
    ]
    wanted = state.cell.approvers - 1
    return tuple(others[-wanted:]) if wanted else ()


def without_approval(state: State) -> State:
    """The state without approval: who asks for something newer takes back every vote given."""
    phase = Phase.PLANNED if state.phase is Phase.APPROVED else state.phase
    return replace(state, phase=phase, approval=None, votes=())


def opened_again(state: State) -> State:
    """The state of a session that a bench goes on with, which may be a copy of it elsewhere.

    Nobody there has seen the plan or let it out: what was said before was said to another bench.
    """
    had, message = state.votes or state.approval or state.watched, state.message
    if had and state.phase in (Phase.PLANNED, Phase.APPROVED):
        message = "the session was opened again: previews and approvals before that do not count"
    return replace(without_approval(state), watched=(), told=(), message=message)


def started(state: State, start: Started) -> State:
    """The state after a start: what had changed by then stays until it is acknowledged."""
    changed = tuple(dict.fromkeys((*state.changed, *start.changes)))
    since = state.changed_since or start.since
    after = replace(state, ran=start.ran, changed=changed, changed_since=since if changed else "")
    return replace(after, message=changes_said(after)) if start.changes else after


def changes_problem(state: State, ran: str) -> str:
    """Why changes cannot be acknowledged by who has seen the inventory `ran`; else empty."""
    if not state.changed or state.ran is None:
        return "nothing has changed that nobody has acknowledged"
    if state.ran.digest != ran:
        return (
            f"what runs now has the digest {state.ran.digest[:12]}, not {ran[:12]!r}: look at "
            "the current changes and decide again"
        )
    return ""


def acknowledged(state: State, actor: str) -> State:
    """The state after somebody has acknowledged what has changed."""
    message = f"{actor} has acknowledged what has changed since {state.changed_since}"
    return replace(state, changed=(), changed_since="", message=message)


def lacks_people(cell: Cell, approval: Approval) -> str:
    """Why an approval is by too few people for the cell; empty when it is not."""
    different = {_plain(name) for name in approval.people}
    if len(different) >= cell.approvers:
        return ""
    return (
        f"the cell wants {cell.approvers} different people to approve a plan, "
        f"this one has {', '.join(approval.people)}"
    )


def said_already(state: State, actor: str, now: float, manner: Manner) -> str:
    """Why a person need not approve again while somebody else's vote is missing; else empty."""
    wanted = state.cell.approvers
    mine = any(
        is_same_person(vote.actor, actor) and vote.manner == manner
        for vote in standing_votes(state, now)
    )
    if not mine or len(votes_of_others(state, actor, now, manner)) + 1 >= wanted:
        return ""
    return f"{actor} has approved already; {wanted} different people have to"


NOT_PLAYED = "the plan has not been played to its end; play it first"


def unwatched(state: State, actor: str) -> str:
    """Why a person has to see the plan before approving it; empty when that has happened.

    What was played in a browser without a login was played before whoever was there.
    """
    seen = any(is_same_person(name, actor) or name == NOBODY for name in state.watched)
    return "" if seen else NOT_PLAYED


def has_seen(state: State, actor: str) -> bool:
    """Whether a page has drawn the plan to its end before a person; a program's word is none."""
    drawn = [name for name in state.watched if name not in state.told]
    return any(is_same_person(name, actor) or name == NOBODY for name in drawn)


def other_row(state: State, named: tuple[str, ...]) -> str:
    """Why the plans named are not those that follow the plan; empty when they are.

    Who has seen or read one row has said nothing about another one.
    """
    have = tuple(proven_plan.plan.digest for proven_plan in state.row)
    if named == have:
        return ""
    there = ", ".join(digest[:12] for digest in have) or "none"
    return (
        f"the plans that follow this one are {there}, not those that were named: look at the "
        "current row and decide again"
    )


def unapproved_row(state: State, approval: Approval) -> str:
    """Why an approval does not cover exactly the plans that follow; empty when it does."""
    if approval.row == tuple(
        (proven_plan.plan.digest, proven_plan.proof.digest) for proven_plan in state.row
    ):
        return ""
    return "the approval is for another row of plans; have this one approved"


def left_on_station(plans: Sequence[Plan]) -> str:
    """Why plans are no whole row, as a part would stay on a station; empty when none does."""
    for number, plan in enumerate(plans):
        after = plans[number + 1] if number + 1 < len(plans) else None
        taken = [] if after is None else [after.detections[arm.detection] for arm in after.arms]
        if plan.stations and sum(detection.T_world_found is not None for detection in taken) < len(
            plan.stations
        ):
            return (
                f"plan {number + 1} puts a part on station {plan.stations[0]}, and no plan that "
                "follows takes it from there"
            )
    return ""


def untold(state: State) -> str:
    """Why nobody could know, between two plans of the row, how it stands; else empty."""
    motion = state.cell.controller.motion
    if not state.row or motion.reports_progress:
        return ""
    return (
        f"the robot link {motion.link} does not tell what became of each part, so one plan can be "
        "sent at a time; shorten the row to one plan"
    )


def length_problem(state: State, picks: int) -> str:
    """Why a row cannot be made so long; empty when it can."""
    most = 1 + len(state.row) + len(state.left_out)
    if not 1 <= picks <= most:
        return f"the row can have 1 to {most} picks, not {picks}"
    if picks == 1 + len(state.row):
        return f"the row has {counted(picks, 'pick')} already"
    every = (state.plan, *(proven_plan.plan for proven_plan in (*state.row, *state.left_out)))
    return left_on_station([plan for plan in every[:picks] if plan is not None])


def shortened(state: State, picks: int, actor: str) -> State:
    """The state in which a person wants a row of so many plans: what was approved is void.

    Who has seen all of a row has seen a shorter one, too.
    """
    every = (*state.row, *state.left_out)
    is_shorter = picks <= len(state.row)
    return replace(
        without_approval(state),
        row=every[: picks - 1],
        left_out=every[picks - 1 :],
        watched=state.watched if is_shorter else (),
        told=state.told if is_shorter else (),
        message=f"{actor} wants {counted(picks, 'pick')} of {1 + len(every)} in this row",
    )


def with_watched(state: State, actor: str, *, is_told: bool) -> State:
    """The state after the plan was played to its end before somebody, or a program said so."""
    reported, watched = state.told, state.watched
    if actor not in watched:
        watched, reported = (*watched, actor), (*reported, actor) if is_told else reported
    elif not is_told:
        reported = tuple(name for name in reported if name != actor)
    message = "the plan was played to its end"
    if is_told:
        message = f"a program says that the plan was played to its end before {actor}"
    return replace(state, watched=watched, told=reported, message=message)


def stale_because(state: State, plan: Plan, joints: Mapping[str, float]) -> str:
    """What has made a plan stale, and by how much; empty when it still stands.

    Another scan or cell is not looked for: with that the plan would be gone.
    """
    return (
        other_threshold(state) or other_pallets(state, plan) or moved_away(state.cell, plan, joints)
    )


def other_pallets(state: State, plan: Plan) -> str:
    """Why a pallet is not as a plan counts on; empty when every part that it knows lies there."""
    for box in plan.obstacles:
        T = box.T_world_put
        if T is not None and not any(
            detection.part == box.part
            and detection.score > 0
            and detection.T_world_part.isApprox(T, 1e-6)
            for detection in state.placed
        ):
            return (
                "a part that the plan counts on does not lie on the pallet any more, or nobody "
                "knows whether it does; make a new plan"
            )
    return ""


def other_threshold(state: State) -> str:
    """Why the threshold wanted is no longer that of the plan; empty when it is."""
    planned, wanted = state.planned_threshold, state.wanted_threshold
    if planned is None or wanted is None or abs(planned - wanted) < SAME_THRESHOLD:
        return ""
    return (
        f"the plan was made with a threshold of {planned * 1000:.0f} mm, "
        f"now it is {wanted * 1000:.0f} mm; make a new plan"
    )


def moved_away(cell: Cell, plan: Plan, joints: Mapping[str, float]) -> str:
    """By how much the robot does not stand where the plan starts; empty when it does.

    No point of an arm may be further from there than the policy's margin, which the plan's start
    keeps to everything: on its way there the robot touches nothing.  Joints that are not reported
    are not compared.

    Args:
        cell: whose arms; those without a part in the plan have to be at home.
        plan: that would be sent.
        joints: name -> [rad], as the controller reports.
    """
    allowed = max(cell.policy.margin, LEAST_MOVED)
    for arm in cell.arms:
        q, levers = start_of(cell, plan, arm.name), _levers(cell, arm)
        shift, worst, where = 0.0, 0.0, ""
        for axis, place in enumerate(arm.axis_order):
            reported = joints.get(arm.joints[place])
            if reported is None:
                continue
            name = f"axis {axis + 1} of the {arm.name} arm"
            if not math.isfinite(reported):
                return f"nobody knows where the robot stands: {name} is reported at {reported}"
            off = float(abs(reported - q[place]))
            shift += off * levers[place]
            if off > worst:
                worst, where = off, name
        if shift > allowed:
            return (
                f"the robot has moved: {where} stands {np.rad2deg(worst):.2f} degrees from where "
                f"the plan starts, so that a point of the arm may be {shift * 1000:.1f} mm away; "
                f"{allowed * 1000:g} are allowed (margin_mm); bring it back"
            )
    return ""


@lru_cache(maxsize=16)
def _levers(cell: Cell, arm: Arm) -> tuple[float, ...]:
    """How far each joint of an arm, in chain order, moves any point at most [m/rad, m/m]."""
    tools = {other.flange: other.tool.reach for other in cell.arms}
    joints = [cell.robot.joint(name) for name in arm.joints]
    return tuple(
        1.0 if joint.kind == "prismatic" else cell.robot.reach(joint.child, tools)
        for joint in joints
    )


def start_of(cell: Cell, plan: Plan, arm: str) -> Floats:
    """The configuration (n,) [rad] in which an arm has to stand when the plan begins."""
    for step in plan.sequence:
        for name, leg in step.runs:
            if name == arm:
                return np.asarray(plan.arm(arm).leg(leg).q[0])
    return cell.arm(arm).home
