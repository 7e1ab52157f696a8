"""What a browser says to viser when it comes, without the browser."""

import asyncio
import contextlib
import threading
from collections.abc import AsyncIterator, Iterator, Mapping, Sequence
from contextlib import asynccontextmanager, contextmanager

import imageio.v3 as iio
import msgspec
import numpy as np
import pinocchio as pin
import websockets

from workbench.studies.load.raw_browser import unpack

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


PICTURE = iio.imwrite("<bytes>", np.zeros((8, 8, 3), np.uint8), extension=".jpeg")


class Sitting:
    """A browser that reads what it is sent, and draws it while its page `is_in_front`.

    Its camera goes where it is sent, or where somebody turns it to.
    """

    def __init__(self, port: int):
        self.is_in_front = True
        self.drawn = 0
        self.looks_from = np.array(CAMERA["position"])
        self.looks_at = np.array(CAMERA["look_at"])
        self._is_turned = True
        self._left = threading.Event()
        self._port = port

    def leave(self) -> None:
        self._left.set()

    def look(self, position: Sequence[float], target: Sequence[float]) -> None:
        """Turn the camera by hand: from where, and at what, each (3,) [m]."""
        self.looks_from, self.looks_at = np.array(position), np.array(target)
        self._is_turned = True

    def _camera(self) -> bytes:
        """What it says of its camera: viser's looks along z, with y down."""
        z = (self.looks_at - self.looks_from) / np.linalg.norm(self.looks_at - self.looks_from)
        x = np.cross(z, CAMERA["up_direction"])
        x /= np.linalg.norm(x)
        turn = pin.Quaternion(np.stack([x, np.cross(z, x), z], axis=1))
        told = {"position": self.looks_from.tolist(), "look_at": self.looks_at.tolist()}
        told["wxyz"] = (turn.w, turn.x, turn.y, turn.z)
        return msgspec.msgpack.encode(CAMERA | told)

    def _heard(self, message: dict) -> None:
        if message["type"] == "SetCameraPositionMessage":
            self.look(message["position"], self.looks_at)
        if message["type"] == "SetCameraLookAtMessage":
            self.look(self.looks_from, message["look_at"])

    async def sit(self) -> None:
        async with raw_browser(self._port) as connection:
            asked: list[str] = []
            while not self._left.is_set():
                with contextlib.suppress(TimeoutError):
                    frame = await asyncio.wait_for(connection.recv(), 0.02)
                    for message in unpack(frame):
                        self._heard(message)
                        if message["type"] == "GetRenderRequestMessage":
                            asked.append(message["render_uuid"])
                if self._is_turned:
                    self._is_turned = False
                    await connection.send(self._camera())
                while asked and self.is_in_front:
                    answer = {"type": "GetRenderResponseMessage", "payload": PICTURE}
                    answer["render_uuid"] = asked.pop(0)
                    await connection.send(msgspec.msgpack.encode(answer))
                    self.drawn += 1


@contextmanager
def sitting(port: int) -> Iterator[Sitting]:
    """A browser in a thread of its own, until the block ends or it leaves."""
    browser = Sitting(port)
    thread = threading.Thread(target=lambda: asyncio.run(browser.sit()))
    thread.start()
    try:
        yield browser
    finally:
        browser.leave()
        thread.join()
