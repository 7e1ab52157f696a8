"""The file that outlives a start: users, tokens, who is logged in, and failed logins.

Secrets are not in it: passwords as Argon2id hashes, session ids and tokens, which are random, as
their SHA-256.  Whoever can write the file can make himself a user, so it belongs to its owner.
"""

import os
import sqlite3
import threading
from collections.abc import Generator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from workbench.model.errors import FileError

OWNER_ONLY = 0o600

APPLICATION = 0x57426672
"""Identifies our file among SQLite files (`PRAGMA application_id`)."""

LONGEST_WAIT = 5.0
"""How long [s] a change waits for another program's."""

MIGRATIONS: tuple[str, ...] = (
    """
    CREATE TABLE users (
        key TEXT PRIMARY KEY,
        name TEXT NOT NULL,
        role TEXT NOT NULL,
        hash TEXT NOT NULL,
        is_disabled INTEGER NOT NULL DEFAULT 0
    ) STRICT;
    CREATE TABLE tokens (
        digest TEXT PRIMARY KEY,
        user TEXT NOT NULL REFERENCES users (key) ON DELETE CASCADE,
        name TEXT NOT NULL,
        made_at REAL NOT NULL,
        UNIQUE (user, name)
    ) STRICT;
    -- Without a user: the one browser that came by the first link.
    CREATE TABLE sessions (
        digest TEXT PRIMARY KEY,
        user TEXT REFERENCES users (key) ON DELETE CASCADE,
        expires_at REAL NOT NULL
    ) STRICT;
    CREATE TABLE failures (
        id INTEGER PRIMARY KEY,
        subject TEXT NOT NULL,
        at REAL NOT NULL
    ) STRICT;
    CREATE INDEX failures_by_subject ON failures (subject, at);
    """,
    """
    -- Browsers in which somebody has logged in before: others' failed logins do not shut them out.
    CREATE TABLE browsers (
        digest TEXT PRIMARY KEY,
        user TEXT NOT NULL REFERENCES users (key) ON DELETE CASCADE,
        expires_at REAL NOT NULL
    ) STRICT
    """,
    """
    -- One browser may be that of several people, as that of a panel is.
    CREATE TABLE shared_browsers (
        digest TEXT NOT NULL,
        user TEXT NOT NULL REFERENCES users (key) ON DELETE CASCADE,
        expires_at REAL NOT NULL,
        PRIMARY KEY (digest, user)
    ) STRICT;
    INSERT INTO shared_browsers SELECT digest, user, expires_at FROM browsers;
    DROP TABLE browsers;
    ALTER TABLE shared_browsers RENAME TO browsers
    """,
    """
    -- In which the page is wanted, empty where nothing was chosen.
    ALTER TABLE users ADD COLUMN language TEXT NOT NULL DEFAULT ''
    """,
)
"""Script number n leads from `user_version` n to n + 1; scripts are added, never edited."""


class Store:
    """The open file.

    Lifetime: from construction until `close`.  When the process dies at any moment, a change is
    there wholly or not at all.

    Concurrency: any thread may call anything; several processes may have the file open, as
    `workbench user` beside `workbench serve`.
    """

    def __init__(self, path: Path):
        """Open the file, making it when there is none.

        Raises:
            FileError: it cannot be read or written, is something else, or a newer workbench's.
        """
        self.path = path
        self._lock = threading.Lock()
        # Whoever asks waits for no change, which may itself wait for another program's.
        self._asking = threading.Lock()
        try:
            _make_private(path)
            self._connection = sqlite3.connect(
                path, timeout=LONGEST_WAIT, isolation_level=None, check_same_thread=False
            )
        except (OSError, sqlite3.Error) as error:
            raise FileError(path, f"cannot hold users: {error}") from error
        try:
            self._connection.execute("PRAGMA journal_mode = WAL")
            self._connection.execute("PRAGMA foreign_keys = ON")
            self._connection.execute("PRAGMA secure_delete = ON")
            _migrate(self._connection, path)
            self._reader = sqlite3.connect(path, isolation_level=None, check_same_thread=False)
        except sqlite3.Error as error:
            self._connection.close()
            raise FileError(path, f"is no file of users: {error}") from error
        except FileError:
            self._connection.close()
            raise

    def ask(self, question: str, *values: object) -> list[tuple[Any, ...]]:
        """The rows that answer a question.

        Raises:
            FileError: the file cannot be read.
        """
        with self._asking:
            try:
                return self._reader.execute(question, values).fetchall()
            except sqlite3.Error as error:
                raise FileError(self.path, f"cannot be read: {error}") from error

    @contextmanager
    def change(self) -> Generator[sqlite3.Connection]:
        """A block whose changes all happen, or none when it raises.

        Raises:
            FileError: the file cannot be written.
        """
        with self._lock:
            try:
                self._connection.execute("BEGIN IMMEDIATE")
            except sqlite3.Error as error:
                raise FileError(self.path, f"cannot be written: {error}") from error
            try:
                yield self._connection
                self._connection.execute("COMMIT")
            except sqlite3.Error as error:
                raise FileError(self.path, f"cannot be written: {error}") from error
            finally:
                # After some errors, such as a full disk, SQLite has rolled back already.
                if self._connection.in_transaction:
                    self._connection.execute("ROLLBACK")

    def close(self) -> None:
        """Close the file; twice does no harm."""
        with self._lock, self._asking:
            self._reader.close()
            self._connection.close()


def _make_private(path: Path) -> None:
    """Have the file there, for its owner alone; SQLite gives the files beside it the same mode.

    A file that is there is not opened: closing it would release the locks of this process's other
    connections, and another process would then delete their write-ahead log.
    """
    path.parent.mkdir(parents=True, exist_ok=True)
    with suppress(FileExistsError):
        os.close(os.open(path, os.O_RDWR | os.O_CREAT | os.O_EXCL | os.O_CLOEXEC, OWNER_ONLY))
    if path.stat().st_mode & 0o077:
        path.chmod(OWNER_ONLY)


def _migrate(connection: sqlite3.Connection, path: Path) -> None:
    """Bring the tables to the newest version, each step wholly or not at all."""
    connection.execute("BEGIN IMMEDIATE")
    try:
        (application,) = connection.execute("PRAGMA application_id").fetchone()
        (version,) = connection.execute("PRAGMA user_version").fetchone()
        (tables,) = connection.execute("SELECT count(*) FROM sqlite_master").fetchone()
        if tables and application != APPLICATION:
            raise FileError(path, "is a database of another program, not one of users")
        if version > len(MIGRATIONS):
            raise FileError(
                path,
                f"has version {version}, this workbench knows up to {len(MIGRATIONS)}: "
                "use the newer workbench that wrote it",
            )
        for target, script in enumerate(MIGRATIONS[version:], start=version + 1):
            for statement in script.split(";"):
                connection.execute(statement)
            connection.execute(f"PRAGMA user_version = {target}")
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute("COMMIT")
    except BaseException:
        connection.execute("ROLLBACK")
        raise
