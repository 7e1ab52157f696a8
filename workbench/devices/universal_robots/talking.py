"""Our side of the process with the foreign client: lines of JSON, no longer waits than said."""

import contextlib
import importlib.util
import json
import os
import select
import socket
import subprocess
import sys
from typing import Any

from workbench.model.errors import LinkError, ProtocolError
from workbench.model.messages.devices import DeviceText
from workbench.plugins.extras import install_command

CONNECT_SECONDS = 3.0

GOODBYE = 2.0
"""[s] The client may take to end by itself: the last word to it may be a stop."""


class Client:
    """The foreign client, connected to one controller."""

    def __init__(self, host: str, ports: tuple[int, ...], *, sends: bool) -> None:
        """Begin to connect.

        Args:
            host: of the controller.
            ports: which have to answer, that for programs first.
            sends: whether programs are to be sent, or only states read.

        Raises:
            LinkError: nobody answers, or the library is not installed.
        """
        if importlib.util.find_spec("rtde_receive") is None:
            raise LinkError(
                DeviceText.LIBRARY(library="ur-rtde", command=install_command("ur-rtde"))
            )
        for port in ports:
            try:
                socket.create_connection((host, port), CONNECT_SECONDS).close()
            except (OSError, UnicodeError) as error:
                reason = getattr(error, "strerror", None) or error
                raise LinkError(
                    DeviceText.NO_ANSWER(address=f"{host}:{port}", reason=str(reason))
                ) from None
        way = "send" if sends else "watch"
        words = [sys.executable, "-P", "-m", "workbench.devices.universal_robots.client"]
        self._process = subprocess.Popen(
            [*words, host, str(ports[0]), way],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            # Where we were found, it finds us.
            env=os.environ
            | {"PYTHONPATH": os.pathsep.join(folder for folder in sys.path if folder)},
        )
        assert self._process.stdin is not None and self._process.stdout is not None
        self._in, self._out = self._process.stdin, self._process.stdout
        self._heard = b""

    def __enter__(self) -> "Client":
        return self

    def __exit__(self, *_: object) -> None:
        with contextlib.suppress(OSError):
            self._in.close()
        try:
            self._process.wait(GOODBYE)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._out.close()

    def say(self, **asked: Any) -> None:
        """A line to the client.

        Raises:
            LinkError: it has ended.
        """
        try:
            self._in.write(json.dumps(asked).encode() + b"\n")
            self._in.flush()
        except OSError:
            raise LinkError(DeviceText.CLIENT_ENDED()) from None

    def hear(self, seconds: float) -> dict[str, Any] | None:
        """The next line; None when none came within so long.

        Raises:
            LinkError: it has ended, or reports a problem.
        """
        while b"\n" not in self._heard:
            if not select.select([self._out], [], [], seconds)[0]:
                return None
            data = os.read(self._out.fileno(), 1 << 16)
            if not data:
                raise LinkError(DeviceText.CLIENT_ENDED())
            self._heard += data
        line, self._heard = self._heard.split(b"\n", 1)
        try:
            message = dict[str, Any](json.loads(line))
        except (ValueError, TypeError):
            raise ProtocolError(f"the controller's client says {line[:40]!r}") from None
        if "problem" in message:
            raise LinkError(DeviceText.CLIENT(problem=str(message["problem"])))
        return message
