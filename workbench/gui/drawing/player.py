"""Plays a plan for all browsers, no faster than the one that let it play draws it."""

import logging
from collections.abc import Mapping

from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.people import Person
from workbench.app.core.state import Phase, State
from workbench.app.review.history import History
from workbench.app.runtime.bench import Bench
from workbench.gui.drawing.audience import Audience, Span
from workbench.gui.drawing.in_view import InView
from workbench.gui.shared.look import SharedLook, View
from workbench.gui.shared.visitor import Visitor
from workbench.model.errors import WorkbenchError
from workbench.model.plan import Plan

log = logging.getLogger(__name__)

AS_FAST_AS_REAL = 1.0
"""[s of the plan in a second] What is played faster does not count as watched."""

Row = tuple[Plan, ...]
"""A plan and those after it, which are played as one film; two are equal when they are the same."""


class Player:
    """Moves the time on, and informs the bench when somebody has seen a row from start to end.

    Concurrency: the renderer's thread.
    """

    def __init__(self, bench: Bench | History, look: SharedLook):
        """Nothing plays yet."""
        self._bench = bench
        self._look = look
        self._audience: Audience | None = None
        self._key: tuple[int | None, Row] = (None, ())
        self._told: Row = ()
        self._at = 0.0
        self._view = InView()

    def step(self, view: View | None, visitors: Mapping[int, Visitor], elapsed: float) -> None:
        """Move a plan that plays on by the time [s] since the last drawing.

        Args:
            view: drawn last.
            visitors: who is there, by browser.
            elapsed: since it was drawn [s].
        """
        look = self._look.now
        if view is None:
            return
        visitor = visitors.get(look.browser) if look.browser is not None else None
        audience = self._audience_of(view.state.plans, visitor)
        is_away = look.browser is not None and visitor is None
        if is_away or (visitor is not None and visitor.own.now.hides_robot):
            # Nobody sees there what plays.
            if audience is not None:
                audience.stop()
            if look.is_playing:
                self._look.change(is_playing=False, by=None)
        elif look.is_playing:
            # The first drawing after Play was pressed only begins.
            if view.look.is_playing:
                self._go_on(view, audience, visitor, elapsed)
        elif audience is not None and (look.time != self._at or self._at < view.plan_seconds):
            audience.stop()
        if audience is None or visitor is None or not view.state.plans:
            return
        if audience.is_on and not audience.unseen(view.plan_seconds):
            if not look.is_playing:
                audience.stop()
            self._report_watched(view.state.plans, visitor.person)

    def drawn(self, view: View) -> None:
        """A view was sent to all browsers."""
        if self._audience is not None and view.look.time == self._at:
            self._audience.note_drawn(view.look.time)

    def unseen(self, row: Row, end: float) -> tuple[Span, ...]:
        """What of a row up to its end [s] the browser that played it last has not seen yet."""
        audience = self._audience
        is_played = row != () and self._key[1] == row
        return audience.unseen(end) if audience is not None and is_played else ()

    def hidden(self, row: Row, end: float) -> tuple[Span, ...]:
        """What of that the hands were out of the picture of that browser."""
        audience = self._audience
        is_played = row != () and self._key[1] == row
        return audience.hidden(end) if audience is not None and is_played else ()

    def close(self) -> None:
        """Nothing plays any more."""
        if self._audience is not None:
            self._audience.close()

    def _go_on(
        self, view: View, audience: Audience | None, visitor: Visitor | None, elapsed: float
    ) -> None:
        time, end = self._look.now.time, view.plan_seconds
        begin = time
        if time >= end:
            # From the end, Play begins at the start again, or where something was not seen.
            missing = audience.unseen(end) if audience is not None else ()
            begin = missing[0][0] if missing else 0.0
        elapsed *= self._look.now.speed
        if audience is None or visitor is None or self._look.now.speed > AS_FAST_AS_REAL:
            if audience is not None:
                audience.stop()
            self._at = min(begin + elapsed, end)
        else:
            if not audience.is_on or time != self._at or time >= end:
                begin = audience.begin(begin)
                # What was refused once may be taken the next time.
                self._told = ()
                if counts(view.state, visitor):
                    self._view.bring(view, visitor, begin, audience.unseen(end))
            limit = begin if self._view.is_on_its_way(visitor) else min(end, audience.limit)
            self._at = max(begin, min(begin + elapsed, limit))
            if self._view.are_out(view, visitor, begin, self._at):
                audience.out(begin, self._at)
        goes_on = self._at < end or self._look.now.loops
        self._look.change(time=self._at, is_playing=goes_on, by=None)

    def _audience_of(self, row: Row, visitor: Visitor | None) -> Audience | None:
        """The audience of this row in this browser; another one has seen nothing of it."""
        number = visitor.number if visitor is not None and row else None
        if self._key != (number, row):
            self.close()
            self._audience = Audience(visitor.client) if visitor and row else None
            self._key = (number, row)
        return self._audience

    def _report_watched(self, row: Row, person: Person) -> None:
        state = self._bench.state
        if self._told == row or (
            person.name in state.watched and person.name not in state.watched_elsewhere
        ):
            return
        self._told = row
        first, *rest = (plan.digest for plan in row)
        try:
            self._bench.do(WatchPlan(first, row=tuple(rest)), person.name, person.role)
        except WorkbenchError as error:
            log.info("that the plan was watched is not taken: %s", error)


def counts(state: State, visitor: Visitor) -> bool:
    """Whether it matters that a person sees the plan of a state to its end, and has not yet."""
    is_waiting = state.phase in (Phase.PLANNED, Phase.APPROVED) and not visitor.is_recorded
    return is_waiting and visitor.person.name not in state.watched
