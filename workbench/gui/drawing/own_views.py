"""The view of one browser: what all share, and what somebody does there alone."""

from dataclasses import replace

from workbench.app.core.state import State
from workbench.gui.cell.jog import JogFinder
from workbench.gui.emptying.reel import Projector
from workbench.gui.shared.calibrating import Overlay, overlay
from workbench.gui.shared.look import FilmMoment, Jogged, View
from workbench.gui.shared.own import Own
from workbench.model.calibration import Calibration


class OwnViews:
    """Works out what belongs to one browser alone, when that has changed.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self._jogger = JogFinder()
        self._projector = Projector()

    def of(self, own: Own, before: View | None, shared: View) -> View:
        """The view of a browser.

        Args:
            own: its look.
            before: its view before, None when it has had none.
            shared: what all see now.
        """
        over = _overlay(own, before, shared)
        # A scanned pose lies over the robot that is jogged, which is back afterwards.
        jogged = None if over is not None else self._jog_contacts(own, before, shared.state)
        filmed = self._film_moment(own, before, shared.state)
        return replace(shared, own=own, jogged=jogged, overlay=over, filmed=filmed)

    def _film_moment(self, own: Own, before: View | None, state: State) -> FilmMoment | None:
        """The moment of a film that is shown, worked out when it is another one."""
        if own.film is None:
            return None
        if before is not None and before.own.film is own.film and before.filmed is not None:
            return before.filmed
        return self._projector.moment(state.cell, own.film)

    def _jog_contacts(self, own: Own, before: View | None, state: State) -> Jogged | None:
        """What the jogged robot meets, worked out when it has moved."""
        if own.jog is None:
            return None
        is_same = before is not None and before.own.jog is own.jog and before.state is state
        if is_same and before is not None and before.jogged is not None:
            return before.jogged
        return self._jogger.check_jog(state, own.jog)


def is_news(old: View, new: View) -> bool:
    """Whether something has happened that ends a film: something real, or other piles emptied."""
    before, now = old.state, new.state
    return before is not now and (
        before.phase is not now.phase
        or before.scan is not now.scan
        or before.detections is not now.detections
        or before.plan is not now.plan
        or before.emptying is not now.emptying
    )


def has_lost_observation(own: Own, before: State | None, state: State) -> bool:
    """Whether the chosen pose was removed, as in another window: its number is another's then.

    Args:
        own: the look of one browser.
        before: the state that its number is of, None when that is not known.
        state: as it is now.
    """
    number = own.observation
    if number is None or number >= len(state.observations):
        return number is not None
    was = before.observations[number : number + 1] if before is not None else ()
    return any(observation.name != state.observations[number].name for observation in was)


def _overlay(own: Own, before: View | None, shared: View) -> Overlay | None:
    """The chosen pose over the robot, worked out when another one is chosen."""
    state, found = shared.state, shared.calibration
    if own.observation is None or own.observation >= len(state.observations):
        return None
    observation = state.observations[own.observation]
    if before is not None and before.overlay is not None:
        number = before.own.observation
        is_same = number is not None and before.state.observations[number] is observation
        is_alike = before.own.is_calibrated == own.is_calibrated
        if is_same and is_alike and before.calibration is found:
            return before.overlay
    is_after = own.is_calibrated and isinstance(found, Calibration)
    return overlay(state, observation, found if is_after else None)  # type: ignore[arg-type]
