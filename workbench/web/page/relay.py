"""Viser's page and its websocket, for those who have logged in.

viser listens on this machine alone and answers only to who knows a secret that is made anew at
each start.  It learns from us who sits at a browser; what a browser itself says about that is
never passed on.
"""

import asyncio
import hashlib
import re
import socket
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any
from urllib.parse import quote

from aiohttp import (
    ClientError,
    ClientSession,
    ClientTimeout,
    ClientWebSocketResponse,
    ClientWSTimeout,
    TCPConnector,
    hdrs,
    web,
)

from workbench.app.core.people import Person
from workbench.web.access.identity import session_of
from workbench.web.http.headers import scene_policy
from workbench.web.http.listening import MOST_UNSENT
from workbench.web.http.refusals import log_refusal
from workbench.web.page.connections import Connections
from workbench.web.page.conversation import CLOSE_SECONDS, Conversation
from workbench.web.page.languages import language_of
from workbench.web.page.pages import packed_for, sockets_of
from workbench.web.page.pieces import PATH, cut

MOST_FROM_BROWSER = 1024 * 1024
"""Bytes of one message; the biggest are parts of files, with half of that."""

MOST_FROM_VISER = 256 * 1024 * 1024

WAITING = 32 * 1024
"""Bytes from viser that may wait in the machine; it doubles them.  `gui/shared/viser_server.py` has
the same for the other end."""

HEARTBEAT = 40.0
"""A browser that does not answer for half of this [s] has gone."""

ANSWER_SECONDS = 10.0
"""[s] How long viser may take to answer, or to open a websocket."""

AHEAD_SECONDS = 1.0
"""[s] How long a login may wait for what only makes the page quicker."""

PROTOCOL = "viser-v"
"""Begins the name of the websocket protocol; viser compares the version behind it."""

SCHEME_COOKIE = "workbench-scheme"
"""Whether a browser wants the page light or dark; `static/shell.js` sets it."""

MOTION_COOKIE, PANEL_COOKIE = "workbench-motion", "workbench-panel"
"""Whether its system asks for less motion; how wide its controls were last [pixels]."""

NARROWEST, WIDEST = 320, 1200
"""[pixels] Of the controls."""


@dataclass(frozen=True, slots=True)
class Upstream:
    """Where viser listens, and the secret that opens it."""

    url: str
    secret: str


@dataclass(frozen=True, slots=True)
class _Scene:
    packed: bytes
    tag: str
    pieces: Mapping[str, bytes]


class Relay:
    """The way to viser.

    Lifetime: `open` to `close`.

    Concurrency: the front's event loop only.
    """

    def __init__(self, upstream: Upstream, connections: Connections):
        """Nothing is connected yet."""
        self._upstream = upstream
        self._connections = connections
        self._client: ClientSession | None = None
        self._scene: _Scene | None = None

    async def open(self) -> None:
        """Get ready; in the event loop that everything else runs in."""
        self._client = ClientSession(
            self._upstream.url,
            connector=TCPConnector(limit=0, socket_factory=_little_socket),
            timeout=ClientTimeout(total=None),
            auto_decompress=False,
        )

    async def close(self) -> None:
        """Cut what is connected still."""
        if self._client is not None:
            await self._client.close()

    async def page(self, request: web.Request) -> web.StreamResponse:
        """Viser's page."""
        if session_of(request) is None:
            raise web.HTTPSeeOther("/login")
        if request.query_string:
            # The page would connect to any host that its address names, and do what it says.
            raise web.HTTPSeeOther(request.path)
        scene = await self._read()
        headers = {
            **scene_policy(sockets_of(request), f"{request.scheme}://{request.host}{PATH}/"),
            "Cache-Control": "no-cache",
            "ETag": f'"{scene.tag}"',
        }
        if request.headers.get(hdrs.IF_NONE_MATCH) == f'"{scene.tag}"':
            return web.Response(status=304, headers=headers)
        body, encoding = packed_for(request, scene.packed)
        return web.Response(
            body=body,
            content_type="text/html",
            charset="utf-8",
            headers={**headers, **encoding},
        )

    async def piece(self, request: web.Request) -> web.StreamResponse:
        """A piece of viser's page; its name is its digest, so it may be kept for good.

        It is for anybody, as the login page is: viser's program, which says nothing of the cell.
        """
        piece = (await self._read()).pieces.get(request.match_info["name"])
        if piece is None:
            raise web.HTTPNotFound
        body, encoding = packed_for(request, piece)
        headers = {"Cache-Control": "private, max-age=31536000, immutable", **encoding}
        return web.Response(body=body, content_type="text/plain", charset="utf-8", headers=headers)

    async def ahead(self) -> str:
        """Addresses that browsers fetch while somebody types a password, with spaces between them.

        On a slow line that is most of what a first visit waits for.  There are none while viser
        does not answer, for which a login does not wait.
        """
        try:
            async with asyncio.timeout(AHEAD_SECONDS):
                pieces = (await self._read()).pieces
        except (web.HTTPServiceUnavailable, TimeoutError):
            return ""
        return " ".join(f"{PATH}/{name}" for name in pieces)

    async def socket(self, request: web.Request) -> web.StreamResponse:
        """Viser's websocket, for as long as browser, login and viser hold."""
        session = session_of(request)
        if session is None:
            log_refusal("websocket", why="no login", origin=request.remote)
            raise web.HTTPUnauthorized(text="Log in first.\n")
        person = session.person
        protocol = _protocol(request)
        if protocol is None or request.query_string:
            log_refusal("websocket", why="not of the page", origin=request.remote, who=person.name)
            raise web.HTTPBadRequest(text="This websocket is for the page.\n")
        with self._connections.seat(session) as seat:
            if seat is None:
                log_refusal("websocket", why="too many", origin=request.remote, who=person.name)
                raise web.HTTPTooManyRequests(text="Too many windows are open.\n")
            async with await self._connect(person, protocol, request) as viser:
                browser = web.WebSocketResponse(
                    protocols=(protocol,),
                    timeout=CLOSE_SECONDS,
                    heartbeat=HEARTBEAT,
                    max_msg_size=MOST_FROM_BROWSER,
                    # Scans and meshes go in half the bytes; on a slow line that is seconds.
                    compress=True,
                )
                await browser.prepare(request)
                if isinstance(request.transport, asyncio.WriteTransport):
                    request.transport.set_write_buffer_limits(MOST_UNSENT)
                await Conversation(browser, viser, seat, request).run()
        return browser

    async def _connect(
        self, person: Person, protocol: str, request: web.Request
    ) -> ClientWebSocketResponse:
        """A websocket to viser for somebody, in the language and the colours of the browser."""
        wishes = {
            "X-WB-Language": language_of(request),
            "X-WB-Scheme": "dark" if request.cookies.get(SCHEME_COOKIE) == "dark" else "light",
            "X-WB-Motion": "less" if request.cookies.get(MOTION_COOKIE) == "less" else "full",
            "X-WB-Panel": panel_width(request.cookies.get(PANEL_COOKIE, "")),
        }
        try:
            async with asyncio.timeout(ANSWER_SECONDS):
                return await self._ready().ws_connect(
                    "/",
                    protocols=(protocol,),
                    headers={**self._credentials(person), **wishes},
                    max_msg_size=MOST_FROM_VISER,
                    timeout=ClientWSTimeout(ws_close=1.0),  # pyright: ignore[reportCallIssue]
                )
        except (ClientError, TimeoutError) as error:
            raise web.HTTPServiceUnavailable(text="The page does not answer.\n") from error

    async def _read(self) -> _Scene:
        """The page, packed; it is the same for everybody and as long as viser runs."""
        if self._scene is None:
            headers = {**self._credentials(None), "Accept-Encoding": "gzip"}
            try:
                async with asyncio.timeout(ANSWER_SECONDS):
                    async with self._ready().get("/", headers=headers) as answer:
                        answer.raise_for_status()
                        packed = await answer.read()
                        if answer.headers.get(hdrs.CONTENT_ENCODING) == "gzip":
                            packed = zlib.decompress(packed, wbits=31)
            except (ClientError, TimeoutError) as error:
                raise web.HTTPServiceUnavailable(text="The page does not answer.\n") from error
            page = cut(packed.decode())
            self._scene = _Scene(page.page, hashlib.sha256(page.page).hexdigest()[:32], page.pieces)
        return self._scene

    def _ready(self) -> ClientSession:
        assert self._client is not None
        return self._client

    def _credentials(self, person: Person | None) -> dict[str, str]:
        headers = {"X-WB-Key": self._upstream.secret}
        if person is not None:
            headers["X-WB-User"] = quote(person.name)
            headers["X-WB-Role"] = person.role.value
        return headers


def _little_socket(address: tuple[Any, ...]) -> socket.socket:
    """A socket to viser in which little waits: what it holds back there it replaces by newer."""
    ours = socket.socket(*address[:3])
    ours.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, WAITING)
    return ours


def _protocol(request: web.Request) -> str | None:
    """The protocol that viser's page asks for."""
    offered = request.headers.get(hdrs.SEC_WEBSOCKET_PROTOCOL, "").split(",")
    return next(
        (protocol.strip() for protocol in offered if protocol.strip().startswith(PROTOCOL)), None
    )


def panel_width(cookie: str) -> str:
    """The width of the controls [pixels] that a cookie states; empty where it states none."""
    is_width = re.fullmatch(r"[0-9]{3,4}", cookie) and NARROWEST <= int(cookie) <= WIDEST
    return cookie if is_width else ""
