"""What the page says about an approval: what a person lets out, who has, and what is in the way."""

from collections.abc import Mapping, Sequence

from workbench.app.core.cycle.approval import standing_votes
from workbench.app.core.cycle.standing import moved_away
from workbench.app.core.state import Phase, State, counted
from workbench.app.picking.numbers import renumber
from workbench.gui.scene.nearest import certificate_row, free_words, straight_words
from workbench.gui.shared.views import NOTHING_MADE, clock, line, sentence, short, table_html
from workbench.model.cell import Cell
from workbench.model.messages.message import Message
from workbench.model.messages.plans import guarantee_message, strategy_message
from workbench.model.motion import MotionModel
from workbench.model.plan import Guarantee, Plan, at_least, cycle_words, parts_taken
from workbench.model.release import manner_words
from workbench.words.words import IN_ENGLISH, Words


def approval_line(state: State, now: float, problem: str, *, is_next: bool = False) -> str:
    """Who has approved, and until when that holds; or the `problem` that an approval meets.

    Where the problem `is_next`, it says what is to be done next, and nothing is wrong.
    """
    purpose = "A person looks at the facts of this plan and gives a name for it."
    if state.phase in (Phase.PLANNED, Phase.APPROVED) and problem:
        # What is to be done next, or waited for, is no fault.
        kind = "result" if is_next or state.job is not None else "bad"
        return line(f"{sentence(problem)}.", kind=kind, tip=f"{sentence(problem)}.")
    if state.approval is None:
        if state.phase is Phase.PLANNED:
            return line(_missing(state, now), tip=purpose)
        return line(purpose, kind="hint", tip=purpose)
    approval = state.approval
    text = f"Approved by {' and '.join(approval.people)}"
    if state.phase is Phase.APPROVED:
        # It is for one sending: once that has begun, nothing is let out by it any more.
        text = f"By {' and '.join(approval.people)} until {clock(approval.until)}"
    if words := manner_words(*approval.manner):
        text += f", {words}"
    if approval.is_unwatched:
        text += "; not every one of them has seen it played"
    if now >= approval.until and state.phase is Phase.APPROVED:
        return line(f"{text}, run out", kind="bad", tip=purpose)
    return line(text, tip=purpose)


def _missing(state: State, now: float) -> str:
    """Whom a plan waits for."""
    wanted, votes = state.cell.approvers, standing_votes(state, now)
    if not votes:
        return "Waiting for a person." if wanted == 1 else f"Waiting for {wanted} people."
    lapses = min(vote.at for vote in votes) + state.cell.policy.approval_minutes * 60.0
    missing = wanted - len(votes)
    people = "another person" if missing == 1 else f"{missing} more people"
    names = " and ".join(vote.actor for vote in votes)
    return f"By {names} until {clock(lapses)}, waiting for {people}."


TOGETHER = {
    Guarantee.ONE_AT_A_TIME: "one moves at a time",
    Guarantee.TIME_INDEPENDENT: "proven for any speeds of both",
    Guarantee.SYNCHRONISED: "proven in step, at the times planned",
}
"""What was proven of two arms, by the guarantee of a plan."""


def facts_html(
    state: State,
    joints: Mapping[str, float],
    at: float,
    made: Mapping[str, str] = NOTHING_MADE,
    words: Words = IN_ENGLISH,
) -> str:
    """What a person approves: values that the server holds, nothing typed in a browser.

    It scrolls where a window is too low for it; the vote stands below it, in view.

    Args:
        state: with the plan that would be sent, or the row that begins with it.
        joints: how the robot stands by its own report.
        at: seconds since the epoch.
        made: HTML instead of values, by the names of lines (`PlanLinks.made`).
        words: of who reads it.
    """
    cell, row = state.cell, state.whole_row
    plan = row[0].plan
    rows = _plans(state, words) if len(row) > 1 else _plan(plan, words)
    cycle = str(cycle_words(plan.cycle_seconds, state.bound))
    if len(row) > 1:
        cycle = f"{sum(proven_plan.plan.cycle_seconds for proven_plan in row):.1f} s in all"
    rows += [
        ("Free ways", free_words(state)),
        ("Straight ways", straight_words(state)),
        ("Proven", _proven(state)),
        ("Kept clear of", _kept_clear(state, plan)),
        ("Motion", f"{cycle}, up to {cell.policy.speed:.0%} of joint speeds"),
        ("Robot", _robot(cell, plan, joints)),
        ("Preview", _preview(state)),
        ("Controller", f"{cell.controller.host} port {cell.controller.port}"),
        ("Valid for", f"{cell.policy.approval_minutes:g} min after the approval"),
    ]
    if cell.approvers > 1:
        votes = ", ".join(vote.actor for vote in standing_votes(state, at)) or "nobody yet"
        rows.append(("People", f"{cell.approvers} are needed; so far {votes}"))
    if len(row) == 1:
        rows.append(("Plan", short(plan.digest)))
    rows.append(certificate_row(state))
    return (
        f'<div class="wb-read" tabindex="0">{table_html(rows, title=plan.digest, made=made)}</div>'
    )


def _plan(plan: Plan, words: Words) -> list[tuple[str, str]]:
    """What one plan takes, and how."""
    rows = [("Strategy", _strategy(plan, plan.remarks, words))]
    for arm in plan.arms:
        part = plan.detections[arm.detection].part
        rows.append(
            (f"{arm.arm.capitalize()} arm", f"part-{arm.detection + 1} ({part}), grasp {arm.grasp}")
        )
    return rows


def _plans(state: State, words: Words) -> list[tuple[str, str]]:
    """A line for each plan of a row: what it takes and how, how long it is, and how near it comes.

    Each part by its number in the scan.
    """
    rows: list[tuple[str, str]] = []
    for number, proven_plan in enumerate(state.whole_row, 1):
        plan, first = proven_plan.plan, state.plans[0]
        takes = "; ".join(
            f"{arm.arm} arm part-{part + 1} ({first.detections[part].part}), grasp {arm.grasp}"
            for part, arm in zip(parts_taken(first, plan), plan.arms, strict=True)
        )
        remarks = [renumber(remark, first, plan.detections) for remark in plan.remarks]
        how = _strategy(plan, remarks, words)
        near = at_least(proven_plan.proof.clearance)
        proven = (
            f"clear by {near}, plan {short(plan.digest)}, proof {short(proven_plan.proof.digest)}"
        )
        rows.append((f"Plan {number}", f"{takes}; {how}; {plan.cycle_seconds:.1f} s, {proven}"))
    return rows


def _proven(state: State) -> str:
    row = state.whole_row
    covered = _coverage_words(state.cell, [proven_plan.plan for proven_plan in row])
    looked = f"{sum(proven_plan.proof.checks for proven_plan in row):,} positions measured"
    if len(row) != 1:
        return f"{covered}; {looked}"
    took = dict(state.seconds).get("prove")
    looked += "" if took is None else f" in {took:.2f} s"
    return f"{covered}; {looked}, proof {short(row[0].proof.digest)}"


def _robot(cell: Cell, plan: Plan, joints: Mapping[str, float]) -> str:
    if not joints:
        return "reports no joints: see for yourself that it stands where the plan starts"
    moved = moved_away(cell, plan, joints)
    return "stands where the plan starts" if moved is None else str(moved)


def _preview(state: State) -> str:
    drawn = ", ".join(name for name in state.watched if name not in state.told)
    words = f"played to its end ({drawn})" if drawn else "not played on a page"
    return words + (f"; by a program's word also to {', '.join(state.told)}" if state.told else "")


def _strategy(plan: Plan, remarks: Sequence[Message], words: Words) -> str:
    text = words.render(strategy_message(plan.strategy))
    if len(plan.arms) > 1:
        guarantee = words.render(guarantee_message(plan.guarantee))
        text += f", {TOGETHER[plan.guarantee]} ({guarantee})"
    return "; ".join((text, *map(words.render, remarks)))


def _coverage_words(cell: Cell, plans: Sequence[Plan]) -> str:
    """What the proofs cover, in the words of people who set up robots."""
    arms = [arm for plan in plans for arm in plan.arms]
    legs = [leg for arm in arms for leg in arm.legs]
    waypoints = sum(len(leg.q) for leg in legs)
    fingers = any(cell.arm(arm.arm).tool.fingers for arm in arms)
    grips = ", fingers opening and closing" if fingers else ""
    corners = _corners(cell.controller.motion, cell.policy.zone)
    return f"the whole motion on {len(legs)} legs, {waypoints} waypoints, {corners}{grips}"


def _corners(motion: MotionModel, zone: float) -> str:
    match motion.corners:
        case "stop":
            return "stopping at each"
        case "blend":
            return f"corners sharp or rounded by up to {zone:.0%} of a segment"
        case _:
            return "corners cut as streaming may"


def _kept_clear(state: State, plan: Plan) -> str:
    parts, kept = counted(len(plan.detections), "part"), sum(bool(o.part) for o in plan.obstacles)
    seen = len(plan.obstacles) - kept
    unknown = f", {counted(seen, 'unknown thing')} in the scan" if seen else ""
    unknown += f", {counted(kept, 'part')} on pallets" if kept else ""
    source = "the scan has" if state.scan is not None else "poses from outside have"
    left = ", each plan by what those before leave" if state.row else ""
    return f"cell, {parts}{unknown}, as {source} them{left}"
