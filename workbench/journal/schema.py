"""The tables of a journal, and the way from any older version to the newest."""

import sqlite3

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
