"""Where sessions lie: one folder each, `<time>-<cell>`, holding a journal and its files."""

import json
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from workbench.app.records.forms import restore_value
from workbench.app.records.record import SESSION, session_record
from workbench.formats.files.whole_files import plain_name
from workbench.journal.journal import Journal
from workbench.model.cell import Cell
from workbench.model.errors import JournalError, WorkbenchError

MOST_PROBLEMS = 10
"""What is kept of what is wrong with the session before."""


def new_session(root: Path, cell: Cell, at: float, after: Journal | None = None) -> Journal:
    """A journal in a new folder under `root`, its first entry telling of the cell.

    Args:
        root: where the sessions are; made when missing.
        cell: that the session runs with.
        at: seconds since the epoch; names the folder, in UTC.
        after: another session, whole or not, that this one names as the one before it.

    Raises:
        JournalError: the folder cannot be made or written.
    """
    time = datetime.fromtimestamp(at, UTC).strftime("%Y%m%d-%H%M%S")
    name = plain_name(f"{time}-{cell.name}")
    journal = Journal(_new_folder(root, name))
    begin(journal, cell, at, after)
    return journal


def begin(journal: Journal, cell: Cell, at: float, after: Journal | None = None) -> None:
    """Write the first entry of a session, which names the one `after` which it comes.

    Raises:
        JournalError: it cannot be written.
    """
    named = None if after is None else _describe(after)
    record = session_record(cell, at, named)
    journal.append(record.kind, record.body, record.files)


def _describe(journal: Journal) -> dict[str, Any]:
    said = {"session": journal.folder.name, "entries": journal.count, "head": journal.head}
    return {**said, "problems": journal.verify()[:MOST_PROBLEMS]}


def cell_of(journal: Journal) -> Cell:
    """The cell that a session began with, as its first entry has kept it.

    Raises:
        JournalError: the session is empty, or its beginning cannot be read.
    """
    first = next(journal.entries(), None)
    if first is None:
        raise JournalError(f"{journal.folder}: the session is empty")
    try:
        content: Any = json.loads(first.body) if first.kind == SESSION else None
        return restore_value(Cell, content["value"], journal.read)
    except (KeyError, TypeError, ValueError, WorkbenchError) as error:
        raise JournalError(f"{journal.folder}: its beginning cannot be read: {error}") from error


def _new_folder(root: Path, name: str) -> Path:
    folder, attempt = root / name, 1
    while True:
        try:
            folder.mkdir(parents=True)
            return folder
        except FileExistsError:
            attempt += 1
            folder = root / f"{name}-{attempt}"
        except OSError as error:
            raise JournalError(f"{folder}: cannot be made: {error.strerror}") from error
