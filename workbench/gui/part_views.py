"""The list of parts found, as HTML; see `views` for how."""

from collections.abc import Sequence
from html import escape

from workbench.gui.colours import part_colour
from workbench.gui.tables import clickable
from workbench.gui.views import mm
from workbench.model.scan import Detection

MOST_ROWS = 30
"""Parts that can be listed: as many as a bin may hold."""


def parts_html(found: Sequence[Detection], chosen: int, rows: Sequence[str]) -> str:
    """A table with a row for each part.

    Args:
        found: the parts.
        chosen: which row is marked.
        rows: ids of the unseen buttons, by row.
    """
    heads = (
        ("", "", ""),
        ("Part", "", ""),
        ("Score", "wb-number", "how well it explains what was seen there"),
        ("Seen", "wb-number", "share of the surface facing the scanner that was seen"),
        ("Gap", "wb-number", "by which it beats the second-best pose of the same object"),
        ("Residual", "wb-number", "distance of the scan from the part's surface, RMS"),
        ("Roll", "", "whether the scan shows the turn about the part's axis"),
    )
    head = "".join(
        f'<th class="{style}" title="{escape(tip)}">{title}</th>' for title, style, tip in heads
    )
    body = "".join(
        _row(number, one, number == chosen, rows[number])
        for number, one in enumerate(found[:MOST_ROWS])
    )
    return (
        f'<div class="wb-rows"><table class="wb-table wb-parts"><thead><tr>{head}</tr></thead>'
        f"<tbody>{body}</tbody></table></div>"
    )


def _row(number: int, one: Detection, is_chosen: bool, button: str) -> str:
    mark = ' style="background:var(--wb-chosen)"' if is_chosen else ""
    values = (
        f"{one.score:.2f}",
        f"{one.visible:.0%}",
        "" if one.gap is None else f"{one.gap:.2f}",
        "by hand" if one.residual is None else mm(one.residual, 2),
    )
    numbers = "".join(f'<td class="wb-number">{escape(value)}</td>' for value in values)
    dot = f'<span class="wb-verdict" style="background:{part_colour(number)}">{number + 1}</span>'
    return (
        f"<tr{mark} {clickable(button)}><td>{dot}</td><td>{escape(one.part)}</td>{numbers}"
        f"<td>{'known' if one.roll_known else 'unknown'}</td></tr>"
    )
