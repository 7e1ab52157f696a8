"""The list of parts found, as HTML; see `views` for how."""

import math
from collections.abc import Sequence
from html import escape

from workbench.app.core.state import State
from workbench.gui.shared.colours import badge, part_colour
from workbench.gui.shared.tables import MOST_PARTS, clickable, mark_attribute
from workbench.gui.shared.views import clock, line, mm, table_html
from workbench.gui.texts.parts import PartsText
from workbench.model.messages.message import Message, as_message
from workbench.model.scan import Detection, PosesFolder, RejectedHypothesis, Remark
from workbench.words.words import IN_ENGLISH, Words


def parts_html(
    found: Sequence[Detection],
    chosen: int | None,
    rows: Sequence[str],
    words: Words = IN_ENGLISH,
    fates: Sequence[Message | None] = (),
) -> str:
    """A table with a row for each part.

    Args:
        found: the parts.
        chosen: which row is marked, None: none is.
        rows: ids of the unseen buttons, by row.
        words: of who reads it.
        fates: what the plans do with each part, in a line below its row; None: no line.
    """
    heads = (
        ("", "", ""),
        ("Part", "", ""),
        ("Score", "wb-number", "how well it explains what was seen there"),
        ("Seen", "wb-number", "share of the surface facing the scanner that was seen"),
        ("Lead", "wb-number", "by which it beats the second-best pose of the same object"),
        ("Residual", "wb-number", "distance of the scan from the part's surface, RMS"),
        ("Sure", "wb-number", "of detections that say 90%, nine in ten are right"),
        ("Within", "wb-number", "standard deviation of place and turn, in the direction of most"),
        ("Roll", "", "whether the scan shows the turn about the part's axis"),
    )
    head = "".join(
        f'<th class="{style}" title="{escape(tip)}">{title}</th>' for title, style, tip in heads
    )
    body = "".join(
        _row(number, detection, number == chosen, rows[number], words)
        + _fate_row(fate, rows[number], words, is_chosen=number == chosen)
        for number, (detection, fate) in enumerate(
            zip(found[:MOST_PARTS], fates or [None] * len(found), strict=False)
        )
    )
    return (
        f'<div class="wb-rows"><table class="wb-table wb-parts"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def avoided_html(state: State, at: float, words: Words = IN_ENGLISH) -> str:
    """Where picks have failed, and how much longer parts are left alone there; `at` is now [s]."""
    rows: list[tuple[str, str]] = []
    for entry in state.avoided:
        minutes = math.ceil((entry.until - at) / 60)
        if minutes <= 0:
            continue
        x, y, _ = (round(1000 * value) for value in entry.p_bin)
        avoided = PartsText.AVOIDED_NOW(minutes=minutes)
        if entry.scans:
            avoided = PartsText.AVOIDED_FOR(scans=entry.scans, minutes=minutes)
        if entry.why:
            avoided = PartsText.NOTED(text=avoided, why=as_message(entry.why))
        place = PartsText.PLACE(part=entry.part, x=x, y=y)
        rows.append((words.render(place), words.render(avoided)))
    return table_html(rows) if rows else ""


def remarks_html(
    remarks: Sequence[Remark], folder: PosesFolder | None, words: Words = IN_ENGLISH
) -> str:
    """Who has changed what was found, the latest first, and which folder is watched for poses."""
    rows = "".join(
        f'<tr><th>{clock(remark.at)}</th><td translate="no">{escape(remark.by)}</td>'
        f"<td>{escape(words.render(remark.says))}</td></tr>"
        for remark in reversed(remarks)
    )
    table = f'<table class="wb-facts wb-remarks">{rows}</table>' if rows else ""
    if folder is None:
        return table
    watched = words.render(PartsText.WATCHED(folder=str(folder.path)))
    return table + line(watched, kind="hint")


def rejected_html(rejected: Sequence[RejectedHypothesis], words: Words = IN_ENGLISH) -> str:
    """A fold that lists the rejected hypotheses, and why they are no parts."""
    texts = (
        PartsText.HYPOTHESIS(
            score=hypothesis.score, part=hypothesis.part, why=as_message(hypothesis.words)
        )
        for hypothesis in rejected
    )
    rows = "".join(f"<li>{escape(words.render(text))}</li>" for text in texts)
    title = words.render(PartsText.REJECTED(count=len(rejected)))
    return (
        '<div class="wb-tree wb-rejected"><details>'
        f"<summary>{escape(title)}</summary><ul>{rows}</ul></details></div>"
    )


def _deviations(detection: Detection) -> str:
    """Of place and turn, below each other."""
    if detection.deviations is None:
        return ""
    place, turn = detection.deviations
    return f"{mm(place, 2)}<br>{math.degrees(turn):.1f}°"


def _residual(detection: Detection) -> str:
    return "by hand" if detection.residual is None else mm(detection.residual, 2)


def _row(number: int, detection: Detection, is_chosen: bool, button: str, words: Words) -> str:
    values = (
        "" if detection.is_by_hand else f"{detection.score:.2f}",
        "" if detection.is_by_hand else f"{detection.visible:.0%}",
        "" if detection.gap is None else f"{detection.gap:.2f}",
        _residual(detection),
        "" if detection.probability is None else f"{detection.probability:.0%}",
    )
    numbers = "".join(f'<td class="wb-number">{escape(value)}</td>' for value in values)
    dot, name = badge(part_colour(number), str(number + 1)), escape(detection.part)
    # Narrow lists leave these columns out (static/tables.css).
    left_out = {"Lead": values[2], "Residual": values[3]}
    tip = escape(", ".join(f"{words.say(k)}: {words.say(v)}" for k, v in left_out.items() if v))
    return (
        f'<tr{mark_attribute(is_chosen)} title="{tip}" {clickable(button)}><td>{dot}</td>'
        f'<td translate="no" title="{name}">{name}</td>{numbers}'
        f'<td class="wb-number">{_deviations(detection)}</td>'
        f"<td>{escape(_roll(detection))}</td></tr>"
    )


def _fate_row(fate: Message | None, button: str, words: Words, *, is_chosen: bool) -> str:
    """What becomes of a part, below its row; a click chooses the part, as one on its row does."""
    if fate is None:
        return ""
    text = escape(words.render(fate))
    press = f"document.getElementById('{escape(button)}').click()"
    return (
        f'<tr class="wb-fate"{mark_attribute(is_chosen)} onclick="{press}"><td></td>'
        f'<td colspan="8" title="{text}"><div>{text}</div></td></tr>'
    )


def _roll(detection: Detection) -> str:
    """Whether the turn is known, and by what where it was left to colours."""
    if detection.is_by_hand:
        return "by hand"
    if detection.by_colour is None:
        return "known" if detection.roll_known else "unknown"
    if detection.by_colour:
        return "known, by colour" if detection.roll_known else "unknown, kind by colour"
    return "known, by shape alone" if detection.roll_known else "unknown, by shape alone"
