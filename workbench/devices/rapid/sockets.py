"""Sockets of RAPID on real TCP.

Source: Technical reference manual: RAPID instructions, functions and data types (3HAC050917),
SocketCreate to SocketPeek: one message has at most 1,024 bytes, a string 80; receiving waits 60 s
unless stated otherwise; a link that was closed by the other side is ERR_SOCK_CLOSED.  Whether
SocketPeek reports such a link as well is not said there: `peek_reports_end` chooses.
"""

# The prelude gives the types of what natives take, and every call is checked against it.
# pyright: reportUnknownLambdaType=false

import errno
import select
import socket
import weakref
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from workbench.devices.rapid.tasks import Task, TimedOut
from workbench.formats.rapid.problems import RapidError, RapidStop
from workbench.formats.rapid.values import Place
from workbench.model.errors import LinkError

USUAL_TIME = 60.0
"""[s] That receiving and accepting wait without \\Time."""

LONGEST_MESSAGE = 1024
"""Bytes."""


@dataclass(eq=False)
class Device:
    """What a socketdev holds."""

    link: socket.socket | None = None
    address: tuple[str, int] | None = None
    is_listening: bool = False
    begun: bytes = b""

    def close(self) -> None:
        """Give the connection, or the port, back."""
        if self.link is not None:
            self.link.close()
        self.link, self.address, self.is_listening, self.begun = None, None, False, b""


class Network:
    """The addresses of the controller as this machine has them.

    Whatever address a module binds stands for `host`, and the first port that one binds for `port`.

    Lifetime: the port is kept from construction until `close`.
    Concurrency: one thread at a time.
    """

    def __init__(self, host: str, port: int, peek_reports_end: bool = True) -> None:
        """Keep a port; 0 takes any free one.

        Raises:
            LinkError: it is taken.
        """
        self.host, self.peek_reports_end = host, peek_reports_end
        self.waited_for: set[socket.socket] = set()
        self._bound: float | None = None
        self._devices: weakref.WeakSet[Device] = weakref.WeakSet()
        # Nobody listens here: it only keeps the port while no module does.
        self._keeper = socket.socket()
        try:
            if port:
                _probe(host, port)
            self._keeper.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
            self._keeper.bind((host, port))
        except OSError as error:
            self._keeper.close()
            raise LinkError(f"cannot listen on {host}:{port}: {error.strerror or error}") from None

    @property
    def port(self) -> int:
        """Where clients come."""
        return self._keeper.getsockname()[1]

    def device(self) -> Device:
        """A new one, closed."""
        found = Device()
        self._devices.add(found)
        return found

    def close(self) -> None:
        """End all connections, and give the port back."""
        for device in list(self._devices):
            device.close()
        self._keeper.close()

    def idle(self, seconds: float) -> None:
        """Wait so long, or until something arrives on a socket that a task waits for."""
        links = [link for link in self.waited_for if link.fileno() >= 0]
        self.waited_for.clear()
        select.select(links, [], [], max(seconds, 0.0))

    def create(self, place: Place) -> None:
        """SocketCreate."""
        device = _device(place)
        if device.link is not None:
            raise RapidError("ERR_SOCK_IS_CONN" if device.address is None else "ERR_SOCK_IS_BOUND")
        device.link = socket.socket()
        device.link.setblocking(False)

    def bind(self, place: Place, address: str, port: float) -> None:
        """SocketBind."""
        device, link = _require_open(place)
        if device.address is not None:
            raise RapidError("ERR_SOCK_IS_BOUND")
        if not 1 <= port <= 65535:
            raise RapidError("ERR_SOCK_ADDR_INVALID")
        self._bound = port if self._bound is None else self._bound
        if port != self._bound:
            raise RapidStop(f"SocketBind: only one port is served here, {self._bound:g}")
        link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        try:
            link.bind((self.host, self.port))
        except OSError:
            raise RapidError("ERR_SOCK_ADDR_INUSE") from None
        device.address = (address, int(port))

    def connect(
        self, task: Task, place: Place, address: str, port: float, time: float | None
    ) -> None:
        """SocketConnect, to this machine alone: modules of others reach nothing else."""
        device, link = _require_open(place)
        if device.address is not None:
            raise RapidError("ERR_SOCK_IS_BOUND")
        if address != "127.0.0.1":
            raise RapidStop(f"SocketConnect: only 127.0.0.1 can be reached here, not {address}")
        if not 1 <= port <= 65535:
            raise RapidError("ERR_SOCK_ADDR_INVALID")
        try:
            link.connect((address, int(port)))
        except BlockingIOError:
            self._when(task, link, lambda: _is_connected(link), time)
        except OSError:
            raise RapidError("ERR_SOCK_CLOSED") from None
        link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)

    def listen(self, place: Place) -> None:
        """SocketListen."""
        device, link = _require_open(place)
        if device.address is None:
            raise RapidError("ERR_SOCK_NOT_BOUND")
        link.listen()
        device.is_listening = True

    def accept(
        self, task: Task, place: Place, client: Place, who: Place | None, time: float | None
    ) -> None:
        """SocketAccept."""
        device, link = _require_open(place)
        if not device.is_listening:
            raise RapidError("ERR_SOCK_NOT_BOUND")
        found, address = self._when(task, link, link.accept, time)
        found.setblocking(False)
        found.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        _device(client).close()
        _device(client).link = found
        if who is not None:
            who[0][who[1]] = address[0]

    def send(
        self, task: Task, place: Place, text: str | None, data: list[float] | None, count: Any
    ) -> None:
        """SocketSend: waits until the system has taken all of it."""
        _, link = _require_open(place)
        message = text.encode("latin-1") if text is not None else _bytes(data, count)
        if len(message) > LONGEST_MESSAGE:
            raise RapidStop(f"SocketSend: {len(message)} bytes, {LONGEST_MESSAGE} can be said")
        left = bytearray(message)

        def all_said() -> bool:
            del left[: link.send(left)]
            return not left

        self._when(task, link, all_said, USUAL_TIME)

    def receive(
        self,
        task: Task,
        place: Place,
        *,
        text: Place | None,
        data: Place | None,
        count: float | None,
        output: Place | None,
        time: float | None,
    ) -> None:
        r"""SocketReceive: what has arrived, or, with \\ReadNoOfBytes, this many bytes."""
        device, link = _require_open(place)
        if device.is_listening:
            raise RapidError("ERR_SOCK_NOT_CONN")
        most = 80 if text is not None else LONGEST_MESSAGE if data is not None else 0
        if not most or (count is not None and not 1 <= count <= most):
            raise RapidStop(f"SocketReceive: from 1 to {most} bytes can be asked for")
        least, wanted = (1, most) if count is None else (int(count), int(count))

        def whole() -> bytes | None:
            # What an earlier one, that timed out, has left may be enough.
            if len(device.begun) < least:
                piece = link.recv(wanted - len(device.begun))
                if not piece:
                    raise ConnectionResetError
                device.begun += piece
            if len(device.begun) < least:
                return None
            message, device.begun = device.begun[:wanted], device.begun[wanted:]
            return message

        message = self._when(task, link, whole, time)
        if text is not None:
            text[0][text[1]] = message.decode("latin-1")
        elif data is not None:
            array: list[float] = data[0][data[1]]
            array[: len(message)] = [float(byte) for byte in message[: len(array)]]
        if output is not None:
            output[0][output[1]] = float(len(message))

    def peek(self, place: Place) -> float:
        """SocketPeek: how many bytes have arrived."""
        device, link = _require_open(place)
        try:
            seen = link.recv(65536, socket.MSG_PEEK)
        except BlockingIOError:
            return float(len(device.begun))
        except OSError:
            seen = b""
        if not seen and self.peek_reports_end:
            raise RapidError("ERR_SOCK_CLOSED")
        return float(len(device.begun) + len(seen))

    def _when(
        self, task: Task, link: socket.socket, act: Callable[[], Any], time: float | None
    ) -> Any:
        """Do something as soon as it can be done; what came of it."""

        def attempt() -> Any:
            try:
                if found := act():
                    return found
            except BlockingIOError:
                pass
            except OSError as error:
                return error
            self.waited_for.add(link)
            return None

        try:
            found = task.wait(attempt, USUAL_TIME if time is None else time)
        except TimedOut:
            raise RapidError("ERR_SOCK_TIMEOUT") from None
        if isinstance(found, OSError):
            gone = (errno.EBADF, errno.ECONNRESET, errno.EPIPE, errno.ENOTCONN, errno.ECONNABORTED)
            is_gone = isinstance(found, ConnectionError) or found.errno in gone
            raise RapidError("ERR_SOCK_CLOSED" if is_gone else "ERR_SOCK_UNSPEC")
        return found


def _probe(host: str, port: int) -> None:
    # SO_REUSEPORT, with which the keeper and a module share the port, would share it with another
    # controller as well; this socket cannot be bound beside one that has no SO_REUSEADDR.
    with socket.socket() as link:
        link.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        link.bind((host, port))


def _device(place: Place) -> Device:
    return place[0][place[1]]


def _require_open(place: Place) -> tuple[Device, socket.socket]:
    device = _device(place)
    if device.link is None:
        raise RapidError("ERR_SOCK_CLOSED")
    return device, device.link


def _is_connected(link: socket.socket) -> bool:
    """Whether a connection that was begun stands."""
    if not select.select([], [link], [], 0)[1]:
        return False
    if error := link.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR):
        raise ConnectionRefusedError(error, "refused")
    return True


def _bytes(data: list[float] | None, count: float | None) -> bytes:
    if data is None:
        raise RapidStop("SocketSend: nothing to say")
    return bytes(int(byte) for byte in data[: int(count) if count is not None else None])


def natives(task: Task, network: Network) -> dict[str, Callable[..., Any]]:
    """The socket instructions of a task."""
    return {
        "socketcreate": network.create,
        "socketbind": network.bind,
        "socketconnect": lambda *given: network.connect(task, *given),
        "socketlisten": network.listen,
        "socketaccept": lambda *given: network.accept(task, *given),
        "socketsend": lambda *given: network.send(task, *given),
        "socketreceive": lambda place, text, data, count, output, time: network.receive(
            task, place, text=text, data=data, count=count, output=output, time=time
        ),
        "socketclose": lambda place: _device(place).close(),
        "socketpeek": network.peek,
    }
