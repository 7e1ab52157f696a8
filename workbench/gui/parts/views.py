"""The list of parts found, as HTML; see `views` for how."""

import math
from collections.abc import Sequence
from html import escape

from workbench.app.core.state import State
from workbench.gui.shared.colours import part_colour
from workbench.gui.shared.tables import clickable, marked
from workbench.gui.shared.views import clock, line, mm, table_html
from workbench.model.scan import Detection, PosesFolder, RejectedHypothesis, Remark

MOST_ROWS = 30
"""Parts that can be listed: as many as a bin may hold."""


def parts_html(found: Sequence[Detection], chosen: int | None, rows: Sequence[str]) -> str:
    """A table with a row for each part.

    Args:
        found: the parts.
        chosen: which row is marked, None: none is.
        rows: ids of the unseen buttons, by row.
    """
    heads = (
        ("", "", ""),
        ("Part", "", ""),
        ("Score", "wb-number", "how well it explains what was seen there"),
        ("Seen", "wb-number", "share of the surface facing the scanner that was seen"),
        ("Gap", "wb-number", "by which it beats the second-best pose of the same object"),
        ("Residual", "wb-number", "distance of the scan from the part's surface, RMS"),
        ("Sure", "wb-number", "of detections that say 90 %, nine in ten are right"),
        ("Within", "wb-number", "standard deviation of place and turn, in the direction of most"),
        ("Roll", "", "whether the scan shows the turn about the part's axis"),
    )
    head = "".join(
        f'<th class="{style}" title="{escape(tip)}">{title}</th>' for title, style, tip in heads
    )
    body = "".join(
        _row(number, detection, number == chosen, rows[number])
        for number, detection in enumerate(found[:MOST_ROWS])
    )
    return (
        f'<div class="wb-rows"><table class="wb-table wb-parts"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def avoided_html(state: State, at: float) -> str:
    """Where picks have failed, and how much longer parts are left alone there; `at` is now [s]."""
    rows: list[tuple[str, str]] = []
    for entry in state.avoided:
        minutes = math.ceil((entry.until - at) / 60)
        if minutes <= 0:
            continue
        x, y, _ = (1000 * value for value in entry.p_bin)
        scans = "the next scan" if entry.scans == 1 else f"{entry.scans} more scans"
        ends = f"for {scans}" if entry.scans else "in this scan"
        why = f" ({entry.why})" if entry.why else ""
        place = f"{entry.part} at {x:.0f}, {y:.0f} mm in the bin"
        rows.append((place, f"avoided {ends}, at most {minutes} min{why}"))
    return table_html(rows) if rows else ""


def remarks_html(remarks: Sequence[Remark], folder: PosesFolder | None) -> str:
    """Who has changed what was found, the latest first, and which folder is watched for poses."""
    rows = "".join(
        f"<tr><th>{clock(remark.at)}</th><td>{escape(remark.by)}</td><td>{escape(str(remark.says))}</td></tr>"
        for remark in reversed(remarks)
    )
    table = f'<table class="wb-facts wb-remarks">{rows}</table>' if rows else ""
    watched = f"Poses that come into {folder.path} are taken." if folder is not None else ""
    return table + (line(watched, kind="hint") if watched else "")


def rejected_html(rejected: Sequence[RejectedHypothesis]) -> str:
    """A fold that lists the rejected hypotheses, and why they are no parts."""
    rows = "".join(
        f"<li>{hypothesis.score:.2f} {escape(hypothesis.part)}: {escape(why)}</li>"
        for hypothesis in rejected
        for why in (str(hypothesis.words),)
    )
    return (
        '<div class="wb-tree wb-rejected"><details>'
        f"<summary>{len(rejected)} poses rejected</summary><ul>{rows}</ul></details></div>"
    )


def _deviations(detection: Detection) -> str:
    if detection.deviations is None:
        return ""
    place, turn = detection.deviations
    # Where it does not fit it goes on below, number and unit together.
    return f"{mm(place, 2)}, {math.degrees(turn):.1f}°".replace(" mm", "\u00a0mm")


def _row(number: int, detection: Detection, is_chosen: bool, button: str) -> str:
    values = (
        f"{detection.score:.2f}",
        f"{detection.visible:.0%}",
        "" if detection.gap is None else f"{detection.gap:.2f}",
        "by hand" if detection.residual is None else mm(detection.residual, 2),
        "" if detection.probability is None else f"{detection.probability:.0%}",
        _deviations(detection),
    )
    numbers = "".join(f'<td class="wb-number">{escape(value)}</td>' for value in values)
    dot = f'<span class="wb-verdict" style="background:{part_colour(number)}">{number + 1}</span>'
    return (
        f"<tr{marked(is_chosen)} {clickable(button)}><td>{dot}</td>"
        f"<td>{escape(detection.part)}</td>{numbers}<td>{escape(_roll(detection))}</td></tr>"
    )


def _roll(detection: Detection) -> str:
    """Whether the turn is known, and by what where it was left to colours."""
    if detection.by_colour is None:
        return "known" if detection.roll_known else "unknown"
    if detection.by_colour:
        return "known, by colour" if detection.roll_known else "unknown, kind by colour"
    return "known, by shape alone" if detection.roll_known else "unknown, by shape alone"
