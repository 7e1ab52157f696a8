"""Crowds without a login: they starve nobody, and fill no log."""

import asyncio
import http.client
import os
import ssl
import subprocess
import sys
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from urllib.parse import urlsplit

import pytest
from aiohttp import ClientConnectionError
from attackers import PASSWORD, at_the_page, cookie_of, crowd, run
from waiting import PATIENCE

from workbench.studies.load.raw_browser import raw_browser
from workbench.web.http import connection_limits

LIMIT = 256
"""File descriptors of the server."""

CROWD = 400
"""More than it has, fewer than we may have ourselves."""

LONG = 20 * PATIENCE
"""[s] A crowd takes its share of a busy machine too."""

MOST_LOG = 100_000
"""Bytes; without limits it was a megabyte each second."""

HOST = b"Host: 127.0.0.1\r\n"
FORM = (
    b"POST /login HTTP/1.1\r\n" + HOST + b"Origin: http://127.0.0.1\r\n"
    b"Content-Type: application/x-www-form-urlencoded\r\nContent-Length: 4000\r\n\r\n"
)
CROWDS = {
    "have asked once": (b"GET /healthz HTTP/1.1\r\n" + HOST + b"\r\n", b""),
    "say nothing": (b"", b""),
    "were sent away": (b"GET /who HTTP/1.1\r\n" + HOST + b"\r\n", b""),
    "never end a header": (b"GET / HTTP/1.1\r\n" + HOST + b"A: ", b"a"),
    "never end a form": (FORM + b"name=", b"a"),
    "speak another language": (b"GET / HTTP/1.1\r\nno header\r\n\r\n", b""),
    "name another host": (b"GET / HTTP/1.1\r\nHost: elsewhere\r\n\r\n", b""),
    "want a websocket": (
        b"GET /scene HTTP/1.1\r\n" + HOST + b"Origin: http://127.0.0.1\r\nUpgrade: websocket\r\n"
        b"Connection: upgrade\r\nSec-WebSocket-Version: 13\r\n"
        b"Sec-WebSocket-Key: AAAAAAAAAAAAAAAAAAAAAA==\r\n\r\n",
        b"",
    ),
}


@dataclass
class Cramped:
    """A server that may open few files."""

    process: subprocess.Popen
    url: str
    log: Path

    def say(self, word: str) -> None:
        self.process.stdin.write(f"{word}\n")
        self.process.stdin.flush()
        assert self.process.stdout.readline() == "done\n"


@contextmanager
def cramped_front(file, folder, *more):
    script, log = Path(__file__).parents[1] / "cramped_front.py", folder / "log"
    command = [sys.executable, str(script), str(file), str(LIMIT), *map(str, more)]
    with log.open("w") as errors:
        process = subprocess.Popen(
            command,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=errors,
            text=True,
        )
        try:
            yield Cramped(process, process.stdout.readline().strip(), log)
        finally:
            process.stdin.close()
            process.wait(6 * PATIENCE)
            process.stdout.close()


@pytest.fixture
def cramped(users, file, tmp_path):
    with cramped_front(file, tmp_path) as found:
        yield found


async def served(url, browser):
    """Somebody who is in is answered on new connections, and somebody else comes in."""
    cookie = await cookie_of(browser)
    async with asyncio.timeout(6 * PATIENCE):
        assert (await browser.get("/who"))[0] == 200
        async with raw_browser(url) as again:
            assert (await again.get("/who", Cookie=cookie))[0] == 200
        await comes_in(url)


async def comes_in(url):
    """Somebody logs in and sees the scene, if need be by trying again.

    Who connects and is slower to ask than forty others are to come is dropped as one of them.
    """
    while True:
        with suppress(ClientConnectionError):
            async with raw_browser(url) as other:
                assert await other.log_in("Vera", PASSWORD) == 303
                await other.open()
                await other.find("number")
                return


@pytest.mark.parametrize("kind", CROWDS)
def test_a_crowd_shuts_nobody_out_and_fills_no_log(cramped, kind):
    says, trickle = CROWDS[kind]

    async def look():
        async with at_the_page(cramped, "Otto") as browser:
            with crowd(cramped.url, says, CROWD, trickle) as many:
                await served(cramped.url, browser)
                assert many.comes >= CROWD
                assert not browser.socket.closed
            await served(cramped.url, browser)

    run(look(), LONG)
    assert cramped.log.stat().st_size < MOST_LOG


async def answer_to_login(url, trusting):
    """What somebody is answered who logs in; where the machine is busy, not at the first try."""
    while True:
        with suppress(ClientConnectionError):
            async with raw_browser(url, trusting) as other:
                return await other.log_in("Vera", PASSWORD)


def test_a_crowd_in_its_tls_handshake_shuts_nobody_out(users, file, tmp_path, certificate):
    trusting = ssl.create_default_context(cafile=certificate.certificate)

    async def look(url):
        async with raw_browser(url, trusting) as browser:
            assert await browser.log_in("Otto", PASSWORD) == 303
            with crowd(url, b"\x16\x03\x01", CROWD) as many:
                async with asyncio.timeout(6 * PATIENCE):
                    assert (await browser.get("/who"))[0] == 200
                    assert await answer_to_login(url, trusting) == 303
                assert many.comes >= CROWD

    with cramped_front(file, tmp_path, certificate.certificate, certificate.key) as cramped:
        run(look(cramped.url), LONG)
        assert cramped.log.stat().st_size < MOST_LOG


def test_without_file_descriptors_who_is_in_is_served_and_it_is_said_once(cramped):
    async def look():
        async with at_the_page(cramped, "Otto") as browser:
            await browser.get("/who")
            await asyncio.to_thread(cramped.say, "fill")
            async with raw_browser(cramped.url) as other:
                coming = asyncio.create_task(other.log_in("Vera", PASSWORD))
                await said(cramped, "nobody more can come in")
                for _ in range(40):
                    assert (await browser.get("/who"))[0] == 200
                    await asyncio.sleep(0.05)
                assert not browser.socket.closed
                await asyncio.to_thread(cramped.say, "free")
                assert await coming == 303
            await served(cramped.url, browser)

    run(look(), LONG)
    lines = cramped.log.read_text().splitlines()
    assert len([line for line in lines if "nobody more can come in" in line]) == 1
    assert not [line for line in lines if "out of system resource" in line]


async def said(cramped, words):
    while words not in cramped.log.read_text():
        await asyncio.sleep(0.05)


async def by_password(front, browser):
    assert await browser.log_in("Otto", PASSWORD) == 303


async def by_link(front, browser):
    assert (await browser.get(front.link.removeprefix(front.url)))[0] == 200


@pytest.mark.parametrize("come_in", [by_password, by_link])
def test_a_connection_that_asks_now_and_then_is_kept_with_a_login_alone(
    come_in, start, request, monkeypatch
):
    if come_in is by_password:
        request.getfixturevalue("users")
    front = start()

    async def look():
        async with raw_browser(front.url) as browser:
            await come_in(front, browser)
            cookie = await cookie_of(browser)
        known, stranger = connected(front.url), connected(front.url)
        try:
            known.request("GET", "/who", headers={"Cookie": cookie})
            stranger.request("GET", "/who")
            assert [one.getresponse().status for one in (known, stranger)] == [200, 401]
            monkeypatch.setattr(connection_limits, "WAIT_SECONDS", 1.0)
            for one in (known, stranger):
                one.sock.settimeout(3 * PATIENCE)
            assert await asyncio.to_thread(dropped, stranger.sock)
            known.sock.setblocking(False)
            with pytest.raises(BlockingIOError):
                await asyncio.to_thread(dropped, known.sock)
        finally:
            known.close()
            stranger.close()

    def connected(url):
        split = urlsplit(url)
        return http.client.HTTPConnection(split.hostname, split.port, timeout=3 * PATIENCE)

    def dropped(sock):
        while sock.recv(65536):
            pass
        return True

    run(look(), LONG)
