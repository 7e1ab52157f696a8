"""The way in: takes connections at the listening socket, as far as there is room."""

import asyncio
import contextlib
import errno
import logging
import resource
import socket
import ssl
from typing import Any

from aiohttp import web

from workbench.web.http.connection_limits import KNOWN_SECONDS, WAIT_SECONDS, ConnectionLimits

log = logging.getLogger("workbench.web")

NOTHING_LEFT = frozenset({errno.EMFILE, errno.ENFILE, errno.ENOBUFS, errno.ENOMEM})
"""Errors of the machine or the process, not of the connection that comes."""

RETRY = 0.25
"""How long [s] to wait for something to be left."""

GIVEN_BACK = 8
"""Connections without a login that are dropped when nothing is left."""

SILENCE = 60.0
"""[s] In which it is said only once that nothing is left."""

POLL_EVERY = 1.0
"""How often [s] it is searched for those who have taken too long."""


class Gate:
    """Accepts connections.

    It replaces asyncio's loop, which reports a connection only after its TLS handshake.  When file
    descriptors run out, asyncio tries 128 times in a row, and logs and repeats each attempt.

    Lifetime: `serve`, until it is cancelled.

    Concurrency: the front's event loop only.
    """

    def __init__(
        self,
        bound: socket.socket,
        tls: ssl.SSLContext | None,
        limits: ConnectionLimits,
        server: web.Server,
    ):
        """Made by `serve_front`.

        Args:
            bound: the listening socket.
            tls: the TLS context, if any.
            limits: gets every new connection.
            server: answers requests.
        """
        self._bound = bound
        self._tls = tls
        self._limits = limits
        self._server = server
        self._entering: dict[asyncio.Task[None], socket.socket] = {}
        self._said_at = -SILENCE

    async def serve(self) -> None:
        """Take in who comes, for ever."""
        loop = asyncio.get_running_loop()
        self._bound.setblocking(False)
        looking = asyncio.create_task(self._look())
        try:
            while True:
                try:
                    taken, address = await loop.sock_accept(self._bound)
                except OSError as error:
                    await self._wait_after(error)
                else:
                    self._admit(taken, address)
                # A connection that is there already is taken without waiting; others are served
                # between two of them all the same.
                await asyncio.sleep(0)
        finally:
            looking.cancel()
            for taken in self._entering.values():
                _hang_up(taken)
            await asyncio.gather(looking, *self._entering, return_exceptions=True)

    def _admit(self, taken: socket.socket, address: Any) -> None:
        try:
            self._take(taken, address)
        except Exception:
            # A rim: what goes wrong with one connection ends no other.
            log.exception("a connection cannot be taken in")
            _hang_up(taken)

    def _take(self, taken: socket.socket, address: Any) -> None:
        protocol = _Answering(self._server, self._limits)
        task = asyncio.create_task(self._let_in(taken, protocol))
        self._entering[task] = taken
        task.add_done_callback(self._entering.pop)
        self._limits.enter(protocol, taken, str(address[0]), lambda: _cut(taken, protocol))

    async def _let_in(self, taken: socket.socket, protocol: web.RequestHandler) -> None:
        loop = asyncio.get_running_loop()
        patience = None if self._tls is None else WAIT_SECONDS
        # It may speak no TLS, or have gone: nobody is there to be told.
        with contextlib.suppress(OSError):
            await loop.connect_accepted_socket(
                lambda: protocol, taken, ssl=self._tls, ssl_handshake_timeout=patience
            )

    async def _wait_after(self, error: OSError) -> None:
        if isinstance(error, ConnectionError):
            # It was given up before it was taken.
            return
        now = asyncio.get_running_loop().time()
        if now - self._said_at >= SILENCE:
            self._said_at = now
            log.error("nobody more can come in for now: %s", error)
        if error.errno in NOTHING_LEFT:
            self._limits.make_room(GIVEN_BACK)
        await asyncio.sleep(RETRY)

    async def _look(self) -> None:
        while True:
            await asyncio.sleep(POLL_EVERY)
            try:
                self._limits.close_overdue()
            except Exception:
                log.exception("the limits of connections cannot be checked")


class _Answering(web.RequestHandler):
    """Answers the requests of one connection, and says when they begin."""

    def __init__(self, server: web.Server, limits: ConnectionLimits):
        loop = asyncio.get_running_loop()
        super().__init__(
            server,
            loop=loop,
            access_log=None,  # pyright: ignore[reportArgumentType]
            keepalive_timeout=KNOWN_SECONDS,
        )
        self._limits = limits

    def data_received(self, data: bytes) -> None:
        self._limits.note_bytes(self)
        super().data_received(data)


def descriptors() -> int:
    """How many files and sockets this process may have open."""
    soft, _ = resource.getrlimit(resource.RLIMIT_NOFILE)
    return 1 << 20 if soft == resource.RLIM_INFINITY else soft


def _cut(taken: socket.socket, protocol: web.RequestHandler) -> None:
    """Cut a connection off."""
    transport = protocol.transport
    if isinstance(transport, asyncio.WriteTransport):
        transport.abort()
    else:
        # In its handshake there is no transport of ours yet.
        _hang_up(taken)


def _hang_up(taken: socket.socket) -> None:
    """End a connection that asyncio has in hand: it finds the end, and closes the socket."""
    with contextlib.suppress(OSError):
        taken.shutdown(socket.SHUT_RDWR)
