"""One browser's websocket and viser's, with what passes between them."""

import asyncio
import time
from collections.abc import Coroutine
from dataclasses import dataclass
from typing import Any

from aiohttp import ClientWebSocketResponse, WebSocketError, WSCloseCode, WSMsgType, web

from workbench.web.http.refusals import log_refusal
from workbench.web.page.connections import OVER, Seat
from workbench.web.page.messages import (
    FileTransferPart,
    FileTransferStartUpload,
    Working,
    read,
    write_frame,
)
from workbench.web.page.rate_limit import RateLimit
from workbench.web.page.uploads import Broken, Uploads

MOST_REFUSED = 20
"""Messages that are dropped before the browser is cut off."""

CLOSE_SECONDS = 1.0
"""How long a browser has to take note that it is cut off [s]."""


@dataclass(frozen=True, slots=True)
class End:
    """Why a conversation ends; `is_fault` when the browser did what it must not."""

    code: int
    why: str
    is_fault: bool = False


class Conversation:
    """Passes on what viser says, and of what the browser says that which it may.

    A browser that does not read holds up its own connection to viser, which then keeps only the
    newest state for it; here there is never more than one message on its way to it.

    Lifetime: `run`, once.

    Concurrency: tasks of the front's event loop.
    """

    def __init__(
        self,
        browser: web.WebSocketResponse,
        viser: ClientWebSocketResponse,
        seat: Seat,
        request: web.Request,
    ):
        """Both ends, whose login it is, and the request that it began with."""
        self._browser = browser
        self._viser = viser
        self._seat = seat
        self._person = seat.session.person
        self._origin = request.remote
        self._transport = request.transport
        self._uploads = Uploads()
        self._rate = RateLimit(time.monotonic())
        self._added = asyncio.Event()
        self._emptied = asyncio.Event()
        self._refused = 0

    async def run(self) -> None:
        """Talk until one end goes, the login ends, or the browser does what it must not."""
        ways: tuple[Coroutine[Any, Any, End], ...] = (
            self._listen(),
            self._pass_on(),
            self._show(),
            self._wait_for_the_end(),
        )
        tasks = [asyncio.create_task(way) for way in ways]
        try:
            done, _ = await asyncio.wait(tasks, return_when=asyncio.FIRST_COMPLETED)
            end = _first(done)
        finally:
            for task in tasks:
                task.cancel()
            await asyncio.gather(*tasks, return_exceptions=True)
        if end.is_fault:
            self._log_refusal("connection", end.why)
        await close(self._browser, self._transport, end.code, end.why)
        await self._viser.close()

    async def _listen(self) -> End:
        """From the browser into the queue."""
        async for frame in self._browser:
            if frame.type is WSMsgType.ERROR:
                return _broken(frame.data)
            if frame.type is not WSMsgType.BINARY:
                return End(WSCloseCode.UNSUPPORTED_DATA, "only binary messages", is_fault=True)
            try:
                message = read(frame.data, self._person.role)
            except ValueError as error:
                self._log_refusal("message", str(error))
                self._refused += 1
                if self._refused >= MOST_REFUSED:
                    return End(WSCloseCode.POLICY_VIOLATION, "too much was refused", is_fault=True)
                continue
            problem = await self._take(message)
            if problem is not None:
                return End(WSCloseCode.POLICY_VIOLATION, problem.why, is_fault=True)
        return End(WSCloseCode.OK, "")

    async def _take(self, message: Working) -> Broken | None:
        problem = None
        if isinstance(message, FileTransferStartUpload):
            problem = self._uploads.begin(message)
        elif isinstance(message, FileTransferPart):
            problem = self._uploads.take(message)
        if problem is not None:
            return problem
        if not self._rate.add(message):
            return Broken("more messages than a hand can make")
        self._emptied.clear()
        self._added.set()
        if isinstance(message, FileTransferPart):
            # Nothing more is read before it is gone: big ones never pile up here.
            await self._emptied.wait()
        return None

    async def _pass_on(self) -> End:
        """From the queue to viser."""
        while True:
            message = self._rate.ready(time.monotonic())
            if message is not None:
                try:
                    await self._viser.send_bytes(write_frame(message))
                except ConnectionError:
                    return End(WSCloseCode.GOING_AWAY, "the page has gone")
            elif len(self._rate):
                await asyncio.sleep(self._rate.patience())
            else:
                self._emptied.set()
                self._added.clear()
                await self._added.wait()

    async def _show(self) -> End:
        """From viser to the browser."""
        async for frame in self._viser:
            if frame.type is WSMsgType.BINARY:
                try:
                    await self._browser.send_bytes(frame.data)
                except ConnectionError:
                    return End(WSCloseCode.OK, "")
        code = self._viser.close_code or 0
        if code == WSCloseCode.PROTOCOL_ERROR:
            # The page's own word for another version of itself: it asks to be loaded again.
            return End(code, "version mismatch")
        return End(WSCloseCode.SERVICE_RESTART, "the page has gone")

    async def _wait_for_the_end(self) -> End:
        await self._seat.over.wait()
        return End(self._seat.code, "logged out" if self._seat.code == OVER else "")

    def _log_refusal(self, what: str, why: str) -> None:
        log_refusal(what, why=why, origin=self._origin, who=self._person.name)


async def close(
    browser: web.WebSocketResponse, transport: asyncio.BaseTransport | None, code: int, why: str
) -> None:
    """Close a browser's websocket, whether the browser listens or not."""
    closing = browser.close(code=code, message=why.encode()[:120], drain=False)
    try:
        await asyncio.wait_for(closing, CLOSE_SECONDS)
    except TimeoutError:
        # It does not read: what waits for it is dropped.
        if isinstance(transport, asyncio.WriteTransport):
            transport.abort()


def _broken(error: Exception) -> End:
    """What the browser sent is too big, or no websocket any more; or it has only gone."""
    if isinstance(error, WebSocketError):
        is_big = error.code == WSCloseCode.MESSAGE_TOO_BIG
        why = "a message is too big" if is_big else str(error)
        return End(error.code, why, is_fault=True)
    return End(WSCloseCode.OK, "")


def _first(done: set[asyncio.Task[End]]) -> End:
    """The end that was reached; of several at once, one that is the browser's fault."""
    ends = [task.result() for task in done]
    return next((end for end in ends if end.is_fault), ends[0])
