"""Who is there: the first one who may act is in control, and whoever has gone is not for long."""

import logging

from workbench.app.core.control import ReleaseControl, TakeControl
from workbench.app.core.people import FRONT_DOOR, NOBODY, Person, Role
from workbench.app.runtime.bench import Bench
from workbench.model.errors import CommandRefused

log = logging.getLogger(__name__)

GRACE = 60.0
"""[s] For which control is kept for somebody whose browsers have all gone."""


class BrowserCount:
    """Counts the browsers of each person who has logged in.

    It is about people, not browsers: a page that is loaded again is somebody else's to the
    server, and the same person's to everybody here.

    Lifetime: as long as the page.

    Concurrency: one thread at a time.
    """

    def __init__(self, bench: Bench, now: float, *, grace: float = GRACE):
        """Nobody is there yet; who was in control in an earlier run has just gone.

        Args:
            bench: whose control it is.
            now: a clock that never goes back [s].
            grace: for how long [s] control is kept.
        """
        self._bench = bench
        self._grace = grace
        self._browsers: dict[int, str] = {}
        holder = bench.state.control
        self._left: dict[str, float] = {holder: now} if holder else {}

    def enter(self, browser: int, person: Person) -> None:
        """A browser has come; its person is in control if nobody is."""
        if person.name == NOBODY:
            return
        self._browsers[browser] = person.name
        self._left.pop(person.name, None)
        if not self._bench.state.control and person.role.covers(Role.OPERATOR):
            try:
                self._bench.do(TakeControl(), person.name, person.role)
            except CommandRefused as error:
                log.info("%s does not get control: %s", person.name, error)

    def leave(self, browser: int, now: float) -> None:
        """A browser has gone at `now` [s]."""
        name = self._browsers.pop(browser, "")
        if name and name not in self._browsers.values():
            self._left[name] = now

    def look(self, now: float) -> None:
        """Give back the control of whoever has gone for too long at `now` [s]."""
        holder = self._bench.state.control
        if now - self._left.get(holder, now) < self._grace:
            return
        try:
            self._bench.do(ReleaseControl(holder), FRONT_DOOR)
            del self._left[holder]
        except CommandRefused as error:
            # A disk may be full for a while: it is tried again after the same time.
            self._left[holder] = now
            log.info("control of %s is not given back: %s", holder, error)
