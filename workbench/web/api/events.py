"""The state as it changes, as server-sent events: the newest one wins, nobody is waited for."""

import asyncio
import contextlib
import json
from collections.abc import AsyncGenerator, Awaitable, Callable

from aiohttp import web

from workbench.app.core.state import State
from workbench.app.runtime.bench import Bench
from workbench.web.api.forms import job_form, state_form
from workbench.web.http.long_answers import write_within

HEARTBEAT = 10.0
"""[s] After which a stream that has nothing to say shows that it lives."""

PROGRESS = 0.5
"""[s] Between two words about a running task."""

WRITE_SECONDS = 10.0
"""[s] That a listener may take to read what waits for it."""

MOST_LISTENERS = 32
"""Streams at a time: each has a thread of the bench."""

STREAM = "text/event-stream"


class Events:
    """Streams of one bench.

    For each listener only the newest state is kept, so one that reads slowly costs no memory and
    misses what lay between.

    Lifetime: as long as its routes.

    Concurrency: the event loop, except for the bench's observers, which only wake it.
    """

    def __init__(self, bench: Bench, *, heartbeat: float = HEARTBEAT):
        """Nobody listens yet."""
        self._bench = bench
        self._heartbeat = heartbeat
        self._listeners = 0

    @property
    def is_full(self) -> bool:
        """Whether nobody more can listen."""
        return self._listeners >= MOST_LISTENERS

    async def stream(
        self, request: web.Request, is_still_allowed: Callable[[], Awaitable[bool]]
    ) -> web.StreamResponse:
        """Tell the state and every change until the listener goes.

        Args:
            request: of the listener.
            is_still_allowed: asked at every heartbeat, since logins end while streams go on.
        """
        response = web.StreamResponse(
            headers={"Content-Type": STREAM, "Cache-Control": "no-store", "X-Accel-Buffering": "no"}
        )
        self._listeners += 1
        try:
            await response.prepare(request)
            # A listener may leave; one that does not read would keep its place, even without login.
            with contextlib.suppress(ConnectionResetError):
                async with contextlib.aclosing(self._words()) as words:
                    async for word in words:
                        if not word and not await is_still_allowed():
                            break
                        beat = b": still here\n\n"
                        await write_within(WRITE_SECONDS, request, response, word or beat)
        finally:
            self._listeners -= 1
        return response

    async def _words(self) -> AsyncGenerator[bytes]:
        """Events as bytes; empty ones at every heartbeat."""
        loop, changed = asyncio.get_running_loop(), asyncio.Event()
        unsubscribe = self._bench.subscribe(
            lambda old, new: _in_loop(loop, changed)  # the loop looks what is newest by itself
        )
        clock = loop.time
        last_sent: tuple[State, bool] | None = None
        progress, beat = b"", clock()
        try:
            while True:
                changed.clear()
                state, live = self._bench.state, self._bench.live
                is_preparing = live.getting_ready is not None
                if (
                    last_sent is None
                    or last_sent[0] is not state
                    or last_sent[1] is not is_preparing
                ):
                    last_sent = state, is_preparing
                    yield _event("state", state_form(state, live), state.number)
                is_busy = is_preparing or state.job is not None
                current = _event("job", job_form(state, live))
                if is_busy and current != progress:
                    progress = current
                    yield current
                if clock() - beat >= self._heartbeat:
                    beat = clock()
                    yield b""
                patience = PROGRESS if is_busy else self._heartbeat
                with contextlib.suppress(TimeoutError):
                    # Not `wait_for`, which forgets that it was cancelled when both happen at once.
                    async with asyncio.timeout(min(patience, self._heartbeat)):
                        await changed.wait()
        finally:
            unsubscribe()


def _in_loop(loop: asyncio.AbstractEventLoop, changed: asyncio.Event) -> None:
    # The server may have ended in between: then there is nobody left to tell.
    with contextlib.suppress(RuntimeError):
        loop.call_soon_threadsafe(changed.set)


def _event(name: str, content: object, number: int | None = None) -> bytes:
    head = "" if number is None else f"id: {number}\n"
    text = json.dumps(content, ensure_ascii=False, allow_nan=False)
    return f"{head}event: {name}\ndata: {text}\n\n".encode()
