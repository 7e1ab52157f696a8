"""Connections that ask nothing: they hold a place, so they may not for long."""

import asyncio
import time

from aiohttp import web
from aiohttp.typedefs import Handler

MOST_CONNECTIONS = 400
"""At the same time, logged in or not."""

SILENT_SECONDS = 15.0
"""After which a connection is dropped that has not asked anything yet."""

LOOK = 1.0
"""How often [s] they are counted."""


class Doorstep:
    """Drops connections that only stand there, all of them at once when there are too many.

    Those that have asked something once are looked after by aiohttp.

    Concurrency: the front's event loop only.
    """

    def __init__(self) -> None:
        """Nobody is there."""
        self._since: dict[web.RequestHandler, float] = {}
        self._spoken: set[web.RequestHandler] = set()

    @web.middleware
    async def note(self, request: web.Request, handler: Handler) -> web.StreamResponse:
        """Note that a connection has asked something; a middleware."""
        self._spoken.add(request.protocol)
        return await handler(request)

    async def watch(self, server: web.Server) -> None:
        """Look after the connections of a server, for ever."""
        while True:
            await asyncio.sleep(LOOK)
            self.look(server.connections, time.monotonic())

    def look(self, connections: list[web.RequestHandler], now: float) -> None:
        """Drop of these connections those that have been silent for too long.

        Args:
            connections: all that are open.
            now: [s] of a clock that does not jump.
        """
        here = set(connections)
        self._spoken &= here
        self._since = {one: self._since.get(one, now) for one in here - self._spoken}
        allowed = SILENT_SECONDS if len(here) < MOST_CONNECTIONS else 0.0
        for one, since in self._since.items():
            transport = one.transport
            if now - since >= allowed and isinstance(transport, asyncio.WriteTransport):
                transport.abort()
