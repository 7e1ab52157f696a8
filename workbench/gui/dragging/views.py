"""The text about the candidates while something is dragged, as HTML."""

import enum
from collections import Counter
from html import escape

from workbench.gui.scene.drag_overlay import kinds_in, live_message
from workbench.gui.shared.colours import VERDICT_KINDS, verdict_colour
from workbench.gui.shared.own import Dragged
from workbench.gui.shared.views import line
from workbench.words.words import IN_ENGLISH, Words

BEFORE = "While you drag, this says how many candidates would work there."


class VerdictRoom(enum.Enum):
    """What stands where verdicts will stand, so that nothing below moves as a drag begins."""

    NONE = enum.auto()
    EMPTY = enum.auto()
    HINT = enum.auto()


def dragged_html(
    dragged: Dragged | None, room: VerdictRoom = VerdictRoom.NONE, words: Words = IN_ENGLISH
) -> str:
    """How many candidates would work, and how many would be refused why; for None the `room`."""
    if dragged is None and room is VerdictRoom.NONE:
        return ""
    if dragged is None:
        note = line(BEFORE, kind="hint") if room is VerdictRoom.HINT else ""
        return f'<div class="wb-live">{note}</div>'
    counts = Counter(kinds_in(dragged.glance))
    chips = "".join(
        f'<span class="wb-told-kind" style="--wb-own:{verdict_colour(kind)}">'
        f"{escape(words.render(kind.message))} <b>{counts[kind]}</b></span>"
        for kind in VERDICT_KINDS
        if counts[kind]
    )
    note = (
        line(words.render(live_message(dragged.glance))) + f'<div class="wb-funnel">{chips}</div>'
    )
    return f'<div class="wb-live">{note}</div>'
