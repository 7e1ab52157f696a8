"""What the tab of a plan says: plans in a few chips, and what plannings brought; no widgets."""

from collections.abc import Sequence
from html import escape

from workbench.app.core.state import Outline, State
from workbench.gui.shared.colours import arm_colour
from workbench.gui.shared.tables import clickable
from workbench.gui.shared.views import line, mm, sentence, short
from workbench.gui.texts.labels import LabelText
from workbench.gui.texts.plan import PlanText
from workbench.model.candidate import label_grasp
from workbench.model.derived.row_parts import count_taken, parts_taken, renumber
from workbench.model.messages.message import FoundPart, Message, all_of, as_message, plain
from workbench.model.messages.plans import guarantee_message, strategy_message
from workbench.model.motion import floor_distance
from workbench.model.plan import ArmPlan, Plan, Strategy
from workbench.words.words import IN_ENGLISH, Words

STAGES = {
    "propose": "grasps",
    "resolve": "linear motion",
    "route": "free motion",
    "prove": "proof",
    "regrasp": "over a station",
    "row": "plans after it",
}
"""What a stage of planning computes, for people."""


def plan_html(state: State, words: Words = IN_ENGLISH) -> str:
    """The plan in a few chips, or each plan of a row: what it takes, and what computing took."""
    row = state.plans
    times = [
        PlanText.STAGE_TIME(stage=plain(STAGES.get(stage, stage)), time=time)
        for stage, time in state.seconds
    ]
    computed = words.render(PlanText.COMPUTED(times=times))
    said = "".join(_plan_html(state, number, words) for number in range(len(row)))
    if len(row) > 1:
        seconds = sum(proven_plan.cycle_seconds for proven_plan in row)
        parts = LabelText.PARTS(count=count_taken(row))
        whole = words.render(PlanText.ROW(count=len(row), parts=parts, time=seconds))
        said = f"<div><b>{escape(whole)}</b></div>{said}"
    return f'<div class="wb-pad">{said}<div class="wb-small">{escape(computed)}</div></div>'


def _plan_html(state: State, number: int, words: Words) -> str:
    """One plan of the row, its parts by the numbers of the scan."""
    row, arms = state.plans, [arm.name for arm in state.cell.arms]
    plan, first = row[number], row[0]
    chips = [
        f'<span class="wb-chip" style="background:{arm_colour(arms.index(arm.arm))}">'
        f"{escape(words.render(_chip(part, arm)))}</span>"
        for part, arm in zip(parts_taken(first, plan), plan.picks, strict=True)
    ]
    strategy, guarantee = strategy_message(plan.strategy), guarantee_message(plan.guarantee)
    summary = PlanText.SUMMARY(strategy=strategy, guarantee=guarantee, digest=short(plan.digest))
    if len(row) > 1:
        # One line each: many plans leave room for the film.
        remarks = (renumber(remark, first, plan.detections) for remark in plan.remarks)
        tip = words.render(all_of(remarks)) or plan.digest
        numbered = PlanText.SUMMARY_NUMBERED(
            number=number + 1, time=plan.cycle_seconds, summary=summary
        )
        how = words.render(numbered)
        return f'<div class="wb-small" title="{escape(tip)}">{escape(how)}</div>{"".join(chips)}'
    how, note = words.render(summary), sentence(words.render(all_of(plan.remarks)))
    note = f'<div class="wb-small">{escape(note)}</div>' if note else ""
    small = f'<div class="wb-small" title="{escape(plan.digest)}">{escape(how)}</div>'
    return f"{''.join(chips)}{small}{note}{_loads_html(state, plan, words)}"


def _chip(part: int, arm: ArmPlan) -> Message:
    return PlanText.CHIP(arm=arm.arm, part=FoundPart(part), grasp=label_grasp(arm.grasp, arm.tcp))


def _loads_html(state: State, plan: Plan, words: Words) -> str:
    """What each arm carries, a line each, and one line where a mass is missing."""
    controller, lines = state.cell.controller, ""
    for arm in plan.picks:
        if arm.loads is None:
            continue
        masses = arm.loads.tool.mass, arm.loads.carried(True).mass
        tool, both = (f"{mass:.3g}" for mass in masses)
        text = PlanText.LOAD(arm=arm.arm, tool=tool, both=both)
        if not controller.motion.takes_loads:
            text = PlanText.LOAD_NOT_SENT(arm=arm.arm, tool=tool, both=both, link=controller.link)
        tip = escape(words.render(as_message(arm.loads.words)))
        lines += f'<div class="wb-small" title="{tip}">{escape(words.render(text))}</div>'
    tools = {state.cell.arm(arm.arm).tool.name for arm in plan.arms if arm.loads is None}
    if tools and controller.motion.takes_loads:
        missing = words.render(PlanText.NO_MASS(tools=sorted(tools)))
        lines += f'<div class="wb-small">{escape(missing)}</div>'
    return lines


def outlines_html(
    outlines: tuple[Outline, ...], taken: str, rows: Sequence[str], words: Words = IN_ENGLISH
) -> str:
    """What the plannings for these parts brought, the latest first, when there is a choice.

    Args:
        outlines: the latest last.
        taken: digest of the plan that is played, approved and sent; empty: there is none.
        rows: ids of the unseen buttons by place in `outlines`.
        words: of who reads it.
    """
    if len(outlines) < 2:
        return ""
    heads = "".join(
        f'<th class="{"wb-number" if is_number else ""}">{title}</th>'
        for title, is_number in (
            ("Plans for these parts", False),
            ("Planner", False),
            ("Cycle", True),
            ("Planning", True),
            ("Free motion", True),
            ("Arms apart", True),
        )
    )
    body = "".join(
        _outline_row(outline, taken, button, words)
        for outline, button in reversed(list(zip(outlines, rows, strict=False)))
    )
    table = (
        f'<table class="wb-facts wb-plans"><thead><tr>{heads}</tr></thead>'
        f"<tbody>{body}</tbody></table>"
    )
    if not any(outline.digest not in ("", taken) for outline in outlines):
        return table
    hint = "A row that is clicked becomes the plan: it is made again, to be played and taken."
    return table + line(hint, kind="hint")


def _outline_row(outline: Outline, taken: str, button: str, words: Words) -> str:
    what = words.render(outline.verdict)
    if not what:
        strategy = strategy_message(Strategy(outline.strategy))
        parts = LabelText.PARTS(count=outline.parts)
        text = PlanText.OUTLINE(strategy=strategy, parts=parts)
        if outline.plans > 1:
            text = PlanText.OUTLINE_ROW(strategy=strategy, parts=parts, count=outline.plans)
        what = words.render(text)
    values = (
        "" if outline.cycle is None else f"{outline.cycle:.1f} s",
        f"{outline.planning * 1000:.0f} ms",
        "" if outline.clearance is None else mm(floor_distance(outline.clearance)),
        "" if outline.apart is None else mm(outline.apart, 0),
    )
    numbers = "".join(f'<td class="wb-number">{escape(value)}</td>' for value in values)
    is_taken = bool(outline.digest) and outline.digest == taken
    chosen = ' class="wb-taken"' if is_taken else ""
    title = escape(f"{outline.guarantee} {short(outline.digest)}".strip())
    click = f" {clickable(button)}" if outline.digest and not is_taken else ""
    return (
        f'<tr{chosen} title="{title}"{click}><td>{escape(what)}</td>'
        f"<td>{escape(outline.planner)}</td>{numbers}</tr>"
    )
