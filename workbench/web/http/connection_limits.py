"""Limits of the number of connections: in total, and of those without a login.

A connection without a login costs an attacker nothing.  So it may not last long, and is closed
when others come.  Its limit always leaves room for people who have logged in.
"""

import socket
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass

from aiohttp import web
from aiohttp.typedefs import Handler

from workbench.model.errors import FileError
from workbench.web.http.broken_connections import is_broken_off
from workbench.web.http.origins import network_of
from workbench.web.http.refusals import log_refusal

MOST_STRANGERS = 160
"""Connections without a login at the same time; beyond them the one that waits longest goes."""

MOST_KNOWN = 240
"""Connections with a login; the websockets among them are counted in `connections.py`."""

WAIT_SECONDS = 10.0
"""That a connection without a login may take for its next request, a handshake included."""

WORK_SECONDS = 30.0
"""That its request may take, answer included."""

KNOWN_SECONDS = 75.0
"""That a connection with a login is kept without a request; more than proxies keep theirs."""

GRACE_SECONDS = 0.5
"""That a connection is not blamed for keeping us waiting: what it says may be on its way."""

IsLogin = Callable[[web.Request], Awaitable[bool]]
"""Whether a request shows a valid login, or a token."""


@dataclass(frozen=True, slots=True)
class ConnectionRoom:
    """How many connections there may be.

    Attributes:
        strangers: without a login.
        known: with one.
    """

    strangers: int = MOST_STRANGERS
    known: int = MOST_KNOWN


@dataclass(eq=False, slots=True)
class OpenConnection:
    """One connection.

    Attributes:
        key: the protocol that its requests name.
        socket: its own; closed once it has gone.
        network: where it comes from.
        since: when it came, or was last asked something, or answered [s].
        drop: cuts it off.
        is_known: whether it showed a login with its last request.
        was_answered: whether it has had any answer.
        began: when the first bytes of its next request came, if they did [s].
        request: that is being answered, if any.
    """

    key: object
    socket: socket.socket
    network: str
    since: float
    drop: Callable[[], None]
    is_known: bool = False
    was_answered: bool = False
    began: float | None = None
    request: web.Request | None = None

    def claim(self, now: float) -> int:
        """To its place; who has the least goes first when there are too many."""
        if self.request is not None:
            # It may still owe us the rest.
            return 4 if self.request.content.is_eof() else 0
        if self.began is not None:
            is_our_turn = now - self.began < GRACE_SECONDS
        else:
            is_our_turn = _has_unread(self.socket)
        if is_our_turn:
            return 2 if self.was_answered else 3
        return 0 if self.was_answered or now - self.since >= GRACE_SECONDS else 1


class ConnectionLimits:
    """All who are here, and who of them has to go.

    Concurrency: the front's event loop only.
    """

    def __init__(self, is_login: IsLogin, clock: Callable[[], float], room: ConnectionRoom):
        """Nobody is there.

        Args:
            is_login: returns who has logged in.
            clock: [s], does not jump.
            room: for how many.
        """
        self._is_login = is_login
        self._clock = clock
        self._room = room
        self._visitors: dict[object, OpenConnection] = {}

    def enter(
        self, key: object, taken: socket.socket, address: str, drop: Callable[[], None]
    ) -> None:
        """Take note of a connection; if it is one too many, another one goes.

        Args:
            key: the protocol that its requests will name.
            taken: its socket.
            address: that it comes from.
            drop: cuts it off.
        """
        self._forget()
        strangers = [visitor for visitor in self._visitors.values() if not visitor.is_known]
        if len(strangers) >= self._room.strangers:
            self._drop(self._first_to_go(strangers), "too many without a login")
        self._visitors[key] = OpenConnection(key, taken, network_of(address), self._clock(), drop)

    def note_bytes(self, key: object) -> None:
        """Take note that bytes have come from a connection."""
        visitor = self._visitors.get(key)
        if visitor is not None and visitor.began is None:
            visitor.began = self._clock()

    def make_room(self, count: int) -> None:
        """Drop some of those without a login, when their sockets are needed."""
        self._forget()
        for _ in range(count):
            strangers = [visitor for visitor in self._visitors.values() if not visitor.is_known]
            if not strangers:
                return
            self._drop(self._first_to_go(strangers), "no file descriptors are left")

    @web.middleware
    async def note(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Note who asks, and when it was answered; a middleware."""
        visitor = self._visitors.get(request.protocol)
        if visitor is None:
            # It was dropped just now.
            return await handler(request)
        is_known = await self._is_known(request, visitor)
        if is_known and not visitor.is_known and not self._has_room_for_known():
            log_refusal("connection", why="too many with a login", origin=request.remote)
            raise web.HTTPServiceUnavailable(text="Too many connections.\n")
        visitor.is_known = is_known
        visitor.since, visitor.request = self._clock(), request
        try:
            return await handler(request)
        except OSError as error:
            if request.transport is not None or not is_broken_off(error):
                raise
            # It has gone in the middle of its request: nobody is to be told, and nothing is wrong.
            raise web.HTTPBadRequest from error
        finally:
            visitor.since, visitor.request = self._clock(), None
            visitor.was_answered, visitor.began = True, None

    def look(self) -> None:
        """Drop those without a login who have taken too long; to be called every second."""
        self._forget()
        now = self._clock()
        for visitor in list(self._visitors.values()):
            if visitor.is_known:
                # They are not hurried while asked something; between requests aiohttp drops them.
                continue
            waited = now - visitor.since
            if waited >= (WORK_SECONDS if visitor.request is not None else WAIT_SECONDS):
                # What has come and was not read yet is our delay.
                if visitor.request is None and _has_unread(visitor.socket):
                    continue
                self._drop(visitor, None)

    async def _is_known(self, request: web.Request, visitor: OpenConnection) -> bool:
        try:
            return await self._is_login(request)
        except FileError:
            # The file of users cannot be read now: who is in stays in, and nobody new gets in.
            return visitor.is_known

    def _has_room_for_known(self) -> bool:
        self._forget()
        known = [visitor for visitor in self._visitors.values() if visitor.is_known]
        if len(known) < self._room.known:
            return True
        idle = [visitor for visitor in known if visitor.request is None]
        if idle:
            self._drop(min(idle, key=lambda visitor: visitor.since), "too many with a login")
        return bool(idle)

    def _first_to_go(self, strangers: list[OpenConnection]) -> OpenConnection:
        """The one with the least claim; of these, from where most come, who waits longest."""
        now, crowd = self._clock(), Counter(stranger.network for stranger in strangers)
        return min(
            strangers,
            key=lambda stranger: (stranger.claim(now), -crowd[stranger.network], stranger.since),
        )

    def _drop(self, visitor: OpenConnection, why: str | None) -> None:
        del self._visitors[visitor.key]
        if why is not None:
            log_refusal("connection", why=why, origin=visitor.network)
        visitor.drop()

    def _forget(self) -> None:
        """Those who have gone by themselves."""
        gone = [key for key, visitor in self._visitors.items() if visitor.socket.fileno() < 0]
        for key in gone:
            del self._visitors[key]


def room_for(descriptors: int) -> ConnectionRoom:
    """How many connections there may be.

    Args:
        descriptors: that the process may have open; a page's websocket takes three of them.
    """
    return ConnectionRoom(
        strangers=max(8, min(MOST_STRANGERS, descriptors // 6)),
        known=max(16, min(MOST_KNOWN, descriptors // 4)),
    )


def _has_unread(taken: socket.socket) -> bool:
    """Whether something has come that we did not read yet."""
    try:
        return bool(taken.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT))
    except OSError:
        return False
