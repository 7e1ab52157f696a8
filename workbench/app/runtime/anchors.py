"""Anchors: the head of a journal, written elsewhere at every approval, to detect a rewriting.

An anchor is the number of an entry with its hash, which covers all entries up to it.  A place is a
file, better on another disk, that gets a line of JSON, or an address that receives each by POST.
"""

import json
import logging
import os
import stat
import threading
import urllib.request
from collections.abc import Callable, Mapping
from http.client import HTTPException
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.state import State
from workbench.app.runtime.bench import Bench
from workbench.model.errors import InputError, JournalError

log = logging.getLogger(__name__)

ANCHORED = frozenset({Approve.__name__})

ANSWER_WITHIN = 5.0
"""[s] For an answer of an address."""

Anchor = Mapping[str, Any]
Put = Callable[[Anchor], None]
"""Keeps an anchor elsewhere; OSError when that cannot be done now."""


def place(typed: str) -> Put:
    """Where anchors go: an address that begins with http, or a file.

    Raises:
        InputError: it can be neither.
    """
    if typed.casefold().startswith(("http://", "https://")):
        try:
            parts = urlsplit(typed)
            # Asking for the port looks whether it is a number.
            names_host = parts.port != 0 and bool(parts.hostname)
        except ValueError as error:
            raise InputError(f"--anchor {typed}: {error}") from error
        if not names_host:
            raise InputError(f"--anchor {typed}: names no host")
        return lambda anchor: _post(typed, anchor)
    path = Path(typed)
    try:
        # Found out now, and not at the first approval.
        _append(path, b"")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or "is not the name of a file"
        raise InputError(f"--anchor {typed[:200]}: {why}") from error
    return lambda anchor: _append(path, json.dumps(anchor).encode() + b"\n")


class Anchors:
    """Writes an anchor of each recorded approval to every place, in order.

    An anchor that a place refuses is written again at the next change of the state, and at the end.

    Lifetime: from construction until `close`; ends before the bench.

    Concurrency: writes in the observer's thread of the bench, so nobody waits for a place.
    """

    def __init__(self, bench: Bench, places: Mapping[str, Put], now: Callable[[], float]):
        """Begin with what is approved from now on.

        Args:
            bench: whose journal.
            places: by what was typed.
            now: seconds since the epoch.
        """
        self._bench = bench
        self._now = now
        self._places = places
        self._session = bench.folder.name
        self._last = bench.state.number
        self._owed: dict[str, list[Anchor]] = {name: [] for name in places}
        self._failing: set[str] = set()
        self._lock = threading.Lock()
        self._end = bench.subscribe(self._pass_on_anchored)

    def close(self) -> None:
        """Tell what is owed, once more, and no more after that."""
        self._end()
        self._pass_on_anchored(self._bench.state, self._bench.state)

    def _pass_on_anchored(self, old: State, new: State) -> None:
        with self._lock:
            try:
                for row in self._bench.entries(self._last):
                    self._last = row.number
                    if row.kind in ANCHORED:
                        anchor = {"session": self._session, "number": row.number, "hash": row.hash}
                        for owed in self._owed.values():
                            owed.append({**anchor, "at": self._now(), "what": row.kind})
            except JournalError as error:
                log.error("anchors are not told: %s", error)
            for name, put in self._places.items():
                self._pay(name, put)

    def _pay(self, name: str, put: Put) -> None:
        owed = self._owed[name]
        while owed:
            try:
                put(owed[0])
            except OSError as error:
                if name not in self._failing:
                    log.error("anchors cannot be kept at %s: %s", name, error)
                self._failing.add(name)
                return
            self._failing.discard(name)
            owed.pop(0)


def _append(path: Path, line: bytes) -> None:
    number = os.open(path, os.O_WRONLY | os.O_APPEND | os.O_CREAT | os.O_CLOEXEC, 0o644)
    try:
        if line and _is_torn(path, os.fstat(number)):
            line = b"\n" + line
        if os.write(number, line) < len(line):
            raise OSError("only a part of the line could be written")
        os.fsync(number)
    finally:
        os.close(number)


def _is_torn(path: Path, about: os.stat_result) -> bool:
    """Whether the last line has no end: disk or power were gone while it was written."""
    if not stat.S_ISREG(about.st_mode) or not about.st_size:
        return False
    try:
        with path.open("rb") as file:
            file.seek(-1, os.SEEK_END)
            return file.read(1) != b"\n"
    except OSError:
        # A file that may only be written to: an empty line too many does no harm.
        return True


def _post(address: str, anchor: Anchor) -> None:
    """Post an anchor; every answer but a good one is an OSError, as is none."""
    body, about = json.dumps(anchor).encode(), {"Content-Type": "application/json"}
    request = urllib.request.Request(address, body, about, method="POST")
    try:
        with urllib.request.urlopen(request, timeout=ANSWER_WITHIN):
            pass
    except (ValueError, HTTPException) as error:
        raise OSError(f"{type(error).__name__}: {error}") from error
