"""What the tab of a plan says: the plan in a few chips, and what plannings brought; no widgets."""

from collections.abc import Sequence
from html import escape

from workbench.app.core.state import Outline
from workbench.gui.shared.colours import arm_colour
from workbench.gui.shared.tables import clickable
from workbench.gui.shared.views import line, mm, sentence, short
from workbench.model.cell import Cell
from workbench.model.plan import Plan, Strategy

STAGES = {
    "propose": "grasps",
    "resolve": "straight ways",
    "route": "free ways",
    "prove": "proof",
}
"""What a stage of planning computes, for people."""


def plan_html(cell: Cell, plan: Plan, seconds: tuple[tuple[str, float], ...]) -> str:
    """The plan in a few chips: what, how long, and what computing it took."""
    arms = [arm.name for arm in cell.arms]
    chips = [
        f'<span class="wb-chip" style="background:{arm_colour(arms.index(arm.arm))}">'
        f"{escape(arm.arm)}: part-{arm.detection + 1}, {escape(arm.grasp)}</span>"
        for arm in plan.arms
    ]
    times = ", ".join(f"{STAGES.get(k, k)} {value * 1000:.0f} ms" for k, value in seconds)
    note = f'<div class="wb-small">{escape(sentence(plan.note))}</div>' if plan.note else ""
    return (
        f'<div class="wb-pad">{"".join(chips)}'
        f'<div class="wb-small" title="{escape(plan.digest)}">{escape(plan.strategy.words)}, '
        f"{escape(plan.guarantee)}, plan {short(plan.digest)}</div>"
        f"{note}"
        f'<div class="wb-small">Computed: {escape(times)}</div></div>'
    )


def outlines_html(outlines: tuple[Outline, ...], taken: str, rows: Sequence[str]) -> str:
    """What the plannings for these parts brought, the latest first, when there is a choice.

    Args:
        outlines: the latest last.
        taken: digest of the plan that is played, approved and sent; empty: there is none.
        rows: ids of the unseen buttons by place in `outlines`.
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
        _outline_row(outline, taken, button)
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


def _outline_row(outline: Outline, taken: str, button: str) -> str:
    what = outline.verdict
    if not what:
        strategy = Strategy(outline.strategy).words
        what = f"{strategy}, {outline.parts} part{'' if outline.parts == 1 else 's'}"
    values = (
        "" if outline.cycle is None else f"{outline.cycle:.1f} s",
        f"{outline.planning * 1000:.0f} ms",
        "" if outline.clearance is None else mm(outline.clearance),
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
