"""The websockets that are open, by login: when a login ends, so do they."""

import asyncio
import logging
from collections import Counter
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass, field

from aiohttp import WSCloseCode

from workbench.model.errors import FileError
from workbench.web.access.sessions import Session, Sessions

log = logging.getLogger("workbench.web")

MOST_OF_ONE = 24
"""Websockets of one user; each window has two."""

MOST_OF_ALL = 160

POLL_EVERY = 0.25
"""How often [s] logins are looked after that another process or the clock may have ended."""


OVER = 4401
"""Close code for a login that has ended (private use, RFC 6455, section 7.4.2)."""


@dataclass(eq=False)
class Seat:
    """One open websocket: `over` is set when it has to close, with `code`."""

    session: Session
    code: int = OVER
    over: asyncio.Event = field(default_factory=asyncio.Event)


class Connections:
    """All seats.

    Concurrency: the front's event loop only.
    """

    def __init__(self, sessions: Sessions):
        """Nobody is here yet."""
        self._sessions = sessions
        self._seats: set[Seat] = set()

    @contextmanager
    def seat(self, session: Session) -> Generator[Seat | None]:
        """A place for one websocket as long as the block runs; None when there are too many."""
        taken = Counter(seat.session.person.name for seat in self._seats)
        if len(self._seats) >= MOST_OF_ALL or taken[session.person.name] >= MOST_OF_ONE:
            yield None
            return
        seat = Seat(session)
        self._seats.add(seat)
        try:
            yield seat
        finally:
            self._seats.discard(seat)

    def cut(self, digests: frozenset[str]) -> None:
        """Close what belongs to these logins."""
        for seat in self._seats:
            if seat.session.digest in digests:
                seat.over.set()

    def close(self) -> None:
        """Close everything: we end, and may be back soon."""
        for seat in self._seats:
            seat.code = WSCloseCode.SERVICE_RESTART
            seat.over.set()

    async def watch(self) -> None:
        """Cut whose login ends, for ever."""
        while True:
            await asyncio.sleep(POLL_EVERY)
            try:
                self.cut(self._sessions.over(seat.session.digest for seat in self._seats))
            except FileError:
                # Somebody may be mending the file; who is in stays in, and nobody new gets in.
                log.exception("it cannot be told whose login has ended")
