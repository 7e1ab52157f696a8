"""A browser without a screen: logs in, opens the scene's websocket, reads, and says anything.

What viser's page would send and what nobody should: the front is attacked and loaded with it.
Frames of viser are, after two lengths of 8 bytes, a map packed by Zstandard, and raw arrays
(`viser.infra._infra._message_producer`).
"""

import asyncio
import ssl
import uuid
from collections.abc import AsyncGenerator, Mapping
from contextlib import asynccontextmanager
from typing import Any

import aiohttp
import msgspec
import zstandard

PROTOCOL = "viser-v1.1.1"

PART_BYTES = 512 * 1024
"""Of every part of a file but the last, by viser's page (`UploadButton.tsx`)."""

FAREWELL = 0.1
"""How long connections over TLS, which close in steps, have before the event loop ends [s]."""

CAMERA: Mapping[str, Any] = {
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (2.0, 2.0, 2.0),
    "fov": 1.0,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 720,
    "image_width": 1280,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}
"""Where a browser looks from; viser makes no widgets for one that has not said that."""


class RawBrowser:
    """One browser.

    Lifetime: inside `raw_browser`.

    Concurrency: one event loop.
    """

    def __init__(self, url: str, session: aiohttp.ClientSession):
        """Made by `raw_browser`."""
        self.url = url
        self.session = session
        self.socket: aiohttp.ClientWebSocketResponse | None = None
        self.frames = 0
        self.bytes = 0
        self.widgets: dict[str, str] = {}
        """Ids of widgets, by label; of several the first."""
        self.disabled: dict[str, bool] = {}
        """Whether a widget cannot be used now, by id."""
        self.texts: dict[str, str] = {}
        """What stands in the page beside widgets, by id."""
        self.refused: list[str] = []
        """Why something was not done, as notes have reported it."""

    async def log_in(self, name: str, password: str) -> int:
        """Fill in the form; the status of the answer, 303 when it is right."""
        form = {"name": name, "password": password}
        return await self.post("/login", form)

    async def post(self, path: str, form: Mapping[str, str], **headers: str) -> int:
        """Send a form from our own page, unless the headers say otherwise; the status."""
        async with self.session.post(
            self.url + path,
            data=form,
            headers={"Origin": self.url, **headers},
            allow_redirects=False,
        ) as answer:
            return answer.status

    async def get(self, path: str, **headers: str) -> tuple[int, str]:
        """The status and the text of an answer; redirects are not followed."""
        async with self.session.get(
            self.url + path, headers=headers, allow_redirects=False
        ) as answer:
            return answer.status, await answer.text(errors="replace")

    async def open(self, path: str = "/scene", **headers: str) -> None:
        """Open the scene's websocket as its page does, unless the headers say otherwise.

        Raises:
            aiohttp.WSServerHandshakeError: it is refused.
        """
        self.socket = await self.session.ws_connect(
            self.url + path,
            protocols=(PROTOCOL,),
            headers={"Origin": self.url, **headers},
            max_msg_size=0,
            compress=15,  # as browsers do
        )
        await self.send("ViewerCameraMessage", **CAMERA)

    async def send(self, kind: str, **fields: Any) -> None:
        """Send one message of viser's protocol."""
        await self.send_raw(msgspec.msgpack.encode({"type": kind, **fields}))

    async def send_raw(self, frame: bytes) -> None:
        """Send any bytes."""
        assert self.socket is not None
        await self.socket.send_bytes(frame)

    async def set(self, label: str, value: object) -> None:
        """Use a widget: press a button (True), or give another value."""
        await self.send("GuiUpdateMessage", uuid=self.widgets[label], updates={"value": value})

    async def upload(self, label: str, name: str, content: bytes) -> None:
        """Choose a file with an upload button; it is there once the answers were read."""
        widget, transfer = self.widgets[label], uuid.uuid4().hex
        parts = range(0, len(content), PART_BYTES)
        about = {"source_component_uuid": widget, "transfer_uuid": transfer}
        await self.send(
            "FileTransferStartUpload",
            **about,
            filename=name,
            mime_type="application/octet-stream",
            part_count=len(parts),
            size_bytes=len(content),
        )
        for number, begin in enumerate(parts):
            part = content[begin : begin + PART_BYTES]
            await self.send("FileTransferPart", **about, part_index=number, content=part)

    async def read(self) -> list[dict[str, Any]] | None:
        """The messages of the next frame; None when the websocket is closed."""
        assert self.socket is not None
        frame = await self.socket.receive()
        if frame.type is not aiohttp.WSMsgType.BINARY:
            return None
        self.frames += 1
        self.bytes += len(frame.data)
        messages = unpack(frame.data)
        for message in messages:
            self._learn(message)
        return messages

    def _learn(self, message: dict[str, Any]) -> None:
        shown: dict[str, Any] = message.get("props") or message.get("updates") or {}
        widget = message.get("uuid")
        if widget is None:
            return
        if "props" in message and "label" in shown:
            self.widgets.setdefault(shown["label"], widget)
        if message["type"] == "NotificationShowMessage" and shown.get("color") == "red":
            self.refused.append(shown["body"])
        if isinstance(shown.get("content"), str):
            self.texts[widget] = shown["content"]
        if "disabled" in shown:
            self.disabled[widget] = bool(shown["disabled"])

    async def find(self, label: str) -> None:
        """Read until there is a widget with this label.

        Raises:
            ConnectionError: the websocket was closed before.
        """
        while label not in self.widgets:
            if await self.read() is None:
                raise ConnectionError(f"closed before there was a widget {label!r}")

    async def find_enabled(self, label: str, *, is_enabled: bool = True) -> None:
        """Read until the widget with this label can be used, or cannot.

        Raises:
            ConnectionError: the websocket was closed before.
        """
        while self.disabled.get(self.widgets.get(label, "")) != (not is_enabled):
            if await self.read() is None:
                raise ConnectionError(f"closed before the widget {label!r} was so")

    async def close_code(self) -> int | None:
        """Read until the websocket is closed; the code that it was closed with."""
        assert self.socket is not None
        while await self.read() is not None:
            pass
        return self.socket.close_code


@asynccontextmanager
async def raw_browser(url: str, tls: ssl.SSLContext | bool = True) -> AsyncGenerator[RawBrowser]:
    """A browser that has not logged in.

    Args:
        url: of the front, without a path.
        tls: which certificates are trusted.
    """
    # Cookies of addresses count as well: there is no name to trust in tests.
    jar = aiohttp.CookieJar(unsafe=True)
    connector = aiohttp.TCPConnector(ssl=tls, limit=0)
    async with aiohttp.ClientSession(cookie_jar=jar, connector=connector) as session:
        browser = RawBrowser(url, session)
        try:
            yield browser
        finally:
            if browser.socket is not None:
                await browser.socket.close()
    if tls is not True:
        await asyncio.sleep(FAREWELL)


def unpack(frame: bytes) -> list[dict[str, Any]]:
    """The messages of one frame of viser, without their arrays."""
    size, packed = (int.from_bytes(frame[i : i + 8], "little") for i in (0, 8))
    inner = zstandard.ZstdDecompressor().decompress(frame[16 : 16 + packed], size)
    return msgspec.msgpack.decode(inner)["messages"]
