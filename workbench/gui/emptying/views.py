"""What the tab says of piles that were emptied in simulation, as text and HTML."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any, Literal

from workbench.gui.shared.colours import badge, left_colour
from workbench.gui.shared.tables import clickable, mark_attribute
from workbench.gui.shared.views import line, sentence, table_html
from workbench.gui.texts.emptying import EmptyingText
from workbench.gui.texts.labels import LabelText
from workbench.model.messages.catalogue import message_of
from workbench.model.messages.message import Message, as_message, plain
from workbench.model.prediction import EmptiedPile, Emptying
from workbench.words.words import IN_ENGLISH, Words

Column = Literal["seed", "taken", "left", "failed", "touches", "plans", "motion"]

COLUMNS: Mapping[Column, tuple[str, str]] = {
    "seed": ("Seed", "of the pile: the same seed gives the same pile"),
    "taken": ("Taken", "parts that came out as planned"),
    "left": ("Left over", "parts that nothing took"),
    "failed": ("Failed", "picks that missed, or took a part otherwise than planned"),
    "touches": ("Touches", "straight legs on which something met that the plan held apart"),
    "plans": ("Plans", "made, proven and carried out"),
    "motion": ("Motion [s]", "as planned, in all"),
}

NOTHING_YET = (
    "How much of a full bin this cell would empty is shown here, and what stays, once piles were "
    "emptied."
)


@dataclass(frozen=True, slots=True)
class PileOrder:
    """How one browser sorts the table of piles."""

    column: Column = "seed"
    is_descending: bool = False


def sort_key(pile: EmptiedPile, column: Column) -> float:
    """By what a column sorts."""
    match column:
        case "seed":
            return pile.task.seed
        case "taken":
            return pile.taken
        case "left":
            return len(pile.left)
        case "failed":
            return sum(pile.failed)
        case "touches":
            return pile.touches
        case "plans":
            return pile.cycles
        case "motion":
            return pile.motion_seconds


def order_piles(piles: Sequence[EmptiedPile], order: PileOrder) -> tuple[int, ...]:
    """Indices of the piles in the order wanted; equal ones keep that of their seeds."""
    return tuple(
        sorted(
            range(len(piles)),
            key=lambda number: sort_key(piles[number], order.column),
            reverse=order.is_descending,
        )
    )


def asked_message(found: Emptying) -> Message:
    """Which piles they were, in one sentence."""
    task, plain = found.piles[0].task, found.plain
    seeds: Message | int = task.seed
    if len(plain) > 1:
        seeds = EmptyingText.SEEDS(first=plain[0].task.seed, last=plain[-1].task.seed)
    is_true = task.seen == "truth"
    text = EmptyingText.ASKED_TRUTH if is_true else EmptyingText.ASKED_SCANS
    return text(piles=len(plain), count=task.count, kind=task.part, seeds=seeds)


def summary_html(
    found: Emptying, summary: Mapping[str, Any], is_stale: bool, words: Words = IN_ENGLISH
) -> str:
    """What came of all piles together.

    Args:
        found: the piles.
        summary: their `summary`.
        is_stale: the cell is another one now.
        words: of who reads it.
    """
    planning, hourly = summary["planning_ms"], summary["parts_per_hour"]
    share = summary["taken_share"] or 0.0
    picks = EmptyingText.PICKS(
        count=summary["picks"],
        failed=_failure_message(summary),
        touches=_touches(summary["touches"]),
    )
    facts: list[tuple[str, Message | str]] = [
        ("Taken", _message_of_taken(summary, share)),
        ("Picks", picks),
        *_warn(summary),
        *([("Stirred", EmptyingText.STIRRED(count=summary["stirs"]))] if summary["stirs"] else []),
        ("Parts an hour", "-" if hourly is None else f"{hourly:.0f}"),
        ("Planning", "-" if planning is None else _planning(planning)),
        ("Stay", _reasons(summary["left_by_reason"])),
    ]
    rows = [(name, words.render(fact)) for name, fact in facts]
    stale = "The cell has changed since; empty the piles again to see what that changes."
    warning = line(stale, kind="warn") if is_stale else ""
    bar = f'<div class="wb-bar"><i style="width:{100.0 * share:.1f}%"></i></div>'
    return line(words.render(asked_message(found)), kind="hint") + warning + table_html(rows) + bar


def _message_of_taken(summary: Mapping[str, Any], share: float) -> Message:
    count, total, knocked = summary["taken"], summary["parts"], summary["knocked_out"]
    if knocked:
        return EmptyingText.TAKEN_KNOCKED(count=count, total=total, share=share, knocked=knocked)
    return EmptyingText.TAKEN(count=count, total=total, share=share)


def _failure_message(summary: Mapping[str, Any]) -> Message:
    count = summary["failed_picks"]
    kinds = [
        EmptyingText.COUNTED(count=number, kind=plain(kind))
        for kind, number in summary["failed_by_kind"].items()
        if number
    ]
    if kinds:
        return EmptyingText.FAILED_KINDS(count=count, kinds=kinds)
    return EmptyingText.FAILED(count=count)


def _planning(milliseconds: Mapping[str, float]) -> Message:
    median, most = milliseconds["median"] / 1000, milliseconds["p95"] / 1000
    return EmptyingText.PLANNING(median=median, most=most)


def _warn(summary: Mapping[str, Any]) -> list[tuple[str, Message | str]]:
    """Picks beside something that was not found, in a row where there are any."""
    if not summary["warned_picks"]:
        return []
    touches = _touches(summary["warned_touches"])
    return [("Unseen", EmptyingText.UNSEEN(count=summary["warned_picks"], touches=touches))]


def _touches(count: int) -> Message:
    return EmptyingText.TOUCHES(count=count)


def _reasons(reasons: Mapping[str, int]) -> Message | str:
    if not reasons:
        return "nothing"
    counts = (
        EmptyingText.COUNTED(count=count, kind=plain(kind)) for kind, count in reasons.items()
    )
    return LabelText.LIST(items=counts)


def piles_html(
    piles: Sequence[EmptiedPile],
    shown: Sequence[int],
    order: PileOrder,
    chosen: int | None,
    *,
    headings: Mapping[Column, str],
    rows: Sequence[str],
    words: Words = IN_ENGLISH,
) -> str:
    """The table of piles; a click on a row chooses it.

    Args:
        piles: all of them.
        shown: their indices, as they are sorted.
        order: how, for the arrow in the heading.
        chosen: index of the one that is viewed.
        headings: ids of unseen buttons, by column.
        rows: ids of unseen buttons, by place.
        words: of who reads it.
    """
    arrow = "<span> ▾</span>" if order.is_descending else "<span> ▴</span>"
    head = "".join(
        f'<th class="wb-number" title="{escape(tip)}" {clickable(headings[column])}>{escape(title)}'
        f"{arrow if column == order.column else ''}</th>"
        for column, (title, tip) in COLUMNS.items()
    )
    body = "".join(
        _pile_row(piles[number], rows[place], words, is_chosen=number == chosen)
        for place, number in enumerate(shown)
    )
    return (
        '<div class="wb-list"><table class="wb-table wb-piles"><thead><tr>'
        f"{head}</tr></thead><tbody>{body}</tbody></table></div>"
    )


def _pile_row(pile: EmptiedPile, button: str, words: Words, *, is_chosen: bool) -> str:
    parts = [
        EmptyingText.LEFT_PART(part=left_part.part, kind=left_part.kind_message)
        for left_part in pile.left
    ]
    values = (
        f"{pile.task.seed}",
        words.render(EmptyingText.TAKEN_OF(count=pile.taken, total=pile.parts)),
        f"{len(pile.left)}",
        f"{sum(pile.failed)}",
        f"{pile.touches}",
        f"{pile.cycles}",
        f"{pile.motion_seconds:.1f}",
    )
    cells = "".join(f'<td class="wb-number">{escape(value)}</td>' for value in values)
    tip = words.render(EmptyingText.LEFT(parts=parts)) if parts else "nothing stays"
    return f'<tr{mark_attribute(is_chosen)} title="{escape(tip)}" {clickable(button)}>{cells}</tr>'


def left_html(
    pile: EmptiedPile, chosen: int | None, rows: Sequence[str], words: Words = IN_ENGLISH
) -> str:
    """The parts that stayed in a pile, each with why and what would take it.

    Args:
        pile: whose.
        chosen: number of the part that is viewed, from 0 on.
        rows: ids of unseen buttons, by place.
        words: of who reads it.
    """
    if not pile.left:
        return line("The bin was emptied.", kind="hint")
    body = "".join(
        f"<tr{mark_attribute(left_part.part == _name(chosen))} {clickable(rows[place])}>"
        f'<td translate="no">{escape(left_part.part)}</td>'
        f"<td>{badge(left_colour(left_part.kind), words.render(left_part.kind_message))} "
        f"{escape(sentence(words.render(left_part.reason)))}."
        f'<div class="wb-pair">{escape(words.render(fix_message(left_part.nearest_fix)))}</div>'
        "</td></tr>"
        for place, left_part in enumerate(pile.left[: len(rows)])
    )
    return (
        '<div class="wb-list"><table class="wb-table wb-left"><thead><tr><th>Stays</th>'
        f"<th>Why, and what would take it</th></tr></thead><tbody>{body}</tbody></table></div>"
    )


def fix_message(nearest_fix: Message | str) -> Message | str:
    """The smallest change that takes a part, or that there is none."""
    if not nearest_fix:
        return "No small change of a grasp takes it."
    return EmptyingText.NEAREST_FIX(change=as_message(nearest_fix))


def changes_html(rows: Sequence[Mapping[str, Any]], words: Words = IN_ENGLISH) -> str:
    """What single changes of the cell bring on the same piles, the best first."""
    if not rows:
        return ""
    body = "".join(
        # As it is called: some begin with a key of the cell file.
        f'<tr title="{escape(name)}"><td>{escape(name)}</td>'
        f'<td class="wb-number">{row["taken_share_before"]:.0%}</td>'
        f'<td class="wb-number">{row["taken_share"]:.0%}</td>'
        f'<td class="wb-number wb-{_sign(row["parts_gained"])}">'
        f"{_format_gain(row['parts_gained'])}</td>"
        f'<td class="wb-number">{row["failed_picks"] + row["touches"]}</td>'
        f'<td class="wb-number">{row["motion_seconds"]:.1f}</td></tr>'
        for row in rows
        for name in (words.render(_change(row)),)
    )
    return (
        '<div class="wb-list"><table class="wb-table wb-what-if"><thead><tr><th>Change</th>'
        '<th class="wb-number">Before</th><th class="wb-number">With it</th>'
        '<th class="wb-number">Parts</th>'
        '<th class="wb-number" title="failed picks, and touches">Failed</th>'
        f'<th class="wb-number">Motion [s]</th></tr></thead><tbody>{body}</tbody></table></div>'
    )


def _change(row: Mapping[str, Any]) -> Message:
    """What a change is called: older records have a text without an id."""
    said = row["said"]
    return message_of(said) if said["id"] else plain(said["text"])


def _format_gain(parts: int) -> str:
    return f"{parts:+d}" if parts else "0"


def _sign(gained: int) -> str:
    return "gain" if gained > 0 else "loss" if gained < 0 else "same"


def _name(number: int | None) -> str:
    return "" if number is None else f"part-{number + 1}"
