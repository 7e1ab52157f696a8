"""The robot program's side of the conversation: it asks until it has the answer, and once only."""

import socket
import time
from collections.abc import Callable

from workbench.devices.pick_server.conversation import VERSION, Words
from workbench.devices.pick_server.lines import (
    ANSWERS,
    Form,
    LineBuffer,
    line_bytes,
    number_after,
    words_of,
)
from workbench.model.errors import LinkError, ProtocolError

AGAIN = 1.0
"""[s] A request without an answer is sent again after this time."""

POLL_EVERY = 0.05


class Asker:
    """One run of a robot program.

    Lifetime: until `close`; connections come and go.  Used by one thread.
    """

    def __init__(
        self,
        host: str,
        port: int,
        form: Form,
        run: int,
        is_over: Callable[[], bool],
        again: float = AGAIN,
        *,
        version: str = VERSION,
    ) -> None:
        """Get ready.

        Args:
            host: of the server.
            port: of the server.
            form: of the lines.
            run: 1 to 9999, another one than that of the run before.
            is_over: whether to give up.
            again: [s] after which a request without an answer is sent again.
            version: of the protocol.
        """
        self._version = version
        self._address, self._form, self._run, self._is_over = (host, port), form, run, is_over
        self._again = again
        self._link: socket.socket | None = None
        self._lines = LineBuffer(form)
        self._number, self._session = 0, ""

    def ask(self, job: str, *words: str) -> Words:
        """The answer to one job: its words without the number.

        Raises:
            LinkError: another server answers, or the asking was ended.
        """
        self._number = number_after(self._number)
        request = line_bytes(self._form, str(self._number), job, *words)
        while not self._is_over():
            try:
                if self._link is None:
                    self._connect()
                answer = self._answer_to(request, self._number)
            except OSError:
                self.close()
                time.sleep(POLL_EVERY)
                continue
            if answer:
                return answer
        raise LinkError("the asking was ended")

    def close(self) -> None:
        """End the connection."""
        if self._link is not None:
            self._link.close()
        self._link = None

    def _connect(self) -> None:
        self._link = socket.create_connection(self._address, AGAIN)
        self._link.settimeout(POLL_EVERY)
        self._lines = LineBuffer(self._form)
        hello = line_bytes(self._form, "0", "hello", self._version, str(self._run))
        answer = self._answer_to(hello, 0)
        if len(answer) != 4 or answer[0] != "OK":
            raise OSError("no greeting")
        session = answer[2]
        if self._session not in ("", session):
            raise LinkError("another server answers")
        if not self._session:
            self._session = session

    def _answer_to(self, request: bytes, number: int) -> Words:
        """The answer with this number; empty where none came in time, or the line was damaged."""
        if self._link is None:
            return ()
        self._link.sendall(request)
        until = time.monotonic() + self._again
        while time.monotonic() < until and not self._is_over():
            try:
                data = self._link.recv(4096)
            except TimeoutError:
                continue
            if not data:
                raise OSError("closed")
            for line in self._lines.split(data):
                try:
                    heard, word, *rest = words_of(self._form, line)
                    word = ANSWERS[int(word)] if self._form.is_coded else word
                    is_this = int(heard) == number and (number or word == "OK")
                except (ProtocolError, ValueError, IndexError):
                    return ()
                if is_this:
                    return (word, *rest)
                if heard == "0" and word == "ERR":
                    if rest == ["hello"]:
                        raise OSError("not greeted")
                    return ()
        return ()
