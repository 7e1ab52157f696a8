"""Somebody who uses the page, as a browser and as a program, and looks how it answers."""

import asyncio
import contextlib
import time
from collections.abc import AsyncGenerator, Callable
from contextlib import asynccontextmanager
from typing import Any

import aiohttp

from workbench.model.errors import LinkError
from workbench.studies.load.raw_browser import RawBrowser, raw_browser

ASKS = 0.02
"""[s] Between two questions how things stand."""

LONGEST_ACTION = 600.0
"""[s] That anything may take."""

NOT_NOW = "this button is not available now"
"""In what the page says where a file is chosen too early."""

AGAIN = 0.5
"""[s] After which it is tried again."""

PREFIX = "/api/v1"


class Visit:
    """One user.

    Lifetime: inside `visit`.

    Concurrency: one event loop.
    """

    def __init__(self, browser: RawBrowser, token: str):
        """Made by `visit`."""
        self.browser = browser
        self._headers = {"Authorization": f"Bearer {token}"}
        self.slowest = 0.0
        """[s] That an answer to how things stand has taken since this was set to 0."""

    async def get(self, path: str, *, raw: bool = False) -> Any:
        """What a path of the interface answers; a JSON value unless it is to be `raw`."""
        url = self.browser.url + (path if raw else PREFIX + path)
        async with self.browser.session.get(url, headers=self._headers) as answer:
            is_json = not raw and answer.content_type == "application/json"
            return await answer.json() if is_json else await answer.read()

    async def post(self, path: str, **body: Any) -> Any:
        """Give a command.

        Raises:
            LinkError: it is refused.
        """
        url = self.browser.url + PREFIX + path
        async with self.browser.session.post(url, headers=self._headers, json=body) as answer:
            answer_form = await answer.json()
            if answer.status >= 400:
                raise LinkError(f"{path}: {answer_form['detail']}")
            return answer_form

    async def state(self) -> dict[str, Any]:
        """How things stand."""
        return await self.get("/state")

    async def until(self, condition: Callable[[dict[str, Any]], bool], what: str) -> dict[str, Any]:
        """The state once something holds for it.

        Raises:
            LinkError: it never does, or the page has reported of a refusal.
        """
        end = time.monotonic() + LONGEST_ACTION
        while time.monotonic() < end:
            state = await self.state()
            if condition(state):
                return state
            if self.browser.refused:
                raise LinkError(f"waited for {what}: {self.browser.refused[0]}")
            await asyncio.sleep(0.1)
        raise LinkError(f"waited {LONGEST_ACTION:.0f} s for {what}")

    async def wait_for_task(self) -> dict[str, Any]:
        """The state once no task runs."""
        return await self.until(
            lambda state: state["job"] is None and state["getting_ready"] is None, "a task"
        )

    async def wait_for_text(self, *words: str) -> None:
        """Wait until the page shows a text with all these words."""

        def stands(state: object) -> bool:
            del state
            texts = self.browser.texts.values()
            return any(all(word in text for word in words) for text in texts)

        await self.until(stands, f"the page to say {words}")

    async def choose(self, button: str, name: str, content: bytes, *words: str) -> None:
        """Choose a file, again while its button cannot be used, until the page says the words.

        Raises:
            LinkError: it never says them.
        """
        end = time.monotonic() + LONGEST_ACTION
        while time.monotonic() < end:
            self.browser.refused.clear()
            await self.browser.upload(button, name, content)
            try:
                await self.wait_for_text(name, *words)
            except LinkError:
                if NOT_NOW not in "".join(self.browser.refused):
                    raise
                await asyncio.sleep(AGAIN)
            else:
                return
        raise LinkError(f"{button!r} could not be used for {LONGEST_ACTION:.0f} s")

    async def ask(self) -> None:
        """Ask how things stand, again and again."""
        while True:
            began = time.monotonic()
            await self.state()
            self.slowest = max(self.slowest, time.monotonic() - began)
            await asyncio.sleep(ASKS)


@asynccontextmanager
async def visit(url: str, name: str, password: str, token: str) -> AsyncGenerator[Visit]:
    """Log in, open the page and look at it until the block ends.

    Raises:
        LinkError: the page does not answer or lets nobody in.
    """
    try:
        async with raw_browser(url) as browser:
            if await browser.log_in(name, password) != 303:
                raise LinkError(f"{url}: {name!r} cannot log in")
            await browser.open()
            visitor = Visit(browser, token)
            tasks = [asyncio.create_task(browser.close_code()), asyncio.create_task(visitor.ask())]
            try:
                yield visitor
            finally:
                for task in tasks:
                    task.cancel()
                    with contextlib.suppress(asyncio.CancelledError, aiohttp.ClientError):
                        await task
    except (aiohttp.ClientError, ConnectionError) as error:
        raise LinkError(f"{url}: {error}") from error
