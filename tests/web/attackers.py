"""What the tests of the front share: who there is, and patience."""

import asyncio
import socket
import threading
import time
from collections.abc import Coroutine
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from urllib.parse import urlsplit

import aiohttp
import pytest
from waiting import PATIENCE

from workbench.studies.load.raw_browser import raw_browser

SECRET = "a secret of this start"
PASSWORD = "correct horse battery"


def run(scenario: Coroutine, patience: float = 3 * PATIENCE):
    """Run what a test does in an event loop; it fails when that hangs."""
    return asyncio.run(asyncio.wait_for(scenario, patience))


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
    (cookie,) = (one for one in browser.session.cookie_jar if not one.key.endswith("_known"))
    return f"{cookie.key}={cookie.value}"


async def refused_with(opening):
    """The status that a websocket is refused with."""
    with pytest.raises(aiohttp.WSServerHandshakeError) as caught:
        await opening
    return caught.value.status


@dataclass(eq=False)
class Crowd:
    """Connections that hold on to their places; `comes` counts those that were opened.

    Lifetime: inside `crowd`.  Concurrency: a thread opens them, again when they are dropped.
    """

    address: tuple[str, int]
    says: bytes
    size: int
    trickle: bytes = b""
    most: int = 6000
    comes: int = 0
    open: list[socket.socket] = field(default_factory=list)
    over: threading.Event = field(default_factory=threading.Event)

    def push(self) -> None:
        """Keep as many open as can be had, and `most` in all."""
        while not self.over.is_set() and self.comes < self.most:
            self.open = [one for one in self.open if self._is_held(one)]
            for _ in range(min(40, self.size - len(self.open))):
                self._come()
            self.over.wait(0.02)
        self.over.wait()

    def leave(self) -> None:
        for one in self.open:
            one.close()

    def _come(self) -> None:
        one = socket.socket()
        try:
            one.settimeout(2.0)
            one.connect(self.address)
            one.sendall(self.says)
            one.setblocking(False)
        except OSError:
            one.close()
            return
        self.comes += 1
        self.open.append(one)

    def _is_held(self, one: socket.socket) -> bool:
        """Whether it was not dropped; says a little more, where that is the trick."""
        try:
            if self.trickle:
                one.sendall(self.trickle)
            while answer := one.recv(65536):
                del answer
        except BlockingIOError:
            return True
        except OSError:
            pass
        one.close()
        return False


@contextmanager
def crowd(url: str, says: bytes, size: int, trickle: bytes = b""):
    """A crowd before a front as long as the block runs; it has come when the block begins."""
    split = urlsplit(url)
    found = Crowd((split.hostname, split.port), says, size, trickle)
    thread = threading.Thread(target=found.push)
    thread.start()
    try:
        deadline = time.monotonic() + 6 * PATIENCE
        while found.comes < size and time.monotonic() < deadline:
            time.sleep(0.02)
        yield found
    finally:
        found.over.set()
        thread.join()
        found.leave()
