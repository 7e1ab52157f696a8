"""What a browser says to viser when it comes, without the browser."""

from collections.abc import AsyncIterator, Mapping
from contextlib import asynccontextmanager

import msgspec
import websockets

PROTOCOL = "viser-v1.1.1"

CAMERA = {
    "type": "ViewerCameraMessage",
    "wxyz": (1.0, 0.0, 0.0, 0.0),
    "position": (1.0, 1.0, 1.0),
    "fov": 1.0,
    "near": 0.01,
    "far": 1000.0,
    "image_height": 480,
    "image_width": 640,
    "look_at": (0.0, 0.0, 0.0),
    "up_direction": (0.0, 0.0, 1.0),
}


@asynccontextmanager
async def raw_browser(
    port: int, headers: Mapping[str, str] | None = None
) -> AsyncIterator[websockets.ClientConnection]:
    """Connected, and has said where its camera is: then viser tells that a client is there."""
    async with websockets.connect(
        f"ws://127.0.0.1:{port}", subprotocols=[PROTOCOL], additional_headers=headers
    ) as connection:
        await connection.send(msgspec.msgpack.encode(CAMERA))
        yield connection
