"""What the tab of a plan says: plans in a few chips, and what plannings brought; no widgets."""

from collections.abc import Sequence
from html import escape

from workbench.app.core.state import Outline, State, counted
from workbench.app.picking.numbers import renumber
from workbench.gui.shared.colours import arm_colour
from workbench.gui.shared.tables import clickable
from workbench.gui.shared.views import line, mm, sentence, short
from workbench.model.messages.plans import guarantee_message, strategy_message
from workbench.model.plan import Plan, Strategy, count_taken, floored, parts_taken
from workbench.words.words import IN_ENGLISH, Words

STAGES = {
    "propose": "grasps",
    "resolve": "straight ways",
    "route": "free ways",
    "prove": "proof",
    "regrasp": "over a station",
    "row": "plans after it",
}
"""What a stage of planning computes, for people."""


def plan_html(state: State, words: Words = IN_ENGLISH) -> str:
    """The plan in a few chips, or each plan of a row: what it takes, and what computing took."""
    row = state.plans
    times = ", ".join(f"{STAGES.get(k, k)} {value * 1000:.0f} ms" for k, value in state.seconds)
    said = "".join(_plan_html(state, number, words) for number in range(len(row)))
    if len(row) > 1:
        seconds = sum(proven_plan.cycle_seconds for proven_plan in row)
        parts = counted(count_taken(row), "part")
        whole = f"{len(row)} plans in a row, {parts}, {seconds:.1f} s in all"
        said = f"<div><b>{escape(whole)}</b></div>{said}"
    return f'<div class="wb-pad">{said}<div class="wb-small">Computed: {escape(times)}</div></div>'


def _plan_html(state: State, number: int, words: Words) -> str:
    """One plan of the row, its parts by the numbers of the scan."""
    row, arms = state.plans, [arm.name for arm in state.cell.arms]
    plan, first = row[number], row[0]
    chips = [
        f'<span class="wb-chip" style="background:{arm_colour(arms.index(arm.arm))}">'
        f"{escape(arm.arm)}: part-{part + 1}, {escape(arm.grasp)}</span>"
        for part, arm in zip(parts_taken(first, plan), plan.arms, strict=True)
    ]
    strategy = words.render(strategy_message(plan.strategy))
    guarantee = words.render(guarantee_message(plan.guarantee))
    how = f"{strategy}, {guarantee}, plan {short(plan.digest)}"
    if len(row) > 1:
        # One line each: many plans leave room for the film.
        remarks = (renumber(remark, first, plan.detections) for remark in plan.remarks)
        tip = "; ".join(map(words.render, remarks)) or plan.digest
        how = f"Plan {number + 1}: {plan.cycle_seconds:.1f} s, {how}"
        return f'<div class="wb-small" title="{escape(tip)}">{escape(how)}</div>{"".join(chips)}'
    note = sentence("; ".join(map(words.render, plan.remarks)))
    note = f'<div class="wb-small">{escape(note)}</div>' if note else ""
    small = f'<div class="wb-small" title="{escape(plan.digest)}">{escape(how)}</div>'
    return f"{''.join(chips)}{small}{note}{_loads_html(state, plan)}"


def _loads_html(state: State, plan: Plan) -> str:
    """What each arm carries, a line each, and one line where a mass is missing."""
    controller, lines = state.cell.controller, ""
    for arm in plan.arms:
        if arm.loads is None:
            continue
        tool, both = arm.loads.tool.mass, arm.loads.carried(True).mass
        words = f"{arm.arm} arm: load {tool:.3g} kg, {both:.3g} kg with the part"
        if not controller.motion.takes_loads:
            words += f", not sent by {controller.link}"
        tip = escape(str(arm.loads.words))
        lines += f'<div class="wb-small" title="{tip}">{escape(words)}</div>'
    tools = {state.cell.arm(arm.arm).tool.name for arm in plan.arms if arm.loads is None}
    if tools and controller.motion.takes_loads:
        words = f"No load is sent: mass_g of {', '.join(sorted(tools))} is missing"
        lines += f'<div class="wb-small">{escape(words)}</div>'
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
            ("Free ways", True),
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
        strategy = words.render(strategy_message(Strategy(outline.strategy)))
        what = f"{strategy}, {counted(outline.parts, 'part')}"
        if outline.plans > 1:
            what += f", {counted(outline.plans, 'plan')}"
    values = (
        "" if outline.cycle is None else f"{outline.cycle:.1f} s",
        f"{outline.planning * 1000:.0f} ms",
        "" if outline.clearance is None else mm(floored(outline.clearance)),
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
