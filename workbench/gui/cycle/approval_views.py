"""What the page says about an approval: what a person lets out, who has, and what is in the way."""

from collections.abc import Mapping

from workbench.app.core.release import moved_away, standing_votes
from workbench.app.core.state import Phase, State, counted
from workbench.gui.cycle.row import takes_words
from workbench.gui.scene.nearest import PlanLinks, go_html, nearest_words, straight_words
from workbench.gui.shared.views import clock, line, sentence, short, table_html
from workbench.model.cell import Cell
from workbench.model.motion import MotionModel
from workbench.model.plan import Guarantee, Plan, Proof, at_least, cycle_words
from workbench.model.release import manner_words


def approval_line(state: State, now: float, problem: str) -> str:
    """Who has approved, and until when that holds; or the `problem` that an approval meets."""
    purpose = "A person looks at the facts of this plan and gives a name for it."
    if state.phase in (Phase.PLANNED, Phase.APPROVED) and problem:
        return line(f"{sentence(problem)}.", kind="bad", span=2, tip=f"{sentence(problem)}.")
    if state.approval is None:
        if state.phase is Phase.PLANNED:
            return line(_missing(state, now), span=2, tip=purpose)
        return line(purpose, kind="hint", span=2, tip=purpose)
    approval = state.approval
    text = f"By {' and '.join(approval.people)} until {clock(approval.until)}"
    if words := manner_words(*approval.manner):
        text += f", {words}"
    if approval.is_unwatched:
        text += "; not every one of them has seen it played"
    if now >= approval.until and state.phase is Phase.APPROVED:
        return line(f"{text}, run out", kind="bad", span=2, tip=purpose)
    return line(text, span=2, tip=purpose)


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
    plan: Plan,
    proof: Proof,
    joints: Mapping[str, float],
    at: float,
    links: PlanLinks | None = None,
) -> str:
    """What a person approves: values that the server holds, nothing typed in a browser.

    Args:
        state: whose plan it is.
        plan: that would be sent.
        proof: of it.
        joints: how the robot stands by its own report.
        at: seconds since the epoch.
        links: what a click on the nearest place, and on the certificate, does.
    """
    cell = state.cell
    took = dict(state.seconds).get("prove")
    looked = f"{proof.checks:,} positions measured" + ("" if took is None else f" in {took:.2f} s")
    cycle = cycle_words(plan.cycle_seconds, state.bound)
    rows = [
        ("Strategy", _strategy(plan)),
    ]
    for arm in plan.arms:
        part = plan.detections[arm.detection].part
        rows.append(
            (f"{arm.arm.capitalize()} arm", f"part-{arm.detection + 1} ({part}), grasp {arm.grasp}")
        )
    for number, one in enumerate(state.row, 2):
        # Each by the numbers of the scan; all of it stands in the tab of the plan.
        nearest, seconds = at_least(one.proof.clearance), one.plan.cycle_seconds
        proven = f"clear by {nearest}, proof {short(one.proof.digest)}"
        takes = takes_words(state, one)
        rows.append((f"Plan {number}", f"{takes}; {seconds:.1f} s, {proven}"))
    rows += [
        ("Free ways", nearest_words(state, plan, proof)),
        ("Straight ways", straight_words(state, proof)),
        ("Proven", f"{_covered(cell, plan)}; {looked}, proof {short(proof.digest)}"),
        ("Kept clear of", _kept_clear(state, plan)),
        ("Motion", f"{cycle}, up to {cell.policy.speed:.0%} of joint speeds"),
        ("Robot", _robot(cell, plan, joints)),
        ("Preview", _preview(state)),
        ("Controller", f"{cell.controller.host} port {cell.controller.port}"),
        ("Valid for", f"{cell.policy.approval_minutes:g} min after the approval"),
        ("Plan", short(plan.digest)),
        ("Certificate", f"certificate-{short(plan.digest)}.json"),
    ]

    if cell.approvers > 1:
        votes = ", ".join(vote.actor for vote in standing_votes(state, at)) or "nobody yet"
        rows.insert(-2, ("People", f"{cell.approvers} are needed; so far {votes}"))
    made: dict[str, str] = {}
    if links is not None:
        made["Free ways"] = go_html(dict(rows)["Free ways"], links.nearest, "Shows the plan there")
        made["Certificate"] = go_html(
            dict(rows)["Certificate"], links.certificate, "Saves what another machine can check"
        )
    return table_html(rows, title=plan.digest, made=made)


def _robot(cell: Cell, plan: Plan, joints: Mapping[str, float]) -> str:
    if not joints:
        return "reports no joints: see for yourself that it stands where the plan starts"
    return moved_away(cell, plan, joints) or "stands where the plan starts"


def _preview(state: State) -> str:
    drawn = ", ".join(name for name in state.watched if name not in state.told)
    words = f"played to its end ({drawn})" if drawn else "not played on a page"
    return words + (f"; by a program's word also to {', '.join(state.told)}" if state.told else "")


def _strategy(plan: Plan) -> str:
    words = plan.strategy.words
    if len(plan.arms) > 1:
        words += f", {TOGETHER[plan.guarantee]} ({plan.guarantee})"
    return words + (f"; {plan.note}" if plan.note else "")


def _covered(cell: Cell, plan: Plan) -> str:
    """What the proof has looked at, as somebody says it who sets up robots."""
    legs = [leg for arm in plan.arms for leg in arm.legs]
    waypoints = sum(len(leg.q) for leg in legs)
    fingers = any(cell.arm(arm.arm).tool.fingers for arm in plan.arms)
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
    parts, seen = counted(len(plan.detections), "part"), len(plan.obstacles)
    unknown = f", {counted(seen, 'unknown thing')} in the scan" if seen else ""
    source = "the scan has" if state.scan is not None else "poses from outside have"
    return f"cell, {parts}{unknown}, as {source} them"
