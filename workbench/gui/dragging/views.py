"""What is told of the candidates while something is dragged, as HTML."""

from collections import Counter
from html import escape

from workbench.gui.scene.live import kinds_in, live_words
from workbench.gui.shared.colours import KINDS, verdict_colour
from workbench.gui.shared.own import Dragged
from workbench.gui.shared.views import line


def dragged_html(dragged: Dragged | None) -> str:
    """How many candidates would work, and how many would be refused why; empty for None."""
    if dragged is None:
        return ""
    counts = Counter(kinds_in(dragged.glance))
    chips = "".join(
        f'<span class="wb-told-kind" style="--wb-own:{verdict_colour(kind)}">'
        f"{escape(kind)} <b>{counts[kind]}</b></span>"
        for kind in KINDS
        if counts[kind]
    )
    return line(live_words(dragged.glance)) + f'<div class="wb-funnel">{chips}</div>'
