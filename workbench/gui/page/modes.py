"""What the robots of the scene are at this moment: one rule, said in words and in colour.

The solid robot is the real one, as its controller reports it.  It is grey where the controller
does not report: it stands as it was reported last, or at home.  The see-through one is planned: a
moment of the plan, or a robot that somebody moves by hand in their own view.
"""

import enum
from html import escape

from workbench.app.core.state import Phase
from workbench.gui.drawing.play_button import missed_message
from workbench.gui.shared.colours import (
    BAD,
    CHECKED,
    COMPARED,
    NOT_REPORTED,
    PLANNED_ROBOT,
    PLATE,
    verdict_colour,
)
from workbench.gui.shared.look import AFTER_CYCLE, View
from workbench.gui.shared.solids import Colour
from workbench.gui.shared.views import when
from workbench.gui.texts.scene import LegendText
from workbench.model.messages.message import Message, plain
from workbench.words.words import IN_ENGLISH, Words


class Mode(enum.StrEnum):
    """What a browser looks at; the value is what the page calls it."""

    LIVE = "Live"
    NO_REPORT = "No report"
    MOVING = "Robot moves"
    WAITS = "Robot waits"
    PREVIEW = "Preview"
    END = "End of preview"
    JOG = "Jog"
    POSE = "Scanned pose"
    FILM = "Simulation"
    RECORDED = "Recorded"


STANDS = {
    Mode.LIVE: "where the plan has it",
    Mode.NO_REPORT: "where the plan has it",
    Mode.MOVING: "where the plan has it",
    Mode.WAITS: "where the plan has it",
    Mode.PREVIEW: "where the plan has it",
    Mode.END: "where the plan has it",
    Mode.JOG: "moved by you, in your view alone",
    Mode.POSE: "as it stood when the plate was scanned",
    Mode.FILM: "empties a simulated pile, in your view alone",
    Mode.RECORDED: "the recorded plan",
}
"""Where the see-through robot stands."""

ENDS = {
    Mode.PREVIEW: "Ends with To the start, or Send",
    Mode.END: "Ends with To the start, or Send",
    Mode.JOG: "Ends with End jogging in the tab Cell, Play, or Send",
    Mode.POSE: "Ends with a click on the row, Play, or Send",
    Mode.FILM: "Ends with End film, and with the next scan, plan, preview or sending",
}
"""What starts the next mode, where a person does."""

ENDS_AFTER_CYCLE = "Ends with End preview"
"""A preview of a plan that was sent already, or was as a fault came up."""

NOTES = {
    Mode.LIVE: "Parts: where the plan has them",
    Mode.NO_REPORT: "Parts: where the plan has them",
    Mode.PREVIEW: "Parts: as planned; nothing is sent",
    Mode.END: "Parts: where hands let go of them, not yet fallen; nothing was sent",
    Mode.FILM: "Parts: a simulated pile, not what is in the bin; nothing is sent",
}


Entry = tuple[Message | str, str]
"""A line of the legend, and the style of its mark."""

HIDDEN_NOW = "The hands are out of view: this part does not count as watched"


def mode_of(view: View) -> Mode:
    """What this browser looks at."""
    if view.filmed is not None:
        return Mode.FILM
    if view.jogged is not None:
        return Mode.JOG
    if view.overlay is not None:
        return Mode.POSE
    if view.is_recorded:
        return Mode.RECORDED
    if view.state.phase is Phase.SENDING:
        return Mode.WAITS if view.state.waits else Mode.MOVING
    if view.is_previewed:
        is_over = not view.look.is_playing and view.look.time >= view.plan_seconds
        return Mode.END if is_over else Mode.PREVIEW
    return Mode.LIVE if view.is_reported else Mode.NO_REPORT


def mode_html(view: View, ends_comparing: str = "", words: Words = IN_ENGLISH) -> str:
    """The mode with its legend, to be laid over the scene.

    Args:
        view: what this browser looks at.
        ends_comparing: id of a button, which the page around the scene presses when the table of
            the searches that are compared here is out of sight; empty: another browser has it.
        words: of who reads it.
    """
    mode = mode_of(view)
    lines = _robots(view, mode)
    chosen, all_of_them = view.look.candidate, view.state.candidates or ()
    if chosen is not None and chosen < len(all_of_them):
        colour = verdict_colour(all_of_them[chosen].verdict.kind)
        lines.append(("See-through: the chosen candidate", f"background:{colour};opacity:0.7"))
        if view.pose is not None and view.pose.meets:
            lines.append(("Red: the bodies that come too close there", f"background:{BAD}"))
    lines += _of_searches(view)
    if mode is Mode.JOG and view.own.plate is not None:
        style = f"background:rgb({_rgb(PLATE)})"
        lines.append(("Blue balls: the plate as the suggestion assumes it", style))
    is_preview = mode in (Mode.PREVIEW, Mode.END)
    is_after = is_preview and view.state.phase in AFTER_CYCLE
    ends: Message | str = ENDS_AFTER_CYCLE if is_after else ENDS.get(mode, "")
    if mode is Mode.WAITS:
        ends = LegendText.ENDS_WITH_STEP(number=view.state.waits)
    missed = _missing(view, mode) if is_preview else None
    rows = "".join(
        f'<li><i style="{style}"></i>{escape(words.render(text))}</li>' for text, style in lines
    )
    # Before it is played and sent, the plan has the parts where they were found.
    is_found = mode in (Mode.LIVE, Mode.NO_REPORT) and not (view.state.plan and view.look.time > 0)
    notes = map(words.render, ("" if is_found else NOTES.get(mode), missed, ends))
    rows += "".join(f'<li class="wb-ends">{escape(text)}</li>' for text in notes if text)
    if ends_comparing and view.look.search is not None:
        rows += f'<li class="wb-compares" data-ends="{escape(ends_comparing)}"></li>'
    kind = mode.name.lower().replace("_", "-")
    return (
        f'<div class="wb-mode wb-mode-{kind}" data-mode="{kind}" role="status">'
        f"<b>{escape(mode)}</b><ul>{rows}</ul></div>"
    )


def _missing(view: View, mode: Mode) -> Message | str | None:
    """What has to be played before the plan counts as watched; while it plays, what does not."""
    if view.state.phase not in (Phase.PLANNED, Phase.APPROVED) or not view.unseen:
        return None
    if mode is not Mode.END:
        is_now = bool(view.hidden) and view.hidden[-1][1] == view.look.time
        return HIDDEN_NOW if is_now and view.look.is_playing else None
    return missed_message(view)


def _of_searches(view: View) -> list[Entry]:
    """What searches have found besides, or have rejected, as far as it is drawn."""
    lines: list[Entry] = []
    searches = view.state.searches
    for place, search in enumerate(searches, 1):
        if search.number == view.look.search:
            style = f"background:rgba({_rgb(COMPARED)},0.55)"
            lines.append((LegendText.SEARCH(number=place), style))
    if view.look.rejected and view.rejected:
        lines.append(("Red, see-through: poses that the search rejected", f"background:{BAD}40"))
    return lines


def _robots(view: View, mode: Mode) -> list[Entry]:
    """What robots are drawn, each with the style of its mark."""
    is_planned = bool(view.planned_arms) or mode in (Mode.JOG, Mode.POSE, Mode.FILM)
    if view.look.shapes:
        # There is one robot of these: where another one would be see-through, or else the real one.
        where = plain(STANDS[mode]) if is_planned else _real(view)
        return [(LegendText.SHAPES(where=where), f"background:rgb({_rgb(CHECKED)})")]
    is_placed = view.is_reported or view.was_reported
    is_alone = view.is_recorded or not (is_placed or view.own.hides_robot)
    lines = [] if view.planned_arms and is_alone else [_solid(view)]
    if is_planned:
        style = f"background:rgba({_rgb(PLANNED_ROBOT)},0.55)"
        lines.append((LegendText.TRANSPARENT(where=plain(STANDS[mode])), style))
    return lines


def _solid(view: View) -> Entry:
    """What the solid robot is, with the style of its mark."""
    if view.is_reported:
        return LegendText.SOLID(where=_real(view)), ""
    return LegendText.GREY(where=_real(view)), f"background:rgb({_rgb(NOT_REPORTED)})"


def _real(view: View) -> Message:
    """Where the robot is drawn that is real."""
    if view.is_recorded:
        return plain("at home; where it stood is not recorded")
    if view.is_reported:
        return plain("the robot, as its controller reports it")
    if view.was_reported:
        return LegendText.REPORTED_LAST(at=when(view.live.reported_at, view.at))
    return plain("drawn at home; the controller does not report where it is")


def _rgb(colour: Colour) -> str:
    return ",".join(str(channel) for channel in colour)
