"""What planning has brought: a card of four numbers and one line, or why there is no plan."""

from collections import Counter
from collections.abc import Sequence
from html import escape

from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.state import State
from workbench.gui.shared.icons import opens_tab
from workbench.gui.shared.views import hint, line, message_text, mm, sentence
from workbench.gui.texts.approval import ApprovalText
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.candidate import Candidate, Reason
from workbench.model.derived.row_parts import fates_of
from workbench.model.messages.message import Message, all_of
from workbench.model.messages.plans import cycle_words, strategy_message
from workbench.model.messages.states import StateText, held_message
from workbench.model.motion import ceil_speed, floor_distance
from workbench.model.plan import Plan, Proof
from workbench.proof.claims.clearance import bounds_message, linear_clearance, speed_message
from workbench.words.words import IN_ENGLISH, Words

TIGHT = 1.5
"""Times the margin: a clearance below this is marked."""

PURPOSE = "Judges every grasp with every arm, plans the motion and proves it again."


def plan_line(state: State, words: Words = IN_ENGLISH) -> str:
    """What planning has brought, as HTML."""
    plan, proof = state.plan, state.proof
    if plan is None:
        return _no_plan_line(state, words)
    if proof is None or not proof.holds:
        problem = CyclePageText.NO_PROOF()
        if proof is not None:
            problem = CyclePageText.PROOF_FAILS(violation=proof.violations[0].message)
        return line(words.render(problem), kind="bad", tip=PURPOSE)
    result = strategy_message(plan.strategy)
    carrier = state.cell.scanner.on_arm
    if plan.is_view_plan and carrier is not None:
        result = CyclePageText.TO_VIEW(arm=carrier.arm, view=carrier.view.name)
        if carrier.leads_home(plan.arms[0].legs[0].q):
            result = CyclePageText.TO_HOME(arm=carrier.arm)
    elif plan.is_stir_plan:
        bounds = (bound.point for bound in proof.speeds if bound.leg == "stir")
        stirs = max(bounds, default=state.cell.policy.stir_speed)
        result = CyclePageText.STIRS(arm=plan.strategy.arm, speed=ceil_speed(stirs))
    elif plan.is_drop_plan:
        drops = plan.arms[0]
        result = CyclePageText.DROPS_BACK(arm=drops.arm, held=held_message(drops.held))
    elif plan.is_tool_plan:
        changed = plan.arms[0]
        result = CyclePageText.CHANGES_TOOL(arm=changed.arm, tool=changed.tool)
    elif unknown := sum(not obstacle.part for obstacle in plan.obstacles):
        result = CyclePageText.UNKNOWN_CLEAR(strategy=result, count=unknown)
    speed = speed_message(proof)
    said = (result, *(() if speed is None else (speed,)), *plan.remarks)
    text = message_text(all_of(said) or result, words)
    kind = "warn" if plan.goes_unseen else "result"
    unsaved = unsaved_message(state)
    rests = words.render(None if unsaved is None else ApprovalText.RESTS_ON(changes=unsaved))
    warning = line(rests, kind="warn", tip=rests) if rests else ""
    left = left_message(state)
    why_left = ""
    if left is not None:
        # The rows of the parts give the reason of each.
        shown = line(sentence(words.render(left)), kind="hint")
        why_left = f'<div class="wb-span3 wb-opens" {opens_tab("Parts")}>{shown}</div>'
    return _card(state, plan, proof, words) + why_left + line(text, kind=kind, tip=text) + warning


def _no_plan_line(state: State, words: Words) -> str:
    if state.verdict is not None:
        kind = "warn" if state.verdict.kind is Reason.WITHIN_MARGIN else "bad"
        no_plan = StateText.NO_PLAN(verdict=state.verdict.message)
        return line(sentence(words.render(no_plan)), kind=kind, tip=PURPOSE)
    if state.stale:
        return line(f"{sentence(words.render(state.stale))}.", kind="bad", tip=PURPOSE)
    return hint(state, MakePlan, PURPOSE, 3, words)


def _card(state: State, plan: Plan, proof: Proof, words: Words) -> str:
    """Four numbers of a proven plan: cycle, parts, and both clearances, from below.

    A clearance that is hardly more than what the cell asks for stands out.
    """
    policy = state.cell.policy
    linear = linear_clearance(proof)
    cycle = words.render(cycle_words(plan.cycle_seconds, state.bound))
    clearance = words.render(bounds_message(proof))
    cells = (
        (f"{plan.cycle_seconds:.1f} s", "Cycle", cycle, ""),
        (_count_taken(plan), "Parts", "", ""),
        (
            mm(floor_distance(proof.clearance)),
            "Clearance, free",
            clearance,
            _tightness(proof.clearance, policy.margin),
        ),
        (
            "" if linear is None else mm(floor_distance(max(linear, 0.0))),
            "Clearance, stirring" if plan.is_stir_plan else "Clearance, linear",
            clearance,
            "" if linear is None else _tightness(linear, policy.near_margin),
        ),
    )
    shown = "".join(
        f'<div class="{kind}" title="{escape(tip)}"><b>{escape(value)}</b><span>{name}</span></div>'
        for value, name, tip, kind in cells
        if value
    )
    return f'<div class="wb-card wb-span3">{shown}</div>'


def _count_taken(plan: Plan) -> str:
    """How many parts a plan takes, of how many found; empty where it takes none."""
    taken, found = len(plan.picks), len(plan.detections)
    if not taken:
        return ""
    return str(taken) if taken == found else f"{taken} / {found}"


def _tightness(clearance: float, margin: float) -> str:
    """The class of a clearance [m], by the margin [m] that is asked for."""
    return "wb-tight" if clearance < TIGHT * margin else "wb-clear"


def unsaved_message(state: State) -> Message | None:
    """The changes since the cell's files were saved; None where they have all of it."""
    if state.is_saved:
        return None
    # The newest change is the first; below the saved cell are those that it has.
    digests = [edited.cell.digest for edited in state.before]
    if state.saved not in digests:
        return ApprovalText.UNSAVED()
    count = digests.index(state.saved) + 1
    return ApprovalText.UNSAVED_CHANGES(count=count, change=state.before[0].change)


def left_message(state: State) -> Message | None:
    """How many parts the plans leave, and why most of them; None where they leave none.

    The rows of the parts give the reason of each.
    """
    if state.plan is None or not state.plan.picks or state.candidates is None:
        return None
    fates = fates_of(state.plans, state.candidates, len(state.detections or ()))
    left = [fate for fate in fates if not fate.taken_by]
    later = sum(fate.feasible > 0 for fate in left)
    untried = sum(not fate.tried for fate in left)
    return all_of(
        (
            CyclePageText.LEFT_FOR_LATER(count=later) if later else None,
            _refused_message([fate.refused for fate in left if fate.refused is not None]),
            CyclePageText.LEFT_UNTRIED(count=untried) if untried else None,
        )
    )


def _refused_message(farthest: Sequence[Candidate]) -> Message | None:
    """How many parts have no grasp that works, by the candidate of each that got farthest."""
    if not farthest:
        return None
    reasons = Counter(candidate.verdict.kind for candidate in farthest)
    reason, number = reasons.most_common(1)[0]
    arms = {candidate.arm for candidate in farthest if candidate.verdict.kind is reason}
    return CyclePageText.LEFT(
        count=len(farthest), arms=sorted(arms), reason=reason.message, number=number
    )
