"""Ports for tests whose cell names a port before anybody listens there."""

import secrets
import socket
from contextlib import suppress

PORTS = range(20_000, 32_000)
"""Below the ports that a system gives to sockets without a number: it gives none of these away."""


def free_port() -> int:
    """A TCP port of this machine on which nobody listens, and on which no other socket opens."""
    for _ in range(100):
        port = secrets.choice(PORTS)
        with suppress(OSError), socket.create_server(("127.0.0.1", port)):
            return port
    raise AssertionError("no port is free")
