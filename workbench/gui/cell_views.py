"""What the page says about the cell itself, as HTML; see `views` for how."""

from html import escape

from workbench.app.state import State
from workbench.gui.look import Jogged
from workbench.gui.marks import measured_text
from workbench.gui.views import line, mm
from workbench.model.geometry import Floats

MOST_CONTACTS = 8


def cell_line(state: State) -> str:
    """Whether the cell is as in its file, and what is wrong with the file."""
    if state.cell_problem:
        return line(f"The cell file cannot be used: {state.cell_problem}", kind="bad")
    if state.saved != state.cell.digest:
        return line(f"Changed and not saved; {len(state.before)} changes can be undone.")
    return line(f"As in its file; digest {state.cell.digest[:12]}.", kind="hint")


def measured_line(points: tuple[Floats, ...]) -> str:
    """The distance of two clicked points, or nothing."""
    if len(points) < 2:
        return ""
    return line(measured_text(*points).replace("\n", ": "))


def contacts_html(jogged: Jogged | None) -> str:
    """What the jogged robot meets, nearest first, or how much room it has."""
    if jogged is None:
        return line("Moves the robot on the page only; nothing is sent to it.", kind="hint")
    if not jogged.contacts:
        if jogged.pair is None:
            return line("Clear of everything by more than 100 mm.")
        first, second = jogged.pair
        return line(f"Clear; nearest are {first} and {second}, {mm(jogged.clearance)}.")
    rows = "".join(
        f"<tr><td>{escape(contact.pair[0])}</td><td>{escape(contact.pair[1])}</td>"
        f'<td class="wb-number">{escape(_distance(contact.distance))}</td></tr>'
        for contact in jogged.contacts[:MOST_CONTACTS]
    )
    more = len(jogged.contacts) - MOST_CONTACTS
    rest = line(f"and {more} more", kind="hint") if more > 0 else ""
    return (
        '<table class="wb-facts wb-contacts"><thead><tr><th>Too close</th><th></th>'
        f'<th class="wb-number">Distance</th></tr></thead><tbody>{rows}</tbody></table>{rest}'
    )


def _distance(metres: float) -> str:
    return f"{mm(-metres)} inside" if metres < 0 else mm(metres)
