"""What the robots of the scene are at this moment: one rule, said in words and in colour.

The solid robot is the real one, as its controller reports it.  The see-through one is planned: a
moment of the plan, or a robot that somebody moves by hand in their own view.
"""

import enum
from html import escape

from workbench.app.core.state import Phase
from workbench.gui.drawing.play_button import missed_words
from workbench.gui.shared.colours import CHECKED, PLANNED_ROBOT, verdict_colour
from workbench.gui.shared.look import AFTER_CYCLE, View
from workbench.gui.shared.solids import Colour
from workbench.model.candidate import kind_of


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
    Mode.JOG: "Ends with End jogging, Play, or Send",
    Mode.POSE: "Ends with a click on the row, Play, or Send",
    Mode.FILM: "Ends with End film, and with the next scan, plan, preview or sending",
}
"""What starts the next mode, where a person does."""

ENDS_AFTER_CYCLE = "Ends with End preview"
"""A preview of a plan that was sent already, or was as a fault came up."""

NOTES = {
    Mode.PREVIEW: "Parts: as planned; nothing is sent",
    Mode.END: "Parts: as planned; nothing was sent",
    Mode.FILM: "Parts: a simulated pile, not what is in the bin; nothing is sent",
}


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


def mode_html(view: View) -> str:
    """The mode with its legend, to be laid over the scene."""
    mode = mode_of(view)
    lines = _robots(view, mode)
    chosen, all_of_them = view.look.candidate, view.state.candidates or ()
    if chosen is not None and chosen < len(all_of_them):
        colour = verdict_colour(kind_of(all_of_them[chosen].verdict))
        lines.append(("See-through: the chosen candidate", f"background:{colour};opacity:0.7"))
    is_preview = mode in (Mode.PREVIEW, Mode.END)
    is_after = is_preview and view.state.phase in AFTER_CYCLE
    ends = ENDS_AFTER_CYCLE if is_after else ENDS.get(mode, "")
    if mode is Mode.WAITS:
        ends = f"Ends with Run step {view.state.waits}, or Stop"
    missed = missed_words(view) if mode is Mode.END else ""
    told = "".join(
        f'<li><i style="{style}"></i>{escape(text)}</li>' for text, style in lines if text
    )
    notes = (NOTES.get(mode, ""), missed, ends)
    told += "".join(f'<li class="wb-ends">{escape(text)}</li>' for text in notes if text)
    kind = mode.name.lower().replace("_", "-")
    return (
        f'<div class="wb-mode wb-mode-{kind}" data-mode="{kind}" role="status">'
        f"<b>{escape(mode)}</b><ul>{told}</ul></div>"
    )


def _robots(view: View, mode: Mode) -> list[tuple[str, str]]:
    """What robots are drawn, each with the style of its mark."""
    is_planned = bool(view.planned_arms) or mode in (Mode.JOG, Mode.POSE, Mode.FILM)
    if view.look.shapes:
        # There is one robot of these: where another one would be see-through, or else the real one.
        stands = STANDS[mode] if is_planned else _real(view)
        return [(f"Collision shapes: {stands}", f"background:rgb({_rgb(CHECKED)})")]
    is_alone = view.is_recorded or not (view.is_reported or view.own.hides_robot)
    lines = [] if view.planned_arms and is_alone else [(f"Solid: {_real(view)}", "")]
    if is_planned:
        lines.append(
            (f"See-through: {STANDS[mode]}", f"background:rgba({_rgb(PLANNED_ROBOT)},0.55)")
        )
    return lines


def _real(view: View) -> str:
    """Where the robot is drawn that is real."""
    if view.is_recorded:
        return "at home; where it stood is not recorded"
    if view.is_reported:
        return "the robot, as its controller reports it"
    return "drawn at home; the controller does not report where it is"


def _rgb(colour: Colour) -> str:
    return ",".join(str(one) for one in colour)
