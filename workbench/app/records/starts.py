"""Starts of the workbench: what ran then, and what is otherwise now."""

import json
from collections.abc import Iterator
from contextlib import closing, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.app.core.session import Started
from workbench.app.provenance.inventory import Inventory, differences
from workbench.app.records.forms import restore_value
from workbench.journal.journal import DATABASE, Journal
from workbench.model.errors import JournalError, WorkbenchError

MOST_LOOKED_AT = 50
"""Sessions of before with a start that counts; all others are passed over."""


@dataclass(frozen=True, slots=True)
class Before:
    """The start before: in which session, what ran, and what nobody has acknowledged since."""

    session: str
    ran: Inventory
    changed: tuple[str, ...]


def start(ran: Inventory, before: Before | None) -> Started:
    """The start record of an inventory, with its differences to the start before."""
    if before is None:
        return Started(ran)
    changes = tuple(dict.fromkeys((*before.changed, *differences(before.ran, ran))))
    return Started(ran, changes, f"session {before.session}" if changes else "")


def start_before(root: Path, cell: str) -> Before | None:
    """The last start with a cell of that name, of all sessions below `root`; None without one.

    Trials do not count.  Unreadable sessions are skipped; opening them reports the error.
    """
    found: list[tuple[float, Before]] = []
    for folder in _newest(root):
        try:
            with closing(Journal(folder)) as journal:
                found += _starts_in(journal, cell)
        except JournalError:
            continue
        if len(found) == MOST_LOOKED_AT:
            break
    # Files do not tell when a start was: one that is gone on with, packed or copied is written.
    return max(found, key=lambda known_start: known_start[0], default=(0.0, None))[1]


def _newest(root: Path) -> Iterator[Path]:
    newest = sorted(root.glob(f"*/{DATABASE}"), key=_time_of_write, reverse=True)
    return (path.parent for path in newest)


def _time_of_write(path: Path) -> float:
    """When a journal was written last: until it is closed, that is in a file beside it."""
    times = [0.0]
    for file in (path, path.with_name(f"{DATABASE}-wal")):
        with suppress(OSError):
            times.append(file.stat().st_mtime)
    return max(times)


def _starts_in(journal: Journal, cell: str) -> Iterator[tuple[float, Before]]:
    """When the last start with that cell was, and what is known of it; nothing without one."""
    row, last = journal.last(Started.__name__), journal.last()
    if row is None or last is None:
        return
    try:
        entry: Any = json.loads(row.body)
        command = entry["command"]
        if command["is_trial"] or command["ran"]["cell"] != cell:
            return
        after: Any = json.loads(last.body)["after"]
        ran = restore_value(Inventory, command["ran"], journal.read)
        changed = tuple(after.get("changed") or ())
        yield float(entry["at"]), Before(journal.folder.name, ran, changed)
    except (AttributeError, KeyError, TypeError, ValueError, WorkbenchError) as error:
        raise JournalError(f"entry {row.number} ({row.kind}) cannot be read") from error
