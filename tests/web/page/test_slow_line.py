"""The page over a line of 1 Mbit/s, 200 ms there and back, that loses one packet in fifty."""

import asyncio
import re

import pytest
from attackers import PASSWORD, SECRET, run
from slow_line import can_be_had, slow_line

from workbench.studies.load.raw_browser import raw_browser
from workbench.web.page.relay import Upstream
from workbench.web.server import ServerOptions, serve_front

FEW = 900_000
"""Bytes of the page at its first load; 1 Mbit/s carries them in 7 s."""


@pytest.fixture
def line():
    if not can_be_had():
        pytest.skip("no network devices of our own here")
    with slow_line() as line:
        yield line


@pytest.fixture
def far_front(users, file, scene, line, monkeypatch):
    monkeypatch.setattr("workbench.web.server.listen", lambda host, port: line.bound)
    front = serve_front(Upstream(scene.url, SECRET), file, ServerOptions(), title="far")
    yield line
    front.close()


@pytest.mark.extensive
def test_the_page_is_loaded_with_few_bytes_and_used(far_front, scene):
    line = far_front

    async def look():
        async with raw_browser(line.url) as browser:
            packed = {"Accept-Encoding": "gzip"}
            assert await browser.log_in("Otto", PASSWORD) == 303
            _, page = await browser.get("/scene/", **packed)
            names = re.findall(r'"(/scene/pieces/\w+)"', page)
            pieces = await asyncio.gather(*(browser.get(name, **packed) for name in names))
            assert len(names) == 6 and all(status == 200 for status, _ in pieces)
            await browser.open()
            await browser.find("press Otto")
            assert 600_000 < line.carried() < FEW
            await browser.set("press Otto", True)
            await asyncio.to_thread(scene.wait, lambda: scene.presses)

    run(look())
    assert scene.presses == ["Otto"]
