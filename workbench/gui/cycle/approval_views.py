"""What the page says about an approval: what a person lets out, who has, and what is in the way."""

from collections.abc import Mapping

from workbench.app.core.release import moved_away, standing_votes
from workbench.app.core.state import Phase, State
from workbench.gui.shared.views import clock, line, mm, sentence, short, table_html
from workbench.model.cell import Cell
from workbench.model.plan import Finding, Plan, Proof


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


def facts_html(
    state: State, plan: Plan, proof: Proof, joints: Mapping[str, float], at: float
) -> str:
    """What a person approves: values that the server holds, nothing typed in a browser.

    Args:
        state: whose plan it is.
        plan: that would be sent.
        proof: of it.
        joints: how the robot stands by its own report.
        at: seconds since the epoch.
    """
    cell = state.cell
    rows = [
        ("Strategy", plan.strategy.words + (f" ({plan.note})" if plan.note else "")),
        ("Guarantee", str(plan.guarantee)),
    ]
    for arm in plan.arms:
        part = plan.detections[arm.detection].part
        rows.append(
            (f"{arm.arm.capitalize()} arm", f"part-{arm.detection + 1} ({part}), grasp {arm.grasp}")
        )
    rows += [
        ("Smallest clearance", mm(proof.clearance) + _where(proof.nearest)),
        ("Proof", f"holds, {proof.checks:,} states checked, down to {mm(proof.resolution, 2)}"),
        ("Kept clear of", _kept_clear(plan)),
        ("Cycle time", f"{plan.cycle_seconds:.1f} s"),
        ("Speeds", f"up to {cell.policy.speed:.0%} of what each joint can"),
        ("Robot", _robot(cell, plan, joints)),
        ("Preview", f"played to its end ({', '.join(state.watched)})"),
        ("Controller", f"{cell.controller.host} port {cell.controller.port}"),
        ("Valid for", f"{cell.policy.approval_minutes:g} min after the approval"),
        ("Plan", short(plan.digest)),
    ]
    if cell.approvers > 1:
        votes = ", ".join(vote.actor for vote in standing_votes(state, at)) or "nobody yet"
        rows.insert(-1, ("People", f"{cell.approvers} are needed; so far {votes}"))
    return table_html(rows, title=plan.digest)


def _robot(cell: Cell, plan: Plan, joints: Mapping[str, float]) -> str:
    if not joints:
        return "reports no joints: see for yourself that it stands where the plan starts"
    return moved_away(cell, plan, joints) or "stands where the plan starts"


def _kept_clear(plan: Plan) -> str:
    parts, seen = len(plan.detections), len(plan.obstacles)
    unknown = f", {seen} unknown things in the scan" if seen else ""
    return f"cell, {parts} {'part' if parts == 1 else 'parts'}{unknown}"


def _where(finding: Finding | None) -> str:
    if finding is None:
        return ""
    where = f" on free legs: {finding.arm} arm, leg {finding.leg}"
    return where + (f", {' · '.join(finding.pair)}" if finding.pair is not None else "")
