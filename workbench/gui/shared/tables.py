"""The table of candidates: which rows, in which order, as HTML whose clicks press buttons.

viser has no table.  A row or heading that can be clicked presses a button of the page which
is there but not seen; its id comes from viser, everything else is escaped.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from typing import Literal

from workbench.gui.shared.colours import BAD, GOOD, VERDICT_KINDS, badge, verdict_colour
from workbench.gui.shared.views import mm
from workbench.model.candidate import Candidate, Reason, Stage
from workbench.words.words import IN_ENGLISH, Words

Column = Literal["part", "grasp", "arm", "verdict", "distance", "rank"]

COLUMNS: Mapping[Column, tuple[str, str]] = {
    "part": ("Part", "which of the parts found"),
    "grasp": ("Grasp", "which grasp of the library"),
    "arm": ("Arm", "which arm would take it"),
    "verdict": ("Verdict", "why it can or cannot be taken; sorted by how far it came"),
    "distance": ("Distance", "between the pair that is too close, or from reach [mm]"),
    "rank": ("Rank", "lower is chosen first: SE(3) distance from the arm's home"),
}

MOST_PARTS = 30
"""Parts that can be listed: as many as a bin may hold."""

PAGE = 60
"""Rows a page; each has an unseen button."""


@dataclass(frozen=True, slots=True)
class CandidateOrder:
    """What one browser wants to see of the table."""

    only: Reason | None = None
    part: int | None = None
    words: str = ""
    column: Column = "verdict"
    is_descending: bool = True
    page: int = 0


def sort_key(candidate: Candidate, column: Column) -> tuple[float, ...] | tuple[str, ...]:
    """By what a column sorts; equal keys keep the order of the choice."""
    verdict = candidate.verdict
    match column:
        case "part":
            return (float(candidate.detection),)
        case "grasp":
            return (candidate.grasp_label,)
        case "arm":
            return (candidate.arm,)
        case "verdict":
            # As the tab Parts counts which candidate got farthest.
            stage, distance = verdict.progress
            return (float(len(Stage) if verdict.is_ok else stage), distance)
        case "distance":
            distance = verdict.distance
            return (float("-inf") if distance is None else distance,)
        case "rank":
            return (candidate.rank,)


def holds(candidate: Candidate, typed: str, words: Words = IN_ENGLISH) -> bool:
    """Whether a row has all words that were typed: of part, grasp, arm, verdict, stage, bodies."""
    verdict = candidate.verdict
    said = (
        f"part-{candidate.detection + 1}",
        candidate.grasp_label,
        candidate.arm,
        words.render(verdict.kind.message),
        words.render(verdict.stage.message),
        *(verdict.pair or ()),
    )
    whole = " ".join(said).casefold()
    return all(word in whole for word in typed.casefold().split())


def stages_html(candidates: Sequence[Candidate], words: Words = IN_ENGLISH) -> str:
    """How many candidates came to each stage, and how many it refused, as `explain` counts them."""
    refused = Counter(c.verdict.stage for c in candidates if not c.verdict.is_ok)
    left, lines = len(candidates), list[str]()
    for stage in Stage:
        if refused[stage]:
            lines.append(
                f"{escape(words.render(stage.message))} <b>{left}</b> \u2212{refused[stage]}"
            )
        left -= refused[stage]
    lines.append(f"<span>{escape(words.say('remaining'))}</span> <b>{left}</b>")
    return f'<div class="wb-stages">{", ".join(lines)}</div>'


def order_candidates(
    candidates: Sequence[Candidate], order: CandidateOrder, words: Words = IN_ENGLISH
) -> tuple[int, ...]:
    """Indices of the candidates of all pages, in the order wanted."""
    wanted = [
        number
        for number, candidate in enumerate(candidates)
        if (order.only is None or candidate.verdict.kind is order.only)
        and order.part in (None, candidate.detection)
        and holds(candidate, order.words, words)
    ]
    return tuple(
        sorted(
            wanted,
            key=lambda number: sort_key(candidates[number], order.column),
            reverse=order.is_descending,
        )
    )


def pages(count: int) -> int:
    """How many pages this many rows need; an empty table has one."""
    return max(1, -(-count // PAGE))


def on_page(indices: Sequence[int], page: int) -> tuple[int, ...]:
    """The part of the rows on one page."""
    return tuple(indices[page * PAGE : (page + 1) * PAGE])


def clickable(button: str) -> str:
    """Attributes of an element that presses the unseen button with this id."""
    press = f"document.getElementById('{escape(button)}').click()"
    key = f"if(event.key==='Enter'||event.key===' '){{event.preventDefault();{press}}}"
    return f'tabindex="0" role="button" onclick="{press}" onkeydown="{key}"'


def make_text_css(words: Mapping[str, str]) -> str:
    """Rules by which the style sheet shows a text for each button: viser shows none for them.

    Args:
        words: by the id of the button.
    """
    return "".join(
        f'div:has(> [id="{button}"]){{--wb-told:"{css_text(text)}"}}'
        for button, text in words.items()
        if text
    )


def primary_css(button: str) -> str:
    """Rules that fill the button with this id, and keep its group in sight: it comes next."""
    pressable = f'[id="{button}"]:not(:disabled)'
    return (
        f"{pressable}{{--wb-fill:var(--wb-primary);--wb-on-fill:#fff}}"
        f".mantine-Paper-root:has({pressable}){{--wb-stays:sticky}}"
    )


def named_css(named: Mapping[str, tuple[str, str, str]]) -> str:
    """Rules that name three numbers in a row otherwise than x, y and z.

    Args:
        named: by the id of the first of the three.
    """
    return "".join(
        f'.mantine-Flex-root:has(> .mantine-NumberInput-root [id="{first}"]){{'
        + "".join(f'--wb-{k}:"{css_text(name)}";' for k, name in enumerate(names, start=1))
        + "}"
        for first, names in named.items()
    )


def css_text(text: str) -> str:
    """A text as it may stand between quotes in a style sheet within HTML."""
    return "".join(
        char if char.isalnum() or char in " .,;:()+-_/%" else f"\\{ord(char):x} " for char in text
    )


def mark_attribute(is_chosen: bool) -> str:
    """The attribute, with a blank before it, of a row that is chosen or not."""
    return ' style="background:var(--wb-chosen)"' if is_chosen else ""


def funnel_html(
    candidates: Sequence[Candidate],
    only: Reason | None,
    buttons: Mapping[Reason | None, str],
    words: Words = IN_ENGLISH,
) -> str:
    """Of how many candidates the same is said; a click shows those alone."""
    counts = Counter(candidate.verdict.kind for candidate in candidates)
    chips = [_filter_chip("all", len(candidates), "#495057", only is None, buttons[None])]
    chips += [
        _filter_chip(
            words.render(kind.message),
            counts[kind],
            verdict_colour(kind),
            only is kind,
            buttons[kind],
        )
        for kind in VERDICT_KINDS
        if counts[kind]
    ]
    return f'<div class="wb-funnel">{"".join(chips)}</div>'


def by_part_html(
    candidates: Sequence[Candidate],
    only: int | None,
    buttons: Sequence[str],
    words: Words = IN_ENGLISH,
) -> str:
    """How many candidates work for each part, red for none; a click shows those of one part.

    Args:
        candidates: of all parts.
        only: the part that is shown alone, as in the scan.
        buttons: ids of the unseen buttons, by part.
        words: of who reads it.
    """
    working = Counter({candidate.detection: 0 for candidate in candidates})
    working.update(candidate.detection for candidate in candidates if candidate.verdict.is_ok)
    if len(working) < 2:
        return ""
    chips = [
        _filter_chip(f"{part + 1}:", count, GOOD if count else BAD, part == only, buttons[part])
        for part, count in sorted(working.items())
        if part < len(buttons)
    ]
    title = escape(words.say("Feasible by part"))
    return f'<div class="wb-funnel"><span class="wb-small">{title}</span>{"".join(chips)}</div>'


def _filter_chip(text: str, count: int, colour: str, is_on: bool, button: str) -> str:
    return (
        f'<span class="wb-filter" aria-pressed="{str(is_on).lower()}" '
        f'style="--wb-own:{colour}" {clickable(button)}>'
        f"{escape(text)} <b>{count}</b></span>"
    )


def candidates_html(
    candidates: Sequence[Candidate],
    shown: Sequence[int],
    order: CandidateOrder,
    *,
    headings: Mapping[Column, str],
    rows: Sequence[str],
    words: Words = IN_ENGLISH,
) -> str:
    """One page of the table.

    Args:
        candidates: all of them.
        shown: indices of those on this page.
        order: how they are sorted, for the arrow in the heading.
        headings: button ids by column.
        rows: button ids by place on the page.
        words: of who reads it.
    """
    head = "".join(
        f'<th class="wb-col-{column}" title="{escape(tip)}" {clickable(headings[column])}>'
        f"{escape(title)}{_arrow(order, column)}</th>"
        for column, (title, tip) in COLUMNS.items()
    )
    body = "".join(
        _row_html(candidates[number], rows[place], words) for place, number in enumerate(shown)
    )
    return (
        f'<div class="wb-rows"><table class="wb-table"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def chosen_html(place: int | None) -> str:
    """A style that marks the row at that place, counted from 0.

    A table that is written anew jumps back to its top; this leaves it alone.
    """
    if place is None:
        return '<style class="wb-style wb-row-mark"></style>'
    row = f".wb-table tbody tr:nth-child({place + 1})"
    rule = f"{row}{{background:var(--wb-chosen)}}"
    return f'<style class="wb-style wb-row-mark wb-row-chosen">{rule}</style>'


def _arrow(order: CandidateOrder, column: Column) -> str:
    if order.column != column:
        return ""
    return "<span> ▾</span>" if order.is_descending else "<span> ▴</span>"


def _row_html(candidate: Candidate, button: str, words: Words) -> str:
    verdict, kind = candidate.verdict, candidate.verdict.kind
    pair = " · ".join(verdict.pair) if verdict.pair is not None else words.render(verdict.note)
    distance = "" if verdict.distance is None else mm(verdict.distance)
    refused = "" if verdict.is_ok else ' class="wb-refused"'
    return (
        f'<tr{refused} title="{escape(words.render(verdict.message))}" {clickable(button)}>'
        f"<td>{candidate.detection + 1}</td>"
        f'<td translate="no" title="{escape(candidate.grasp_label)}">'
        f"{escape(candidate.grasp_label)}</td>"
        f'<td translate="no">{escape(candidate.arm)}</td>'
        f"<td>{badge(verdict_colour(kind), words.render(kind.message))}"
        f'<div class="wb-pair">{escape(pair)}</div></td>'
        f'<td class="wb-number">{escape(distance)}</td>'
        f'<td class="wb-number">{candidate.rank:.2f}</td></tr>'
    )
