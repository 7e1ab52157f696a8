"""Texts of the page around the tabs: control, presence, help."""

from workbench.model.messages.message import Text


class PageText(Text, subject="page-frame"):
    """Who is in control, what the page is of, and what went wrong with a tab."""

    CELL = "Cell {name}"
    RUN_TABS = "Run"
    SET_UP_TABS = "Set up"
    TAB_BROKEN = "This tab does not work: {problem}"
    HAND_OVER = "Hand over to {person}"
    TAKE_OVER = "Take over from {person}"
    TAKE_OVER_TITLE = "{person} is in control. Take control over?"
    TAKE_OVER_LOSS = "From then on {person} cannot act until control is handed back."
    TAKE_OVER_MOVES = "The robot moves. Taking over does not stop it."
    ASKS = "{person} asks for control"
    IN_CONTROL = "You are in control."
    OTHER_IN_CONTROL = "{person} is in control."
    OTHER_ASKED = "{person} is in control, you have asked."
    ENTRY = "Entry {number} of {total}"
    ENTRY_AT = "Entry {number} of {total}, {at}, {person}: {message}"
    AT_ZONE = "At [{zone}]"
    LINE_OF = "{label} ({number} of {total}): {note}"
    CANDIDATES = "{shown} of {total} candidates"
    CANDIDATES_PAGE = "{shown} of {total} candidates, page {page} of {pages}"
    PALLETS = "{count} {count:part lies|parts lie} on the pallets."
