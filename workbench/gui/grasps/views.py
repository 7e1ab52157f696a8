"""What the page says about a part's grasps, as HTML; see `views` for how."""

import json
import math
from collections.abc import Mapping, Sequence
from datetime import datetime
from html import escape

import numpy as np

from workbench.app.statistics.grasp_use import NO_USES, GraspUse, Uses
from workbench.formats.parts.saves import Version
from workbench.gui.shared.colours import BAD, BUSY, GOOD, MUTED
from workbench.gui.shared.tables import clickable, mark_attribute
from workbench.gui.shared.views import day_and_time, line, mm, sentence
from workbench.gui.texts.grasps import GraspText
from workbench.gui.texts.labels import LabelText
from workbench.model.geometry import Floats
from workbench.model.messages.message import Message, all_of, as_message
from workbench.model.part import Entry, GraspPair, GraspPattern, Part, grasps_of
from workbench.model.part_edits import grasp_of
from workbench.model.symmetry import Symmetry
from workbench.planning.grasps.firmness import in_words
from workbench.planning.grasps.grasp_check import GraspCheck
from workbench.planning.grasps.grasp_suggestions import Suggestion
from workbench.words.words import IN_ENGLISH, Words

MOST_ROWS = 40
"""Entries that can be listed; each has an unseen button."""

MOST_SUGGESTIONS = 20

POINT_KEYS = tuple(
    shift + arrow
    for shift in ("", "shift+")
    for arrow in ("arrowleft", "arrowright", "arrowup", "arrowdown")
) + ("enter", "escape")
"""What is typed to move the marked point of a surface, to take it, and to end that."""

POINT_HELP = (
    "Click on the surface, or move the point by the arrow keys, with Shift in small steps. "
    "Enter puts the grasp there, Escape ends."
)

POINT_TYPED = (
    "const id=JSON.parse(this.dataset.keys)[(event.shiftKey?'shift+':'')+event.key.toLowerCase()];"
    "if(id){event.preventDefault();event.stopPropagation();document.getElementById(id).click()}"
)
"""What a browser does with a key there: it presses the unseen button, and moves no camera."""

HEADS = (
    ("", "", "Green: the tool can take the part so; red: it cannot"),
    ("Grasp", "", "Name, and what it is"),
    ("Priority", "wb-number", "Higher ones are tried first"),
    ("Opening", "wb-number", "Between the fingers on arrival"),
    ("Arms", "", "Which arms may use it"),
    ("Possible", "wb-number", "Of the times it was tried for a part in the bin"),
    ("Succeeded", "wb-number", "Of the plans that went by it"),
)


def grasps_html(
    part: Part,
    chosen: str,
    checks: Mapping[str, GraspCheck | None],
    rows: Sequence[str],
    uses: Uses = NO_USES,
    words: Words = IN_ENGLISH,
) -> str:
    """A table with a row for each entry of a part's library.

    Args:
        part: whose.
        chosen: entry that is marked.
        checks: what was found about each entry; None while nobody has looked.
        rows: ids of the unseen buttons, by row.
        uses: how grasps have done in this session.
        words: of who reads it.
    """
    if not part.library.entries:
        if part.library.searches:
            return line(
                "No grasps: plans search grasps. Add grasp puts one on the part.", kind="hint"
            )
        return line("No grasps yet: press Add grasp, then click on the part.", kind="hint")
    head = "".join(
        f'<th class="{style}" title="{escape(tip)}">{title}</th>' for title, style, tip in HEADS
    )
    body = "".join(
        _row(
            entry,
            entry.name == chosen,
            checks.get(entry.name),
            rows[number],
            use_of(part.name, entry, uses),
            words,
        )
        for number, entry in enumerate(part.library.entries[:MOST_ROWS])
    )
    more = len(part.library.entries) - MOST_ROWS
    rest = line(words.render(GraspText.MORE(count=more)), kind="hint") if more > 0 else ""
    return (
        f'<div class="wb-list"><table class="wb-table wb-parts"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>{rest}"
    )


def use_of(part: str, entry: Entry, uses: Uses) -> GraspUse:
    """How a grasp has done, or all grasps of a pattern together."""
    names = {grasp.name for grasp in grasps_of(entry)}
    return sum((uses.get((part, name), GraspUse()) for name in sorted(names)), GraspUse())


def _row(
    entry: Entry,
    is_chosen: bool,
    check: GraspCheck | None,
    button: str,
    use: GraspUse,
    words: Words,
) -> str:
    grasp = grasp_of(entry)
    if not grasp.is_enabled:
        light, tip = MUTED, "disabled"
    elif check is None:
        light, tip = BUSY, "not checked yet"
    else:
        light, tip = (GOOD if check.is_ok else BAD), words.render(findings_message(check))
    possible = GraspText.POSSIBLE(count=use.possible, total=use.tried)
    if light == GOOD and use.tried and not use.possible:
        # It fits the part by itself, and never did as parts lay in the bin.
        light, tip = BUSY, words.render(possible)
    kind = f" <small>× {entry.count}</small>" if isinstance(entry, GraspPattern) else ""
    uses = GraspText.USES(planned=use.planned, taken=use.picked, failed=use.failed)
    taken = GraspText.TAKEN_OF(taken=use.picked, planned=use.planned) if use.planned else None
    return (
        f'<tr{mark_attribute(is_chosen)} title="{escape(tip)}" {clickable(button)}>'
        f'<td><i class="wb-dot" style="background:{light}"></i></td>'
        f'<td translate="no">{escape(grasp.name)}{kind}</td>'
        f'<td class="wb-number">{grasp.priority}</td>'
        f'<td class="wb-number">{escape(mm(grasp.opening))}</td>'
        f"<td>{escape(', '.join(grasp.arms) or 'all')}</td>"
        f'<td class="wb-number" title="{escape(words.render(possible))}">'
        f"{_share(use.possible, use.tried)}</td>"
        f'<td class="wb-number" title="{escape(words.render(uses))}">'
        f"{escape(words.render(taken))}</td></tr>"
    )


def _share(count: int, of: int) -> str:
    return f"{100 * count / of:.0f}%" if of else ""


def no_grasp(entry: Entry | None) -> str:
    """Why nothing can be done with the chosen grasp: there is none; empty when there is."""
    return "put a grasp on the part first" if entry is None else ""


def findings_message(check: GraspCheck) -> Message:
    """What speaks against a grasp with the tool that it was tried with, or that nothing does."""
    if check.findings:
        first, *others = (as_message(finding.text) for finding in check.findings)
        findings = all_of((first, *others)) or first
        return GraspText.FINDINGS(tool=check.tool, findings=findings)
    facts = [GraspText.CLEARANCE(clearance=check.clearance)]
    if check.width is not None:
        facts.insert(0, GraspText.HOLDS(width=check.width))
    if check.firmness is not None:
        facts.append(as_message(in_words(check.firmness)))
    return GraspText.TAKES(tool=check.tool, facts=facts)


def check_line(name: str, check: GraspCheck | None, words: Words = IN_ENGLISH) -> str:
    """What the close look at the chosen grasp says."""
    if check is None:
        return line("", kind="hint")
    checked = GraspText.CHECKED(name=name, text=findings_message(check))
    text = sentence(words.render(LabelText.SENTENCE(text=checked)))
    return line(text, kind="result" if check.is_ok else "bad")


def symmetry_line(symmetry: Symmetry, proposed: Symmetry | None, words: Words = IN_ENGLISH) -> str:
    """The symmetry that is said, and what the mesh looks like."""
    texts = [GraspText.SYMMETRY(symmetry=symmetry_message(symmetry))]
    if proposed is not None:
        texts.append(GraspText.MESH_SYMMETRY(symmetry=symmetry_message(proposed)))
    return line(" ".join(map(words.render, texts)))


def symmetry_message(symmetry: Symmetry) -> Message:
    """A symmetry for people."""
    if symmetry.is_none:
        return GraspText.NO_SYMMETRY()
    turns = [
        GraspText.FOLDS(count=axis.fold, axis=_triple(axis.axis))
        if axis.fold
        else GraspText.ANY_TURN(axis=_triple(axis.axis))
        for axis in symmetry.axes
    ]
    if not any(symmetry.point):
        return GraspText.ALIKE(turns=turns, symmetry=str(symmetry))
    point = _triple(1000 * np.array(symmetry.point))
    return GraspText.ALIKE_THROUGH(turns=turns, point=point, symmetry=str(symmetry))


def _triple(values: Floats) -> str:
    x, y, z = (f"{value:.3g}" for value in values)
    return f"({x}, {y}, {z})"


def suggestions_html(
    found: Sequence[Suggestion], chosen: int, rows: Sequence[str], shares: Mapping[str, float]
) -> str:
    """A table with a row for each suggestion, the best first.

    Args:
        found: the suggestions.
        chosen: the number of the one that is shown.
        rows: ids of unseen buttons.
        shares: 0 to 1, by names: of the ways to lie in the bin, those in which it can be taken.
    """
    heads = (
        ("Suggestion", ""),
        ("In the bin", "wb-number"),
        ("Score", "wb-number"),
        ("Holds", "wb-number"),
        ("Inclined", "wb-number"),
        ("Off centre", "wb-number"),
    )
    head = "".join(f'<th class="{style}">{title}</th>' for title, style in heads)
    body = "".join(
        f"<tr{mark_attribute(number == chosen)} {clickable(rows[number])}>"
        f'<td translate="no">{escape(suggestion.grasp.name)}</td>'
        f'<td class="wb-number">{shares.get(suggestion.grasp.name, 0.0):.0%}</td>'
        f'<td class="wb-number">{suggestion.score:.2f}</td>'
        f'<td class="wb-number">{escape(mm(suggestion.grasp.grip))}</td>'
        f'<td class="wb-number">{math.degrees(suggestion.angle):.0f}°</td>'
        f'<td class="wb-number">{escape(mm(suggestion.lever))}</td></tr>'
        for number, suggestion in enumerate(found[:MOST_SUGGESTIONS])
    )
    return (
        f'<div class="wb-list"><table class="wb-table wb-parts"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def refused_message(refused: Sequence[GraspCheck]) -> Message:
    """How many suggestions are not made since the part weighs too much, and the firmest of them."""
    best = max(refused, key=lambda check: check.findings[0].amount)
    finding = as_message(best.findings[0].text)
    return GraspText.TOO_HEAVY(count=len(refused), finding=finding)


def pairs_html(pairs: Sequence[GraspPair], words: Words = IN_ENGLISH) -> str:
    """Which grasps go together."""
    if not pairs:
        return line("No pairs: two arms may take parts by any grasps.", kind="hint")
    texts = (
        (GraspText.PAIR_ORDERED if pair.is_ordered else GraspText.PAIR)(
            first=pair.first, second=pair.second
        )
        for pair in pairs
    )
    items = "".join(f"<li>{escape(words.render(text))}</li>" for text in texts)
    return f'<div class="wb-tree"><ul>{items}</ul></div>'


def versions_html(versions: Sequence[Version]) -> str:
    """Who has saved the grasps, when and why, newest first."""
    if not versions:
        return line("Nothing was saved from here yet.", kind="hint")
    body = "".join(
        f"<tr><td>{version.number}</td><td>{escape(_when(version))}</td>"
        f'<td translate="no">{escape(version.by)}</td>'
        f'<td translate="no">{escape(version.remark)}</td></tr>'
        for version in reversed(versions)
    )
    return (
        '<div class="wb-list"><table class="wb-facts"><thead><tr><th>No</th><th>At</th>'
        f"<th>By</th><th>Remark</th></tr></thead><tbody>{body}</tbody></table></div>"
    )


def _when(version: Version) -> str:
    """When it was saved, as the page shows times; what somebody has written there stays."""
    try:
        return day_and_time(datetime.fromisoformat(version.at).timestamp())
    except (ValueError, OverflowError):
        return version.at


def texts_html(texts: Sequence[Message | str], otherwise: str, words: Words = IN_ENGLISH) -> str:
    """Sentences as a list."""
    if not texts:
        return line(otherwise, kind="hint")
    items = "".join(f"<li>{escape(words.render(text))}</li>" for text in texts[:MOST_ROWS])
    return f'<div class="wb-tree"><ul>{items}</ul></div>'


def point_box(buttons: Mapping[str, str]) -> str:
    """What takes the keys for a point of the surface, and gets the focus as it appears.

    Args:
        buttons: the id of the unseen button by each of `POINT_KEYS`.
    """
    return (
        f'<div class="wb-point" tabindex="0" role="application" data-focus '
        f'data-keys="{escape(json.dumps(dict(buttons)))}" onkeydown="{POINT_TYPED}" '
        f'aria-label="{POINT_HELP}">{POINT_HELP}</div>'
    )


def point_line(text: str) -> str:
    """Where the marked point is; read out as it changes."""
    return f'<div class="wb-said wb-line wb-result wb-span3">{escape(text)}</div>'
