"""The pick server on TCP: it listens, and hands lines to the conversation."""

import socket
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager, suppress
from dataclasses import dataclass

from workbench.devices.pick_server.axes import AxisWords
from workbench.devices.pick_server.conversation import PickConversation
from workbench.devices.pick_server.lines import Form, LineBuffer
from workbench.model.cell import Cell, Controller
from workbench.model.errors import LinkError
from workbench.model.messages.work import AskText

MOST_CONNECTIONS = 4
"""At the same time: one robot program, and what is left of those before it."""

MOST_BAD = 50
"""Lines in a row that cannot be taken, after which a connection is closed."""

GREETING = 10.0
"""[s] After which a connection is closed that is not the robot program's."""

POLL_EVERY = 0.2

LINGER = 3.0
"""[s] A server listens this long after its last use: the next user has the same conversation."""


class Server:
    """Listens at one address.

    Lifetime: from construction until `close`.  Concurrency: a thread accepts, and each connection
    has one.
    """

    def __init__(self, host: str, port: int, axes: AxisWords, client: str = "") -> None:
        """Listen; `client` is the one address that may connect, empty: any.

        Raises:
            LinkError: the address cannot be had.
        """
        self.conversation = PickConversation(axes)
        self._form, self._client = axes.form, client
        self._over = threading.Event()
        self._open = threading.BoundedSemaphore(MOST_CONNECTIONS)
        try:
            self._socket = socket.create_server((host, port), backlog=MOST_CONNECTIONS)
        except (OSError, OverflowError) as error:
            address = f"{host}:{port}"
            raise LinkError(AskText.NO_ADDRESS(address=address, problem=str(error))) from error
        self._socket.settimeout(POLL_EVERY)
        self._threads = [threading.Thread(target=self._accept, name="pick server", daemon=True)]
        self._threads[0].start()

    def close(self) -> None:
        """Close all connections, and listen no more."""
        self._over.set()
        self._threads[0].join()
        for thread in self._threads[1:]:
            thread.join()

    def _accept(self) -> None:
        with self._socket:
            while not self._over.is_set():
                try:
                    link, (address, *_) = self._socket.accept()
                except OSError:
                    continue
                is_welcome = self._client in ("", address)
                if not is_welcome or not self._open.acquire(blocking=False):
                    link.close()
                    continue
                thread = threading.Thread(target=self._talk, args=(link,), daemon=True)
                self._threads = [t for t in self._threads if t.is_alive()] + [thread]
                thread.start()

    def _talk(self, link: socket.socket) -> None:
        try:
            with link, suppress(OSError):
                link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
                link.settimeout(POLL_EVERY)
                _answer_all(link, self.conversation, self._form, self._over)
        finally:
            self.conversation.leave(link)
            self._open.release()


def _answer_all(
    link: socket.socket, conversation: PickConversation, form: Form, over: threading.Event
) -> None:
    """Answer line after line, until the connection ends or is another's."""
    lines, bad, began, was_owner = LineBuffer(form), 0, time.monotonic(), False
    while not over.is_set():
        is_owner = conversation.owns(link)
        # Whatever it sends meanwhile: places are few.
        is_late = time.monotonic() - began > GREETING
        if (was_owner and not is_owner) or (not is_owner and is_late):
            return
        was_owner = is_owner
        try:
            data = link.recv(4096)
        except TimeoutError:
            continue
        if not data:
            return
        for line in lines.split(data):
            answer = conversation.hear(link, line)
            link.sendall(answer)
            is_bad = answer.startswith(b"0") and not conversation.owns(link)
            bad = bad + 1 if is_bad or b"ERR" in answer else 0
            if bad > MOST_BAD:
                return


@dataclass(slots=True)
class Shared:
    """A server, how many use it now, and how many times it was taken into use."""

    server: Server
    users: int = 0
    uses: int = 0


_LOCK = threading.Lock()
_SERVERS: dict[tuple[str, int], Shared] = {}


@contextmanager
def listening(cell: Cell, axes: AxisWords, client: str) -> Generator[Server]:
    """The server at the cell's address, shared by all users in this process.

    Raises:
        LinkError: the address cannot be had.
    """
    address = _address(cell.controller)
    with _LOCK:
        shared = _SERVERS.get(address)
        if shared is None:
            shared = _SERVERS[address] = Shared(Server(*address, axes, client))
        shared.users += 1
        shared.uses += 1
    try:
        yield shared.server
    finally:
        with _LOCK:
            shared.users -= 1
            timer = threading.Timer(LINGER, _close_unused, (address, shared, shared.uses))
        timer.daemon = True
        timer.start()


def _close_unused(address: tuple[str, int], shared: Shared, uses: int) -> None:
    """Close a server that nobody uses, nor has used since."""
    with _LOCK:
        if _SERVERS.get(address) is not shared or shared.users or shared.uses != uses:
            return
        del _SERVERS[address]
        # Nobody else may listen there before this one has ended.
        shared.server.close()


def _address(controller: Controller) -> tuple[str, int]:
    return controller.host, controller.port
