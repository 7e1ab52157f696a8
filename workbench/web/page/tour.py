"""How far the pick has come that the page's tour leads through, and whom the tour is for.

The page itself says what to do in each step (`static/tour.js`); that something was really done it
hears from here, and from nothing that was pressed.
"""

from collections.abc import Sequence

from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import explain_unwatched
from workbench.app.core.people import Person
from workbench.app.core.state import Phase, State
from workbench.plugins.addresses import is_loopback

TOUR_STEPS = ("scan", "find", "plan", "preview", "approve", "send")
"""What the bench knows of, in the order in which it is done."""

REACHED = {
    Phase.IDLE: 0,
    Phase.SCANNED: 1,
    Phase.LOCALIZED: 2,
    Phase.PLANNED: 3,
    Phase.APPROVED: 5,
    Phase.SENDING: 5,
    Phase.DONE: 6,
    # After a fault a pick begins with a new scan.
    Phase.FAULT: 0,
}
"""How many of the steps are done."""


def tour_of(state: State, person: Person) -> Sequence[str] | None:
    """The steps done of the pick under way; None where no tour is given.

    Nobody learns at a real robot, and who may not send a plan cannot go the whole way.

    Args:
        state: of the bench.
        person: who looks at the page.
    """
    cell = state.cell
    is_simulated = cell.scanner.source == "simulated" and is_loopback(cell.controller.host)
    may = all(person.role.covers(command.right.role) for command in (TakeScan, SendPlan))
    return _steps_done(state, person) if is_simulated and may else None


def _steps_done(state: State, person: Person) -> Sequence[str]:
    """Those of `TOUR_STEPS` that are done, by whoever; this person has to have played the plan."""
    count = REACHED[state.phase]
    if state.phase is Phase.LOCALIZED and not state.detections:
        count = 1
    if state.phase is Phase.PLANNED and (state.proof is None or not state.proof.holds):
        count = 2
    elif state.phase is Phase.PLANNED and not explain_unwatched(state, person.name):
        count = 4
    return TOUR_STEPS[:count]
