"""The tables of a journal, and the way from any older version to the newest."""

import sqlite3
from contextlib import closing
from pathlib import Path

from workbench.model.errors import JournalError

MIGRATIONS: tuple[str, ...] = (
    # AUTOINCREMENT keeps the highest number ever given, so that a missing last row shows.
    """
    CREATE TABLE entries (
        number INTEGER PRIMARY KEY AUTOINCREMENT,
        kind TEXT NOT NULL,
        body BLOB NOT NULL,
        previous TEXT NOT NULL,
        hash TEXT NOT NULL UNIQUE
    ) STRICT;
    CREATE TABLE files (
        digest TEXT PRIMARY KEY,
        size INTEGER NOT NULL
    ) STRICT;
    CREATE TABLE entry_files (
        entry INTEGER NOT NULL REFERENCES entries (number),
        digest TEXT NOT NULL REFERENCES files (digest),
        PRIMARY KEY (entry, digest)
    ) STRICT, WITHOUT ROWID;
    CREATE TRIGGER entries_stay BEFORE UPDATE ON entries
        BEGIN SELECT RAISE(ABORT, 'a journal is only ever appended to'); END;
    CREATE TRIGGER entries_remain BEFORE DELETE ON entries
        BEGIN SELECT RAISE(ABORT, 'a journal is only ever appended to'); END;
    """,
)
"""Script number n leads from `user_version` n to n + 1; scripts are added, never edited."""


def is_foreign(path: Path) -> bool:
    """Whether a database has other tables, triggers or views than a journal of any version.

    One from outside may hold triggers that act when it is opened for writing.

    Raises:
        JournalError: it is no database.
    """
    known: set[tuple[str, str]] = set()
    with closing(sqlite3.connect(":memory:")) as ours:
        migrate(ours)
        known.update(ours.execute("SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL"))
    try:
        with closing(sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)) as theirs:
            found = set(theirs.execute("SELECT name, sql FROM sqlite_master WHERE sql IS NOT NULL"))
    except sqlite3.Error as error:
        raise JournalError(f"{path}: is no journal: {error}") from error
    return not found <= known


def migrate(connection: sqlite3.Connection) -> None:
    """Bring the tables to the newest version, each step wholly or not at all.

    Raises:
        JournalError: the journal was written by a newer workbench.
    """
    (version,) = connection.execute("PRAGMA user_version").fetchone()
    if version > len(MIGRATIONS):
        raise JournalError(
            f"the journal has version {version}, this workbench knows up to "
            f"{len(MIGRATIONS)}: open it with the newer workbench that wrote it"
        )
    for target, script in enumerate(MIGRATIONS[version:], start=version + 1):
        connection.executescript(
            f"BEGIN IMMEDIATE; {script} PRAGMA user_version = {target}; COMMIT;"
        )
