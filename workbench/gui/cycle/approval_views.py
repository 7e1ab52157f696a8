"""What the page says about an approval: what a person lets out, who has, and what is in the way."""

from collections.abc import Mapping, Sequence

from workbench.app.core.cycle.approval import standing_votes
from workbench.app.core.cycle.standing import moved_away
from workbench.app.core.hands import arms_that_may_hold
from workbench.app.core.state import Phase, State
from workbench.gui.cycle.plan_views import unsaved_message
from workbench.gui.drawing.nearest import (
    certificates_of,
    comes_too_near,
    free_message,
    straight_lines,
)
from workbench.gui.shared.views import NOTHING_MADE, clock, line, sentence, short, table_html
from workbench.gui.texts.approval import ApprovalText
from workbench.gui.texts.labels import LabelText, arm_label
from workbench.model.candidate import label_grasp
from workbench.model.cell import Cell
from workbench.model.derived.row_parts import parts_taken, renumber
from workbench.model.messages.message import FoundPart, Message, Others, all_of
from workbench.model.messages.plans import (
    PlanNote,
    cycle_words,
    guarantee_message,
    strategy_message,
)
from workbench.model.messages.states import held_message
from workbench.model.motion import MotionModel
from workbench.model.plan import Guarantee, Plan
from workbench.model.release import manner_words
from workbench.model.tools.held_body import HeldAmount, held_radius
from workbench.proof.claims.clearance import bounds_message
from workbench.proof.claims.drop_back import drop_point, fall_height
from workbench.words.words import IN_ENGLISH, Words


def approval_line(
    state: State,
    now: float,
    problem: str,
    *,
    is_next: bool = False,
    words: Words = IN_ENGLISH,
) -> str:
    """Who has approved, and until when that holds; or the `problem` that an approval meets.

    Where the problem `is_next`, it says what is to be done next, and nothing is wrong.
    """
    purpose = "Someone reviews the facts of this plan and signs it off by name."
    if state.phase in (Phase.PLANNED, Phase.APPROVED) and problem:
        # What is to be done next, or waited for, is no fault.
        kind = "result" if is_next or state.job is not None else "bad"
        return line(f"{sentence(problem)}.", kind=kind, tip=f"{sentence(problem)}.")
    if state.approval is None:
        if state.phase is Phase.PLANNED:
            return line(words.render(_missing(state, now)), tip=purpose)
        return line("", kind="hint", tip=purpose)
    approval = state.approval
    if approval.is_switched_off:
        return line(words.render(ApprovalText.SWITCHED_OFF(person=approval.actor)), kind="warn")
    by = ApprovalText.APPROVED_BY(people=approval.people)
    if state.phase is Phase.APPROVED:
        # It is for one sending: once that has begun, nothing is let out by it any more.
        by = ApprovalText.UNTIL(people=approval.people, until=clock(approval.until))
    manner = manner_words(*approval.manner)
    texts = LabelText.LIST(items=[by] if manner is None else [by, manner])
    if approval.is_unwatched:
        texts = Others.ALSO(first=texts, last=ApprovalText.NOT_ALL_WATCHED())
    if now >= approval.until and state.phase is Phase.APPROVED:
        texts = LabelText.LIST(items=[texts, ApprovalText.RUN_OUT()])
        return line(words.render(texts), kind="bad", tip=purpose)
    return line(words.render(texts), tip=purpose)


def _missing(state: State, now: float) -> Message:
    """Whom a plan waits for."""
    wanted, votes = state.cell.approvers, standing_votes(state, now)
    if not votes:
        return ApprovalText.WAITING_FOR(count=wanted)
    lapses = min(vote.at for vote in votes) + state.cell.policy.approval_minutes * 60.0
    missing = wanted - len(votes)
    people = [vote.actor for vote in votes]
    return ApprovalText.BY_WAITING(people=people, until=clock(lapses), count=missing)


TOGETHER = {
    Guarantee.ONE_AT_A_TIME: ApprovalText.ONE_AT_A_TIME,
    Guarantee.TIME_INDEPENDENT: ApprovalText.TIME_INDEPENDENT,
    Guarantee.SYNCHRONISED: ApprovalText.SYNCHRONISED,
}
"""What was proven of two arms, by the guarantee of a plan."""

WARNINGS = (
    PlanNote.GOES_UNSEEN,
    PlanNote.MATES_SELDOM,
    PlanNote.QUICKER_REFUSED,
    PlanNote.FOUND_GRIP,
)
"""Remarks of the planner that a person has to weigh."""

Fact = tuple[Message | str, Message | str | None]
"""Name and value of a line."""


def facts_html(
    state: State,
    joints: Mapping[str, float],
    at: float,
    made: Mapping[str, str] = NOTHING_MADE,
    words: Words = IN_ENGLISH,
) -> str:
    """What a person approves: values that the server holds, nothing typed in a browser.

    What deviates from a plain plan on a plain cell stands first, and stronger.  It scrolls where a
    window is too low for it; the vote stands below it, in view.

    Args:
        state: with the plan that would be sent, or the row that begins with it.
        joints: how the robot stands by its own report.
        at: seconds since the epoch.
        made: HTML instead of values, by the names of lines (`PlanLinks.made`).
        words: of who reads it.
    """
    deviations, usual = _facts(state, joints, at)
    named = [
        [(words.render(name), words.render(fact)) for name, fact in facts]
        for facts in (deviations, usual)
    ]
    name, certificates = certificates_of(state)
    named[1].append((name, ", ".join(map(words.render, certificates))))
    title = state.whole_row[0].plan.digest
    tables = "".join(
        f'<div class="{kind}">{table_html(rows, title=title, made=made)}</div>'
        for kind, rows in zip(("wb-deviates", "wb-usual"), named, strict=True)
        if rows
    )
    return f'<div class="wb-read" tabindex="0">{tables}</div>'


def _facts(state: State, joints: Mapping[str, float], at: float) -> tuple[list[Fact], list[Fact]]:
    """What a person has to weigh before approving, and what is as it usually is."""
    cell, row = state.cell, state.whole_row
    plan, policy = row[0].plan, cell.policy
    host, port = cell.controller.host, cell.controller.port
    moves = ApprovalText.SIMULATED if cell.controller.is_simulated else ApprovalText.REAL
    deviations: list[Fact] = [
        ("Controller", moves(address=LabelText.ADDRESS(host=host, port=port)))
    ]
    if (arms := sorted(arms_that_may_hold(state))) and not plan.is_drop_plan:
        deviations.append(("In the hand", ApprovalText.HANDS_OPEN(arms=arms)))
    usual: list[Fact] = _plans(state) if len(row) > 1 else _plan(cell, plan)

    def add(name: Message | str, fact: Message | str | None, *, is_usual: bool) -> None:
        (usual if is_usual else deviations).append((name, fact))

    if (unsaved := unsaved_message(state)) is not None:
        add("Not saved", unsaved, is_usual=False)
    if warnings := _warnings(state):
        add("Warnings", all_of(warnings), is_usual=False)
    add("Free motion", free_message(state), is_usual=True)
    for fact in straight_lines(state):
        add(*fact, is_usual=not comes_too_near(state))
    add("Proven", _proven(state), is_usual=True)
    is_seen = state.scan is not None and all(obstacle.part for obstacle in plan.obstacles)
    add("Kept clear of", _clear_of(state, plan), is_usual=is_seen and bool(plan.picks))
    add("Motion", ApprovalText.SPEED(cycle=_cycle(state), share=policy.speed), is_usual=True)
    robot = _robot(cell, plan, joints)
    add("Robot", robot, is_usual=robot.text is ApprovalText.STANDS_AT_START)
    preview = _preview(state)
    add("Preview", preview, is_usual=preview.text is ApprovalText.PLAYED)
    add("Valid for", ApprovalText.VALID(time=policy.approval_minutes * 60.0), is_usual=True)
    if cell.approvers > 1:
        people = [vote.actor for vote in standing_votes(state, at)] or ApprovalText.NOBODY()
        add("People", ApprovalText.PEOPLE(count=cell.approvers, people=people), is_usual=True)
    if len(row) == 1:
        add("Plan", LabelText.NAME(name=short(plan.digest)), is_usual=True)
    return deviations, usual


def _cycle(state: State) -> Message:
    seconds = sum(plan.cycle_seconds for plan in state.plans)
    if len(state.plans) > 1:
        return ApprovalText.ALL_SECONDS(cycle=seconds)
    return cycle_words(seconds, state.bound)


def _warnings(state: State) -> list[Message]:
    """The planner's remarks on what may go wrong, of all plans; each once."""
    found: dict[str, Message] = {}
    for proven_plan in state.whole_row:
        plan = proven_plan.plan
        for remark in plan.remarks:
            if any(map(remark.mentions, WARNINGS)):
                shown = renumber(remark, state.plans[0], plan.detections)
                found.setdefault(str(shown), shown)
    return list(found.values())


def _plan(cell: Cell, plan: Plan) -> list[Fact]:
    """What one plan takes, and how."""
    facts: list[Fact] = [("Strategy", _strategy(plan, _usual_remarks(plan.remarks)))]
    if plan.is_view_plan and (carrier := cell.scanner.on_arm) is not None:
        name = arm_label(carrier.arm)
        leads_home = carrier.leads_home(plan.arms[0].legs[0].q)
        to_view = ApprovalText.TO_VIEW(view=carrier.view.name)
        facts.append((name, ApprovalText.TO_HOME() if leads_home else to_view))
    if plan.is_stir_plan:
        name = arm_label(plan.strategy.arm)
        opening = plan.arms[0].leg("stir").opening
        has_fingers = bool(cell.arm(plan.strategy.arm).tool.fingers)
        stirs = ApprovalText.STIRS_OPEN(opening=opening) if has_fingers else ApprovalText.STIRS()
        facts.append((name, stirs))
    if plan.is_tool_plan:
        name = arm_label(plan.strategy.arm)
        old, new = cell.arm(plan.strategy.arm).tool.name, plan.arms[0].tool
        facts.append((name, ApprovalText.CHANGES_TOOL(old=old, new=new)))
    if plan.is_drop_plan:
        facts.append((arm_label(plan.strategy.arm), _drops(cell, plan.arms[0].held)))
    for arm in plan.picks:
        kind, part = plan.detections[arm.detection].part, FoundPart(arm.detection)
        grasp = ApprovalText.GRASP(part=part, kind=kind, grasp=label_grasp(arm.grasp, arm.tcp))
        facts.append((arm_label(arm.arm), grasp))
    return facts


def _usual_remarks(remarks: Sequence[Message]) -> list[Message]:
    """Those that are no warning: warnings stand by themselves."""
    return [remark for remark in remarks if not any(map(remark.mentions, WARNINGS))]


def _plans(state: State) -> list[Fact]:
    """A line for each plan of a row: what it takes and how, how long it is, and how near it comes.

    Each part by its number in the scan.
    """
    facts: list[Fact] = []
    for number, proven_plan in enumerate(state.whole_row, 1):
        plan, proof, first = proven_plan.plan, proven_plan.proof, state.plans[0]
        takes = [
            ApprovalText.ARM_GRASP(
                arm=arm.arm,
                part=FoundPart(part),
                kind=first.detections[part].part,
                grasp=label_grasp(arm.grasp, arm.tcp),
            )
            for part, arm in zip(parts_taken(first, plan), plan.picks, strict=True)
        ]
        remarks = [
            renumber(remark, first, plan.detections) for remark in _usual_remarks(plan.remarks)
        ]
        proven = ApprovalText.PROVEN_PLAN(
            cycle=plan.cycle_seconds,
            clearance=bounds_message(proof),
            plan=short(plan.digest),
            proof=short(proof.digest),
        )
        fact = all_of((*takes, _strategy(plan, remarks), proven))
        facts.append((LabelText.PLAN_NUMBER(number=number), fact))
    return facts


def _proven(state: State) -> Message:
    row = state.whole_row
    covered = _coverage(state.cell, [proven_plan.plan for proven_plan in row])
    count = sum(proven_plan.proof.checks for proven_plan in row)
    if len(row) != 1:
        return ApprovalText.MEASURED(covered=covered, count=count)
    time, proof = dict(state.seconds).get("prove"), short(row[0].proof.digest)
    if time is None:
        return ApprovalText.MEASURED_ALONE(covered=covered, count=count, proof=proof)
    return ApprovalText.MEASURED_IN(covered=covered, count=count, time=time, proof=proof)


def _robot(cell: Cell, plan: Plan, joints: Mapping[str, float]) -> Message:
    if cell.controller.motion.sends_poses:
        return ApprovalText.NO_START()
    if not joints:
        return ApprovalText.NO_JOINTS()
    return moved_away(cell, plan, joints) or ApprovalText.STANDS_AT_START()


def _preview(state: State) -> Message:
    people = [name for name in state.watched if name not in state.watched_elsewhere]
    played = ApprovalText.PLAYED(people=people) if people else ApprovalText.NOT_PLAYED()
    if state.watched_elsewhere:
        return ApprovalText.PLAYED_ELSEWHERE(played=played, people=state.watched_elsewhere)
    return played


def _strategy(plan: Plan, remarks: Sequence[Message]) -> Message | None:
    text = strategy_message(plan.strategy)
    if len(plan.arms) > 1:
        guarantee = guarantee_message(plan.guarantee)
        text = TOGETHER[plan.guarantee](strategy=text, guarantee=guarantee)
    return all_of((text, *remarks))


def _coverage(cell: Cell, plans: Sequence[Plan]) -> Message:
    """What the proofs cover, in the words of people who set up robots."""
    arms = [arm for plan in plans for arm in plan.arms]
    legs = [leg for arm in arms for leg in arm.legs]
    if cell.controller.motion.sends_poses:
        return ApprovalText.POSES(legs=len(legs))
    fingers = any(cell.arm(arm.arm).tool.fingers for arm in arms)
    return (ApprovalText.COVERED_FINGERS if fingers else ApprovalText.COVERED)(
        legs=len(legs),
        waypoints=sum(len(leg.q) for leg in legs),
        corners=_corners(cell.controller.motion, cell.policy.zone),
    )


def _corners(motion: MotionModel, zone: float) -> Message:
    match motion.corners:
        case "stop":
            return ApprovalText.STOPS()
        case "blend":
            return ApprovalText.ROUNDED(share=zone)
        case _:
            return ApprovalText.STREAMED()


def _drops(cell: Cell, held: str) -> Message:
    """What is dropped back, and from how high; outside of the bin the place alone."""
    amount, message = HeldAmount(held), held_message(held)
    height = fall_height(cell, amount)
    if height is not None:
        return ApprovalText.DROPS_BACK(held=message, height=height)
    x, y, z = (f"{1000 * value + 0.0:.0f}" for value in drop_point(cell, amount))
    return ApprovalText.DROPS_BESIDE_BIN(held=message, x=x, y=y, z=z)


def _clear_of(state: State, plan: Plan) -> Message:
    on_pallets = sum(bool(obstacle.part) for obstacle in plan.obstacles)
    pallets = [ApprovalText.ON_PALLETS(count=on_pallets)] if on_pallets else []
    if not plan.picks:
        is_stirred = plan.is_stir_plan
        clear = ApprovalText.CLEAR_BUT_STIRRED() if is_stirred else ApprovalText.CLEAR_OF_BIN()
        if plan.is_drop_plan:
            radius = held_radius(state.cell, HeldAmount(plan.arms[0].held))
            clear = ApprovalText.CLEAR_BUT_LIFTED(radius=radius)
        return ApprovalText.CLEAR_OF_BIN_AND(clear=clear, things=pallets) if pallets else clear
    unknown = len(plan.obstacles) - on_pallets
    things = [LabelText.PARTS(count=len(plan.detections))]
    if unknown:
        things.append(ApprovalText.UNKNOWN_THINGS(count=unknown))
    things += pallets
    is_scanned = state.scan is not None
    clear = (ApprovalText.CLEAR_OF if is_scanned else ApprovalText.CLEAR_OF_POSES)(things=things)
    return ApprovalText.AS_LEFT(clear=clear) if state.row else clear
