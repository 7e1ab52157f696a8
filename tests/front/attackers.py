"""What the tests of the front share: who there is, and patience."""

import asyncio
from collections.abc import Coroutine
from contextlib import asynccontextmanager

import aiohttp
import pytest

from workbench.front.raw_browser import raw_browser

SECRET = "a secret of this start"
PASSWORD = "correct horse battery"
PATIENCE = 120.0
"""How long [s] to wait for what must happen; far more than it takes."""


def run(scenario: Coroutine):
    """Run what a test does in an event loop; it fails when that hangs."""
    return asyncio.run(asyncio.wait_for(scenario, 3 * PATIENCE))


@asynccontextmanager
async def at_the_page(front, name):
    """A raw browser of somebody who has logged in and sees the scene."""
    async with raw_browser(front.url) as browser:
        assert await browser.log_in(name, PASSWORD) == 303
        await browser.open()
        await browser.find("number")
        yield browser


async def cookie_of(browser):
    """The cookie that a browser has, to be shown elsewhere."""
    (cookie,) = browser.session.cookie_jar
    return f"{cookie.key}={cookie.value}"


async def refused_with(opening):
    """The status that a websocket is refused with."""
    with pytest.raises(aiohttp.WSServerHandshakeError) as caught:
        await opening
    return caught.value.status
