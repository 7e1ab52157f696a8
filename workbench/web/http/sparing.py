"""A log that nobody outside can fill: of lines that come too often some are left out, and counted.

What is refused is one line each, and the libraries below us write many for each connection that
they cannot make sense of; who may connect could have them written as fast as he asks.
"""

import logging
import threading
import time
from collections.abc import Callable, Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass

from aiohttp import web
from aiohttp.http_exceptions import HttpProcessingError

from workbench.web.http.broken_connections import is_broken_off

AT_ONCE = 50
"""Lines of one kind that may be written together."""

AT_ONCE_BELOW = 5
"""The same for libraries, which add to each where in their code it happened."""

SECONDS = 5.0
"""[s] After which one more may."""

MOST_KINDS = 64
"""Beyond these all kinds count as one: some lines are never the same twice."""

OTHERS = "others"

LOGGERS = {
    "workbench.web": AT_ONCE,
    "workbench.gui.incoming.gate": AT_ONCE,
    "workbench.extras.opcua.bounds": AT_ONCE,
    "workbench.extras.opcua.certificates": AT_ONCE,
    "workbench.extras.opcua.admission": AT_ONCE,
    "workbench.extras.opcua.server": AT_ONCE,
    "workbench.extras.modbus.jobs": AT_ONCE,
    "workbench.extras.modbus.server": AT_ONCE,
    "aiohttp.server": AT_ONCE_BELOW,
    "asyncio": AT_ONCE_BELOW,
    "websockets.server": AT_ONCE_BELOW,
    "asyncua.server.binary_server_asyncio": AT_ONCE_BELOW,
    "asyncua.server.uaprocessor": AT_ONCE_BELOW,
    "pymodbus.logging": AT_ONCE_BELOW,
}
"""That write what others cause."""


@dataclass(slots=True)
class _Kind:
    credit: float
    counted: float
    left_out: int = 0


class Sparing(logging.Filter):
    """Lets through what is written at a moderate pace; lines are of one kind by their form.

    Concurrency: any thread.
    """

    def __init__(self, at_once: int, clock: Callable[[], float] = time.monotonic):
        """Nothing was written yet.

        Args:
            at_once: lines of a kind that may be written together.
            clock: returns [s] and does not jump.
        """
        super().__init__()
        self._at_once = at_once
        self._clock = clock
        self._kinds: dict[str, _Kind] = {}
        self._lock = threading.Lock()

    def filter(self, record: logging.LogRecord) -> bool:
        """Whether the line is to be written; says with it how many of its kind were not."""
        if _is_redundant(record):
            return False
        _shorten(record)
        with self._lock:
            form = str(record.msg)
            if form not in self._kinds and len(self._kinds) >= MOST_KINDS:
                form = OTHERS
            now = self._clock()
            kind = self._kinds.setdefault(form, _Kind(self._at_once, now))
            kind.credit = min(self._at_once, kind.credit + (now - kind.counted) / SECONDS)
            kind.counted = now
            if kind.credit < 1.0:
                kind.left_out += 1
                return False
            kind.credit -= 1.0
            left_out, kind.left_out = kind.left_out, 0
        if left_out:
            record.msg = f"{record.getMessage()} ({left_out} lines like this were left out before)"
            record.args = None
        return True


def _is_redundant(record: logging.LogRecord) -> bool:
    """Whether a library logs an error as unhandled that was answered or cannot be.

    The library reads the rest of a body after the answer.  The body may differ from what its head
    states, or the client may have closed the connection.
    """
    error = record.exc_info[1] if record.exc_info else None
    is_of_body = isinstance(error, web.RequestPayloadError) or is_broken_off(error)
    return record.name == "aiohttp.server" and is_of_body


def _shorten(record: logging.LogRecord) -> None:
    """One line for what a stranger has sent: where in a library that was found shows nothing."""
    error = record.exc_info[1] if record.exc_info else None
    if isinstance(error, HttpProcessingError | web.RequestPayloadError):
        record.msg, record.args = "%s: %s", (record.getMessage(), " ".join(str(error).split()))
        record.exc_info = None


@contextmanager
def sparing() -> Generator[None]:
    """Keep the loggers of `LOGGERS` sparing as long as the block runs."""
    with ExitStack() as undo:
        for name, at_once in LOGGERS.items():
            logger, spares = logging.getLogger(name), Sparing(at_once)
            logger.addFilter(spares)
            undo.callback(logger.removeFilter, spares)
        yield
