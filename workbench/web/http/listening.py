"""The socket that browsers come to, bound before anything else is started."""

import contextlib
import socket
import ssl
from dataclasses import dataclass
from pathlib import Path

from workbench.model.errors import FileError, InputError

BACKLOG = 1024
"""Connections that the machine holds until they are taken; others try again, seconds later."""


@dataclass(frozen=True, slots=True)
class TlsCertificate:
    """What the page is served over TLS with."""

    certificate: Path
    key: Path

    def context(self) -> ssl.SSLContext:
        """For the server's side of TLS 1.2 and newer.

        Raises:
            FileError: the files cannot be used.
        """
        for path in (self.certificate, self.key):
            if not path.is_file():
                raise FileError(
                    path, "no such file; a certificate and its key in PEM were expected"
                )
        context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        context.minimum_version = ssl.TLSVersion.TLSv1_2
        try:
            # An empty password: otherwise the one of an encrypted key would be asked for here.
            context.load_cert_chain(self.certificate, self.key, password="")
        except (ssl.SSLError, OSError, ValueError) as error:
            raise FileError(
                self.certificate,
                f"cannot be used with {self.key}: {error}; a certificate and its key in PEM, "
                "the key not encrypted, were expected",
            ) from error
        return context


def listen(host: str, port: int) -> socket.socket:
    """Bind an address.

    Args:
        host: address or name.
        port: 0 takes a free one.

    Raises:
        InputError: it cannot be had.
    """
    if not 0 <= port <= 65535:
        raise InputError(f"port must be a whole number from 0 to 65535, not {port}")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        bound = socket.socket(family, kind, protocol)
    except OSError as error:
        raise _not_had(host, port, error) from error
    try:
        bound.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        if family == socket.AF_INET6 and host == "::":
            bound.setsockopt(socket.IPPROTO_IPV6, socket.IPV6_V6ONLY, 0)
        bound.bind(address)
        bound.listen(BACKLOG)
        _bear_slow_lines(bound)
    except OSError as error:
        bound.close()
        raise _not_had(host, port, error) from error
    return bound


MOST_UNSENT = 16 * 1024
"""Bytes that the machine takes from us before they can go out.  More would wait there: what is
drawn is the newest only as long as it is here that it waits."""


def _bear_slow_lines(bound: socket.socket) -> None:
    """Let little wait in the machine; and do not take each lost packet for a jam, if we may.

    With 2 % of them lost and 200 ms there and back the usual control of TCP uses a third of a
    line of 1 Mbit/s.  Connections have it from the socket that they come in by.
    """
    bound.setsockopt(socket.IPPROTO_TCP, socket.TCP_NOTSENT_LOWAT, MOST_UNSENT)
    with contextlib.suppress(OSError, AttributeError):
        bound.setsockopt(socket.IPPROTO_TCP, socket.TCP_CONGESTION, b"bbr")


def _not_had(host: str, port: int, error: OSError) -> InputError:
    return InputError(
        f"the page cannot be served on {host} port {port}: {error.strerror or error}; "
        "choose another with --host or --port"
    )
