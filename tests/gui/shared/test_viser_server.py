"""The door: who is let in, and what is shut."""

import asyncio
import collections
import queue
import socket
import threading
import urllib.error
import urllib.request

import pytest
import websockets
import websockets.asyncio.server
from raw_browser import PROTOCOL, raw_browser
from viser import _messages as messages
from viser.infra._async_message_buffer import AsyncMessageBuffer
from waiting import PATIENCE

from workbench.app.core.people import NOBODY, Person, Role
from workbench.gui.shared.viser_server import (
    Messages,
    close_viser,
    is_own_page,
    open_viser,
    person_of,
)
from workbench.model.errors import InputError


@pytest.fixture
def server():
    server = open_viser("127.0.0.1", 0)
    yield server
    close_viser(server)


async def close_code(port: int, origin: str | None) -> int | None:
    """How the server ends a websocket; None when it goes on talking."""
    async with websockets.connect(
        f"ws://127.0.0.1:{port}", subprotocols=[PROTOCOL], origin=origin
    ) as connection:
        try:
            await asyncio.wait_for(connection.recv(), PATIENCE)
        except websockets.ConnectionClosed:
            return connection.close_code
    return None


def test_only_this_machine_is_listened_to_when_asked_so(server):
    assert server.get_host() == "127.0.0.1"


def test_the_own_page_is_let_in(server):
    port = server.get_port()
    assert asyncio.run(close_code(port, f"http://127.0.0.1:{port}")) is None


def test_a_page_of_another_site_is_turned_away(server):
    assert asyncio.run(close_code(server.get_port(), "http://evil.example")) == 1008


def test_no_browser_can_open_a_public_tunnel(server):
    handlers = server._websock_server._incoming_handlers
    assert messages.GuiUpdateMessage in handlers
    assert messages.ShareUrlRequest not in handlers
    assert messages.ShareUrlDisconnect not in handlers


def person_at(secret: str | None, headers: dict[str, str]) -> Person:
    """Whom the page takes a browser for that shows these headers."""
    server = open_viser("127.0.0.1", 0, secret)
    found: queue.SimpleQueue[Person] = queue.SimpleQueue()
    server.on_client_connect(lambda client: found.put(person_of(client)))

    async def connect() -> Person:
        async with raw_browser(server.get_port(), headers):
            return await asyncio.to_thread(found.get, timeout=PATIENCE)

    try:
        return asyncio.run(connect())
    finally:
        close_viser(server)


def test_behind_a_locked_door_is_whom_the_front_has_brought():
    headers = {"X-WB-Key": "key", "X-WB-User": "Anna%20Wei%C3%9F", "X-WB-Role": "viewer"}
    assert person_at("key", headers) == Person("Anna Weiß", Role.VIEWER)


def test_at_an_open_door_nobody_is_believed():
    headers = {"X-WB-Key": "key", "X-WB-User": "Anna", "X-WB-Role": "viewer"}
    assert person_at(None, headers) == Person(NOBODY, Role.ENGINEER)


@pytest.mark.parametrize(
    "headers",
    [
        {},
        {"X-WB-Key": "ke"},
        {"X-WB-Key": "key"},
        {"X-WB-Key": "key", "X-WB-User": "Anna"},
        {"X-WB-Key": "key", "X-WB-User": "Anna", "X-WB-Role": "owner"},
        {"X-WB-Key": "other", "X-WB-User": "Anna", "X-WB-Role": "viewer"},
        {"X-WB-Key": "k\u00e9y", "X-WB-User": "Anna", "X-WB-Role": "viewer"},
    ],
)
def test_a_locked_door_stays_shut_without_the_key_and_a_person(headers):
    with pytest.raises(websockets.InvalidStatus, match="403"):
        person_at("key", headers)


def test_a_locked_door_shows_its_page_to_who_has_the_key():
    server = open_viser("127.0.0.1", 0, "key")
    url = f"http://127.0.0.1:{server.get_port()}/"
    try:
        with pytest.raises(urllib.error.HTTPError, match="403"):
            urllib.request.urlopen(url)
        with urllib.request.urlopen(urllib.request.Request(url, headers={"X-WB-Key": "key"})) as it:
            assert b"<html" in it.read()
    finally:
        close_viser(server)


def test_hanging_a_door_leaves_the_library_as_it_was(server):
    assert websockets.asyncio.server.serve.__module__ == "websockets.asyncio.server"


def test_a_busy_port_is_an_input_error_that_names_it():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"127.0.0.1 port {port}.*--port"):
            open_viser("127.0.0.1", port)


@pytest.mark.parametrize("port", [-1, 65536])
def test_a_port_out_of_range_is_an_input_error(port):
    with pytest.raises(InputError, match="from 0 to 65535"):
        open_viser("127.0.0.1", port)


def test_a_host_that_is_not_ours_is_an_input_error():
    with pytest.raises(InputError, match=r"192\.0\.2\.1"):
        open_viser("192.0.2.1", 0)


@pytest.mark.parametrize(
    ("origin", "asked_for", "host", "own"),
    [
        (None, "127.0.0.1:8080", "127.0.0.1", True),
        ("http://127.0.0.1:8080", "127.0.0.1:8080", "127.0.0.1", True),
        ("http://localhost:8080", "localhost:8080", "127.0.0.1", True),
        ("http://[::1]:8080", "[::1]:8080", "::1", True),
        ("http://10.0.0.7:8080", "10.0.0.7:8080", "0.0.0.0", True),
        ("http://cell-3:8080", "cell-3:8080", "cell-3", True),
        ("http://localhost:9999", "localhost:8080", "127.0.0.1", False),
        ("http://evil.example", "127.0.0.1:8080", "127.0.0.1", False),
        ("http://evil.example:8080", "evil.example:8080", "127.0.0.1", False),
        ("null", "127.0.0.1:8080", "127.0.0.1", False),
        ("file://", "127.0.0.1:8080", "127.0.0.1", False),
        ("http://cell-3:8080", "cell-3:8080", "Cell-3", True),
        ("http://[::1", "127.0.0.1:8080", "127.0.0.1", False),
    ],
)
def test_own_pages_are_told_from_others(origin, asked_for, host, own):
    assert is_own_page(origin, asked_for, host) is own


class JustThen(collections.deque):
    """Of those who wait for an event: another thread acts just before the first one is in it."""

    def __init__(self, act):
        super().__init__()
        self._act = act

    def append(self, waiting):
        act, self._act = self._act, lambda: None
        thread = threading.Thread(target=act)
        thread.start()
        thread.join()
        super().append(waiting)


def delivered_when_pushed_just_before_waiting(kind, patience: float) -> bool:
    """Whether a message arrives that comes while the loop is about to wait, or one after it."""

    async def deliver():
        buffer = kind(asyncio.get_running_loop(), persistent_messages=False)
        first, second = (messages.RunJavascriptMessage(source) for source in "12")
        buffer.message_event._waiters = JustThen(lambda: buffer.push(first))
        windows = buffer.window_generator(0)
        arriving = asyncio.ensure_future(anext(windows))
        try:
            await asyncio.sleep(0.1)
            threading.Thread(target=lambda: buffer.push(second)).start()
            done, _ = await asyncio.wait([arriving], timeout=patience)
            return bool(done)
        finally:
            arriving.cancel()

    return asyncio.run(deliver())


def test_a_message_that_comes_while_the_loop_is_about_to_wait_arrives():
    assert delivered_when_pushed_just_before_waiting(Messages, PATIENCE)


def test_the_library_alone_would_leave_it_lying():
    # When this fails, the library has mended it, and `Messages` can go.
    assert not delivered_when_pushed_just_before_waiting(AsyncMessageBuffer, 1.0)


def test_messages_to_one_browser_and_to_all_are_such(server):
    port, inner = server.get_port(), server._websock_server
    assert isinstance(inner._broadcast_buffer, Messages)
    seen = queue.Queue()

    async def look(connection):
        seen.put(connection.get_message_buffer())

    inner._client_connect_cb.append(look)
    asyncio.run(close_code(port, None))
    assert isinstance(seen.get(timeout=PATIENCE), Messages)
