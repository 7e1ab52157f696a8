"""TCP connections to a controller: for motion, and for what it reports."""

import socket
import time

from workbench.model.errors import LinkError
from workbench.model.messages.devices import DeviceText

CONNECT_SECONDS = 3.0

AGAIN_SECONDS = (0.1, 0.3, 1.0)
"""A port that refuses is tried again after these: a program in RAPID that listens for one link at a
time closes it between two of them."""

POLL_SECONDS = 0.05
"""How long reading waits for bytes before it gives up with `TimeoutError`."""

KEEPALIVE = {"TCP_KEEPIDLE": 1, "TCP_KEEPINTVL": 1, "TCP_KEEPCNT": 3, "TCP_USER_TIMEOUT": 5000}
"""[s, s, times, ms] So that the system, too, notices a machine that is gone."""


def connect(host: str, port: int, missing: DeviceText = DeviceText.NO_ANSWER) -> socket.socket:
    """A connection to a controller; `missing` says that nobody answers, and why.

    Raises:
        LinkError: nobody answers.
    """
    try:
        link = _open(host, port)
    except (OSError, UnicodeError) as error:  # UnicodeError: a name that no host can have
        reason = getattr(error, "strerror", None) or error
        raise LinkError(missing(address=f"{host}:{port}", reason=str(reason))) from None
    link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    link.setsockopt(socket.SOL_SOCKET, socket.SO_KEEPALIVE, 1)
    for option, value in KEEPALIVE.items():
        if hasattr(socket, option):  # not every system has all of them
            link.setsockopt(socket.IPPROTO_TCP, getattr(socket, option), value)
    link.settimeout(POLL_SECONDS)
    return link


def _open(host: str, port: int) -> socket.socket:
    for pause in AGAIN_SECONDS:
        try:
            return socket.create_connection((host, port), CONNECT_SECONDS)
        except ConnectionRefusedError:
            time.sleep(pause)
    return socket.create_connection((host, port), CONNECT_SECONDS)
