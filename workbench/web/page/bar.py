"""What the bar above the scene says of the robot, and whether it may be stopped from here.

It belongs to the page around the scene: it is there on every tab, at every size, and still when
the scene hangs.
"""

from collections.abc import Callable, Mapping
from typing import Any

from workbench.app.core.cycle.sending import Stop, step_reported
from workbench.app.core.people import Person
from workbench.app.core.rights import lacks_right, obstacle
from workbench.app.core.state import Phase, State
from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.model.errors import WorkbenchError
from workbench.model.messages.message import Message, all_of, as_message
from workbench.model.messages.work import LinkText
from workbench.web.page.tour import tour_of
from workbench.web.texts import BarText

Bar = Callable[[Person], Mapping[str, Any]]
"""Says what stands in somebody's bar."""


def without_robot(person: Person) -> Mapping[str, Any]:
    """Nothing of a robot, for a page that has none."""
    return NO_ROBOT


def bar_of(bench: Bench | History) -> Bar:
    """The bar of a bench, or of a recorded session, which has no robot."""
    if isinstance(bench, History):
        return lambda person: RECORDED
    return lambda person: bar_words(bench.state, bench.live, person)


Stopper = Callable[[Person], str]
"""Stops the robot in somebody's name; why it was not stopped, or an empty text."""


def stop_nothing(person: Person) -> str:
    """The stop of a page that has no robot."""
    return str(NO_ROBOT["why"])


def stop_of(bench: Bench | History) -> Stopper:
    """The stop of a bench; a recorded session has none."""
    if isinstance(bench, History):
        return lambda person: str(RECORDED["why"])

    def stop(person: Person) -> str:
        try:
            bench.do(Stop(), person.name, person.role)
        except WorkbenchError as error:
            return str(error)
        return ""

    return stop


NO_ROBOT: Mapping[str, Any] = {
    "robot": "",
    "kind": "off",
    "fault": "",
    "can_stop": False,
    "why": "there is no robot",
    "has_robot": False,
    "tour": None,
}

RECORDED: Mapping[str, Any] = {
    **NO_ROBOT,
    "robot": "Recorded session",
    "kind": "recorded",
    "why": "this is a recorded session",
}


def bar_words(state: State, live: Live, person: Person) -> Mapping[str, Any]:
    """The robot in a few words, with the `kind` of news they are; the fault; Stop; and the tour.

    Args:
        state: of the bench.
        live: what goes on there.
        person: whose bar it is.
    """
    robot, kind = _robot(state, live)
    why = lacks_right(state, Stop, person.name, person.role) or obstacle(state, Stop)
    # How a stop ended belongs to it: that nobody saw the robot stand must not stay in a tab.
    # Where the fault has it in it already, once is enough.
    # A link of somebody else may report a plain text.
    stop = as_message(live.link.stop) if live.link.stop else None
    fault = (state.fault, stop) if state.phase is Phase.FAULT else ()
    if isinstance(state.fault, Message) and stop is not None and state.fault.part(stop.text):
        fault = (state.fault,)
    return {
        "robot": robot,
        "kind": kind,
        "fault": all_of(as_message(text) for text in fault if text) or "",
        "can_stop": not why,
        "why": why or "",
        "has_robot": True,
        "tour": tour_of(state, person),
    }


def _robot(state: State, live: Live) -> tuple[Message | str, str]:
    if state.phase is Phase.SENDING:
        robot = as_message(live.robot or "does not report")
        # The journal's step, as everywhere on the page: the link is often ahead by one.
        number = step_reported(state)
        if number and state.plan is not None:
            total = len(state.plan.sequence)
            step = BarText.SENDING_STEP(state=robot, number=number, total=total)
            return step, "busy"
        return BarText.SENDING(state=robot), "busy"
    if not live.robot:
        return "Robot: no report", "off"
    is_fault = live.robot.text is LinkText.FAULT
    text = BarText.SIMULATED if state.cell.controller.is_simulated else BarText.ROBOT
    # While a fault is open, nothing is green.
    usual = "off" if state.phase is Phase.FAULT else "good"
    return text(state=live.robot), "bad" if is_fault else usual
