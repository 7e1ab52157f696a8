"""A controller's port that is closed: for a moment, and for good."""

import socket

import pytest

from workbench.devices.abb_socket import connecting
from workbench.model.errors import LinkError


@pytest.fixture
def port():
    """One on which nobody listens."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        return server.getsockname()[1]


def test_a_port_that_is_closed_between_two_conversations_is_tried_again(port, monkeypatch):
    opened = []

    def listen(_):
        opened.append(socket.create_server(("127.0.0.1", port)))

    monkeypatch.setattr(connecting.time, "sleep", listen)
    with connecting.connect("127.0.0.1", port) as link:
        assert link.getpeername() == ("127.0.0.1", port)
    (server,) = opened
    server.close()


def test_a_port_that_stays_closed_is_told(port, monkeypatch):
    waited = []
    monkeypatch.setattr(connecting.time, "sleep", waited.append)
    with pytest.raises(LinkError, match=f"no controller answers at 127.0.0.1:{port}"):
        connecting.connect("127.0.0.1", port)
    assert waited == list(connecting.AGAIN_SECONDS)
