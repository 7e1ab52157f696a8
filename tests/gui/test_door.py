"""The door: who is let in, and what is shut."""

import asyncio
import socket

import pytest
import websockets
from viser import _messages as messages

from workbench.gui.door import close_door, is_own_page, open_door
from workbench.model.errors import InputError

PROTOCOL = "viser-v1.1.1"


@pytest.fixture
def server():
    server = open_door("127.0.0.1", 0)
    yield server
    close_door(server)


async def close_code(port: int, origin: str | None) -> int | None:
    """How the server ends a websocket; None when it goes on talking."""
    async with websockets.connect(
        f"ws://127.0.0.1:{port}", subprotocols=[PROTOCOL], origin=origin
    ) as connection:
        try:
            await asyncio.wait_for(connection.recv(), 5)
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


def test_a_busy_port_is_an_input_error_that_names_it():
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = taken.getsockname()[1]
        with pytest.raises(InputError, match=f"127.0.0.1 port {port}.*--port"):
            open_door("127.0.0.1", port)


@pytest.mark.parametrize("port", [-1, 65536])
def test_a_port_out_of_range_is_an_input_error(port):
    with pytest.raises(InputError, match="from 0 to 65535"):
        open_door("127.0.0.1", port)


def test_a_host_that_is_not_ours_is_an_input_error():
    with pytest.raises(InputError, match=r"192\.0\.2\.1"):
        open_door("192.0.2.1", 0)


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
    ],
)
def test_own_pages_are_told_from_others(origin, asked_for, host, own):
    assert is_own_page(origin, asked_for, host) is own
