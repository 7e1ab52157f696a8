"""What planning has brought: a card of four numbers and one line, or why there is no plan."""

from collections import Counter
from html import escape

from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.state import State
from workbench.gui.shared.views import hint, line, message_text, mm, sentence
from workbench.gui.texts.approval import ApprovalText
from workbench.gui.texts.cycle import CyclePageText
from workbench.model.candidate import Candidate, Reason
from workbench.model.derived.row_parts import parts_taken
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
    why_left = "" if left is None else line(sentence(words.render(left)), kind="hint")
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

    Of a cell with several arms it is about the arms that take no part.
    """
    if state.plan is None or not state.plan.picks or not state.candidates:
        return None
    first = state.plans[0]
    taken = {number for plan in state.plans for number in parts_taken(first, plan)}
    left = [number for number in range(len(first.detections)) if number not in taken]
    if not left:
        return None
    busy = {pick.arm for plan in state.plans for pick in plan.picks}
    arms = {arm.name for arm in state.cell.arms} - busy or busy
    tried = [candidate for candidate in state.candidates if candidate.arm in arms]
    reasons = Counter(_reason([each for each in tried if each.detection == part]) for part in left)
    can_wait = reasons.pop(Reason.OK, 0)
    later = CyclePageText.LEFT_FOR_LATER(count=can_wait) if can_wait else None
    if not reasons:
        return later
    reason, number = reasons.most_common(1)[0]
    refused = CyclePageText.LEFT(
        count=reasons.total(), arms=sorted(arms), reason=reason.message, number=number
    )
    return all_of((later, refused))


def _reason(candidates: list[Candidate]) -> Reason:
    """Why a part is not taken by these: that of the candidate that got farthest."""
    if not candidates or any(candidate.verdict.is_ok for candidate in candidates):
        return Reason.OK
    return max(candidates, key=lambda candidate: candidate.verdict.progress).verdict.kind
