"""Limits of the number of connections: in total, and of those without a login.

A connection without a login costs an attacker nothing.  So it may not last long, and is closed
when others come.  Its limit always leaves room for people who have logged in.
"""

import socket
from collections import Counter
from collections.abc import Awaitable, Callable
from dataclasses import dataclass
from enum import IntEnum

from aiohttp import web
from aiohttp.typedefs import Handler

from workbench.model.errors import FileError
from workbench.web.http.broken_connections import is_broken_off
from workbench.web.http.origins import network_of
from workbench.web.http.refusals import log_refusal

MOST_STRANGERS = 160
"""Largest number of connections without a login."""

MOST_KNOWN = 240
"""Largest number of connections with a login; `connections.py` counts their websockets."""

WAIT_SECONDS = 10.0
"""[s] Longest wait for the next request without a login, the handshake included."""

WORK_SECONDS = 30.0
"""[s] Longest time for a request without a login, the answer included."""

KNOWN_SECONDS = 75.0
"""[s] Longest pause between two requests with a login; proxies close theirs earlier."""

GRACE_SECONDS = 0.5
"""[s] For this long a connection counts as waiting for us: its bytes may be on their way."""

IsLogin = Callable[[web.Request], Awaitable[bool]]
"""Whether a request shows a valid login, or a token."""


@dataclass(frozen=True, slots=True)
class ConnectionRoom:
    """Largest numbers of connections.

    Attributes:
        strangers: without a login.
        known: with a login.
    """

    strangers: int = MOST_STRANGERS
    known: int = MOST_KNOWN


class Claim(IntEnum):
    """How strong a connection's claim to its place is; the weakest is dropped first."""

    NONE = 0
    NEW = 1
    NEXT_REQUEST = 2
    FIRST_REQUEST = 3
    ANSWER = 4


@dataclass(eq=False, slots=True)
class OpenConnection:
    """One connection.

    Attributes:
        key: the protocol object that its requests name.
        socket: closed once the client has gone.
        network: the network that it comes from.
        since: time of its arrival, or of its last request or answer [s].
        drop: closes it at once.
        is_known: whether its last request showed a login.
        was_answered: whether it has received an answer.
        began: time of the first bytes of its next request [s]; None before them.
        request: the request in progress.
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

    def claim(self, now: float) -> Claim:
        """The claim to a place at the time `now` [s]."""
        if self.request is not None:
            # Until the body has arrived, the client keeps the server waiting.
            return Claim.ANSWER if self.request.content.is_eof() else Claim.NONE
        if self.began is not None:
            is_our_turn = now - self.began < GRACE_SECONDS
        else:
            is_our_turn = _has_unread(self.socket)
        if is_our_turn:
            return Claim.NEXT_REQUEST if self.was_answered else Claim.FIRST_REQUEST
        is_idle = self.was_answered or now - self.since >= GRACE_SECONDS
        return Claim.NONE if is_idle else Claim.NEW


class ConnectionLimits:
    """The open connections, and the choice of those to close.

    Concurrency: the front's event loop only.
    """

    def __init__(self, is_login: IsLogin, clock: Callable[[], float], room: ConnectionRoom):
        """Start without connections.

        Args:
            is_login: whether a request shows a login.
            clock: monotonic time [s].
            room: largest numbers of connections.
        """
        self._is_login = is_login
        self._clock = clock
        self._room = room
        self._visitors: dict[object, OpenConnection] = {}

    def enter(
        self, key: object, taken: socket.socket, address: str, drop: Callable[[], None]
    ) -> None:
        """Add a connection; if there are too many, close another one.

        Args:
            key: the protocol object that its requests will name.
            taken: its socket.
            address: address of the client.
            drop: closes it at once.
        """
        self._forget()
        strangers = [visitor for visitor in self._visitors.values() if not visitor.is_known]
        if len(strangers) >= self._room.strangers:
            self._drop(self._first_to_go(strangers), "too many without a login")
        self._visitors[key] = OpenConnection(key, taken, network_of(address), self._clock(), drop)

    def note_bytes(self, key: object) -> None:
        """Note that a connection has sent bytes."""
        visitor = self._visitors.get(key)
        if visitor is not None and visitor.began is None:
            visitor.began = self._clock()

    def make_room(self, count: int) -> None:
        """Close `count` connections without a login, when the process needs their sockets."""
        self._forget()
        for _ in range(count):
            strangers = [visitor for visitor in self._visitors.values() if not visitor.is_known]
            if not strangers:
                return
            self._drop(self._first_to_go(strangers), "no file descriptors are left")

    @web.middleware
    async def note(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Middleware: note the login of a request, its begin and its end."""
        visitor = self._visitors.get(request.protocol)
        if visitor is None:
            # Its connection was closed a moment ago.
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
            # The client has left during its request, which is no fault of the server.
            raise web.HTTPBadRequest from error
        finally:
            visitor.since, visitor.request = self._clock(), None
            visitor.was_answered, visitor.began = True, None

    def close_overdue(self) -> None:
        """Close connections without a login that take too long; call it every second."""
        self._forget()
        now = self._clock()
        for visitor in list(self._visitors.values()):
            if visitor.is_known:
                # aiohttp closes them between requests; a request has no limit.
                continue
            waited = now - visitor.since
            if waited >= (WORK_SECONDS if visitor.request is not None else WAIT_SECONDS):
                # Unread bytes mean that the delay is the server's.
                if visitor.request is None and _has_unread(visitor.socket):
                    continue
                self._drop(visitor, None)

    async def _is_known(self, request: web.Request, visitor: OpenConnection) -> bool:
        try:
            return await self._is_login(request)
        except FileError:
            # Without the file of users a known connection stays known, and no other gets in.
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
        """The weakest claim; of these the largest network, and there the longest wait."""
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
        """Remove connections that the clients have closed."""
        gone = [key for key, visitor in self._visitors.items() if visitor.socket.fileno() < 0]
        for key in gone:
            del self._visitors[key]


def room_for(descriptors: int) -> ConnectionRoom:
    """The largest numbers of connections.

    Args:
        descriptors: number of files and sockets that the process may open; a page takes three.
    """
    return ConnectionRoom(
        strangers=max(8, min(MOST_STRANGERS, descriptors // 6)),
        known=max(16, min(MOST_KNOWN, descriptors // 4)),
    )


def _has_unread(taken: socket.socket) -> bool:
    """Whether the socket holds unread bytes."""
    try:
        return bool(taken.recv(1, socket.MSG_PEEK | socket.MSG_DONTWAIT))
    except OSError:
        return False
