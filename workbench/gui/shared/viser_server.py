"""viser's server with what it leaves open shut.

viser 1.1.1 listens on all interfaces unless stated otherwise, takes the next port when the
wanted one is busy; it opens a public tunnel for any browser that asks, talks to pages of
other sites, and may stop talking to a browser for good.  It knows no logins either: those are
the front's, which alone has the key to a server that wants one, and says whom it brings.
Many files of `gui` use viser's internals, this one and `incoming` most of all; the version is
pinned and `tests/gui/shared/test_viser_server.py` shows when they change.
"""

# pyright: reportPrivateUsage=false

import asyncio
import contextlib
import hmac
import http
import ipaddress
import socket
import threading
from collections.abc import Callable, Generator
from dataclasses import dataclass, field
from typing import Any
from urllib.parse import unquote, urlsplit

import rich
import viser
import websockets.asyncio.server
from viser import _messages as messages
from viser.infra import _infra
from viser.infra._async_message_buffer import AsyncMessageBuffer
from websockets.http11 import Request, Response

from workbench.app.core.people import NOBODY, Person, Role
from workbench.gui.incoming.gate import MessageGate
from workbench.gui.shared.icons import keep_icons
from workbench.model.errors import InputError
from workbench.words.choosing import find_language, first_guess
from workbench.words.words import ENGLISH

POLICY_VIOLATION = 1008
"""Close code of RFC 6455, section 7.4.1."""

KEY, USER, ROLE = "X-WB-Key", "X-WB-User", "X-WB-Role"
LANGUAGE, SCHEME = "X-WB-Language", "X-WB-Scheme"
MOTION, PANEL = "X-WB-Motion", "X-WB-Panel"
"""Headers by which the front shows its key and says whom it brings; the name is URL-quoted."""

WAITING = 32 * 1024
"""Bytes that may wait in the machine for a browser; it doubles them.  Megabytes did: on a slow line
the page then showed what had been half a minute before."""


class _Bell(asyncio.Event):
    """An event that may be set from any thread, as viser does whenever it has a message.

    It sets the same event once more on the loop, to wake who waits.  But an event that is set
    already wakes nobody: a thread that set it while the loop was about to wait left that waiting,
    and each later message as well.  The browser was shown nothing new until it was reloaded.
    """

    def set(self) -> None:
        self._value = True
        if asyncio._get_running_loop() is not None:  # elsewhere nobody can be woken
            for waiting in tuple(self._waiters):
                if not waiting.done():
                    waiting.set_result(True)


@dataclass
class Messages(AsyncMessageBuffer):
    """Messages for a browser, or for all of them; none of them lies there unnoticed."""

    message_event: asyncio.Event = field(default_factory=_Bell)

    def push(self, message: Any) -> None:
        """Take a message, unless the browser has gone: what works for it may not know that yet."""
        if not self.done:
            super().push(message)


_starting = threading.Lock()
"""Held while a server starts: that takes one change to a module for a moment."""


def open_viser(host: str, port: int, secret: str | None = None) -> viser.ViserServer:
    """Listen for browsers.

    Args:
        host: address or name to listen on.
        port: 0 takes a free one.
        secret: without which nothing is answered; None lets in whoever comes.

    Raises:
        InputError: the address cannot be had; nothing listens then.
    """
    _check_address(host, port)
    keep_icons()
    infra: Any = _infra
    infra.AsyncMessageBuffer = Messages
    with _quiet(), _guard(secret):
        server = viser.ViserServer(host=host, port=port, verbose=False)
    if port not in (0, server.get_port()):
        close_viser(server)
        raise InputError(f"port {port} on {host} was taken by another program just now")
    inner = server._websock_server
    inner.unregister_handler(messages.ShareUrlRequest)
    inner.unregister_handler(messages.ShareUrlDisconnect)

    async def turn_away(connection: Any) -> None:
        raw = inner._live_connections.get(connection.client_id)
        if raw is None or raw.request is None:
            return
        headers = raw.request.headers
        if not is_own_page(headers.get("Origin"), headers.get("Host", ""), host):
            await raw.close(POLICY_VIOLATION, "this page belongs to another site")

    MessageGate(server, lambda number: _person(inner, number).name).install()
    # First in the row: viser waits for these before it reads anything from the browser.
    inner._client_connect_cb.insert(0, turn_away)
    # A browser may have come in since the server started to listen.
    inner.disconnect_all_clients()
    return server


def language_of(client: viser.ClientHandle) -> str:
    """The language of a browser: as the front says, or else what the browser likes best."""
    inner = client._viser_server._websock_server
    connection = inner._live_connections.get(client.client_id)
    if connection is None or connection.request is None:
        return ENGLISH
    headers = connection.request.headers
    language = find_language(headers.get(LANGUAGE, ""))
    return language or first_guess(", ".join(headers.get_all("Accept-Language")))


def wants_dark(client: viser.ClientHandle) -> bool:
    """Whether a browser wants a dark page, as the front says."""
    return _wish(client, SCHEME) == "dark"


def wants_less_motion(client: viser.ClientHandle) -> bool:
    """Whether a browser's system asks for little motion, as the front says."""
    return _wish(client, MOTION) == "less"


def panel_width_of(client: viser.ClientHandle) -> int | None:
    """How wide this browser's controls were last [pixels], as the front says."""
    width = _wish(client, PANEL)
    return int(width) if width.isdecimal() else None


def _wish(client: viser.ClientHandle, header: str) -> str:
    connection = client._viser_server._websock_server._live_connections.get(client.client_id)
    if connection is None or connection.request is None:
        return ""
    return str(connection.request.headers.get(header, ""))


def person_of(client: viser.ClientHandle) -> Person:
    """Who sits at a browser: whom the front has brought, or whoever came without one."""
    return _person(client._viser_server._websock_server, client.client_id)


def _person(inner: Any, number: int) -> Person:
    connection = inner._live_connections.get(number)
    if connection is None or connection.request is None:
        # Gone already; what it asked for is at least not done by somebody who may do more.
        return Person(NOBODY, Role.VIEWER)
    headers = connection.request.headers
    if USER not in headers:
        return Person(NOBODY, Role.ENGINEER)
    return Person(unquote(headers[USER]), Role(headers[ROLE]))


def is_connected(client: viser.ClientHandle) -> bool:
    """Whether a browser is still there."""
    return client.client_id in client._viser_server._websock_server._live_connections


def element_id(
    control: viser.GuiButtonHandle
    | viser.GuiUploadButtonHandle
    | viser.GuiSliderHandle[float]
    | viser.GuiVector3Handle,
) -> str:
    """The id of a control in the browser's document; of three numbers that of the first."""
    return control._impl.uuid


def taken_upload(button: viser.GuiUploadButtonHandle) -> tuple[str, bytes]:
    """Name and content of the file that was chosen last; viser would hold it until the next one."""
    file, button._impl.value = button.value, viser.UploadedFile("", b"")
    return file.name, file.content


def buttons_of(gui: viser.GuiApi) -> list[viser.GuiButtonHandle | viser.GuiUploadButtonHandle]:
    """All buttons that exist now."""
    return [
        control
        for control in tuple(gui._gui_input_handle_from_uuid.values())
        if isinstance(control, viser.GuiButtonHandle | viser.GuiUploadButtonHandle)
    ]


def close_viser(server: viser.ViserServer) -> None:
    """Stop listening and cut off all browsers."""
    with _quiet():
        server.stop()


def is_own_page(origin: str | None, asked_for: str, host: str) -> bool:
    """Whether a websocket was opened by our own page.

    Browsers send the origin of the page that opens a websocket and let any page open one to
    anywhere, this machine included; without this check any site that is visited could press
    the buttons (RFC 6455, section 10.2).  A name that leads here is no proof either (DNS
    rebinding), hence only addresses, `localhost` and the name that was asked for.

    Args:
        origin: the header of that name; programs other than browsers send none.
        asked_for: the `Host` header.
        host: that the page is served on.
    """
    if origin is None:
        return True
    try:
        page = urlsplit(origin)
        name = page.hostname or ""
    except ValueError:  # brackets that hold no address
        return False
    # Browsers write names in small letters, whatever was typed.
    known = name in ("localhost", host.lower()) or _is_address(name)
    return known and page.scheme in ("http", "https") and page.netloc == asked_for


@contextlib.contextmanager
def _guard(secret: str | None) -> Generator[None]:
    """Have the server that viser starts in this block look at each request before viser does."""
    module = websockets.asyncio.server
    with _starting:
        serve = module.serve

        def guard_serve(*args: Any, process_request: Callable[..., Any], **options: Any) -> Any:
            def look(connection: Any, request: Request) -> Any:
                ours = connection.transport.get_extra_info("socket")
                ours.setsockopt(socket.SOL_SOCKET, socket.SO_SNDBUF, WAITING)
                refusal = _look_at(request, secret)
                return refusal if refusal is not None else process_request(connection, request)

            return serve(*args, process_request=look, **options)

        module.serve = guard_serve
        try:
            yield
        finally:
            module.serve = serve


def _look_at(request: Request, secret: str | None) -> Response | None:
    """The answer to a request without the key, or None; a server without one believes no names."""
    headers = request.headers
    if secret is None:
        for name in (KEY, USER, ROLE, LANGUAGE, SCHEME, MOTION, PANEL):
            if name in headers:
                del headers[name]
        return None
    shown = headers.get_all(KEY)
    has_key = len(shown) == 1 and hmac.compare_digest(
        shown[0].encode("ascii", "surrogateescape"),  # as the library decodes headers
        secret.encode(),
    )
    is_socket = headers.get("Upgrade") is not None
    roles = headers.get_all(ROLE)
    names_somebody = len(headers.get_all(USER)) == len(roles) == 1 and roles[0] in tuple(Role)
    if has_key and (names_somebody or not is_socket):
        return None
    return Response(http.HTTPStatus.FORBIDDEN, "FORBIDDEN", websockets.Headers(), b"")


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True


def _check_address(host: str, port: int) -> None:
    """Try the address, since viser would go on to the next port, or wait for ever."""
    if not 0 <= port <= 65535:
        raise InputError(f"port must be a whole number from 0 to 65535, not {port}")
    try:
        family, kind, protocol, _, address = socket.getaddrinfo(
            host, port, type=socket.SOCK_STREAM, flags=socket.AI_PASSIVE
        )[0]
        with socket.socket(family, kind, protocol) as probe:
            probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
            probe.bind(address)
    except OSError as error:
        raise InputError(
            f"the page cannot be served on {host} port {port}: {error.strerror or error}; "
            "choose another with --host or --port"
        ) from error


@contextlib.contextmanager
def _quiet() -> Generator[None]:
    """Without viser's own announcements: what is printed is for `cli` to say."""
    console = rich.get_console()
    before, console.quiet = console.quiet, True
    try:
        yield
    finally:
        console.quiet = before
