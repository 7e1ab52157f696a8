"""The websocket of the page around the scene: states what the bar says, takes a stop.

A stop comes over HTTP and on this websocket at once.  On a line that loses packets, or that a new
connection has to be opened over, one of them is late; this one is open all the time.
"""

import asyncio
import time
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from aiohttp import WSCloseCode, WSMsgType, web

from workbench.app.core.people import Person
from workbench.model.messages.message import Message
from workbench.web.access.identity import session_of
from workbench.web.page.bar import Bar, Stopper
from workbench.web.page.connections import Connections
from workbench.web.page.conversation import close
from workbench.web.page.languages import language_of
from workbench.web.page.relay import HEARTBEAT
from workbench.words.words import words_of

Say = Callable[[Message | str], str]
"""Says in somebody's language what is said in English."""

SAID = ("robot", "fault", "why")
"""What of a bar is for people; the rest is for the page's script."""

STOP = "stop"
"""What a browser may say, and nothing else."""

POLL_EVERY = 0.15
"""[s] Between two looks at what the bar should say."""

REPEAT = 2.0
"""[s] At the latest it is said again: a browser that hears nothing knows that it is cut off."""


class Presence:
    """Who has the page open, and what their bar says.

    Concurrency: the front's event loop only; stops have a thread of their own, so that none waits
    for passwords that are being tried.
    """

    def __init__(self, connections: Connections, bar: Bar, stop: Stopper):
        """Made by `serve_front`."""
        self._connections = connections
        self._bar = bar
        self._stop = stop
        self._stopping = ThreadPoolExecutor(1, thread_name_prefix="presence-stop")

    async def socket(self, request: web.Request) -> web.StreamResponse:
        """A websocket that feeds the bar, again and again; the browser may say `STOP` on it."""
        session = session_of(request)
        if session is None:
            raise web.HTTPUnauthorized(text="Log in first.\n")
        with self._connections.seat(session) as seat:
            if seat is None:
                raise web.HTTPTooManyRequests(text="Too many windows are open.\n")
            browser = web.WebSocketResponse(heartbeat=HEARTBEAT, max_msg_size=1024)
            await browser.prepare(request)
            say = words_of(language_of(request)).render
            ways = (
                asyncio.create_task(self._hear(browser, session.person, say)),
                asyncio.create_task(seat.over.wait()),
                asyncio.create_task(self._send_bar(browser, session.person, say)),
            )
            try:
                await asyncio.wait(ways, return_when=asyncio.FIRST_COMPLETED)
            finally:
                for way in ways:
                    way.cancel()
                await asyncio.gather(*ways, return_exceptions=True)
            code = seat.code if seat.over.is_set() else WSCloseCode.OK
            await close(browser, request.transport, code, "")
        return browser

    async def _send_bar(self, browser: web.WebSocketResponse, person: Person, say: Say) -> None:
        last_words: Mapping[str, Any] | None = None
        at = 0.0
        while True:
            words, now = self._bar(person), time.monotonic()
            if words != last_words or now - at >= REPEAT:
                await browser.send_json({**words, **{key: say(words[key]) for key in SAID}})
                last_words, at = words, now
            await asyncio.sleep(POLL_EVERY)

    async def _hear(self, browser: web.WebSocketResponse, person: Person, say: Say) -> None:
        """Stop when the browser says so; return when it goes, or says anything else."""
        async for message in browser:
            if message.type is not WSMsgType.TEXT or message.data != STOP:
                return
            loop = asyncio.get_running_loop()
            why = await loop.run_in_executor(self._stopping, self._stop, person)
            await browser.send_json({"stopped": not why, "why": say(why)})
