"""The journal of one session: numbered entries in SQLite, chained by hashes, and their files.

Each entry's hash covers its content and the previous hash, so a change invalidates all later
hashes.  A program that can write the folder can also compute a whole new chain; to exclude that,
store `head` elsewhere.
"""

import hashlib
import os
import shutil
import sqlite3
import tempfile
import threading
from collections.abc import Iterator, Mapping
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from types import MappingProxyType

from workbench.journal.files import Content, read_file, write_file
from workbench.journal.schema import migrate
from workbench.journal.writer import Writer
from workbench.model.errors import JournalError

FIRST_HASH = "0" * 64
"""The previous hash of the first entry."""

DATABASE = "journal.sqlite"

NO_FILES: Mapping[str, Content] = MappingProxyType({})


@dataclass(frozen=True, slots=True)
class Row:
    """One entry as written; `files` are the sorted digests of its files."""

    number: int
    kind: str
    body: bytes
    files: tuple[str, ...]
    previous: str
    hash: str


class Journal:
    """An append-only journal in a folder: `journal.sqlite` and `files/`.

    Lifetime: open from construction until `close`; a folder may be opened again, and the numbers
    continue.  If the process dies, an entry with its files is complete or absent.

    Concurrency: any thread may call any method.  Appends wait for each other; readers have their
    own connection and never wait for a writer.  Only the program that has claimed a folder writes
    to it; without a claim, a second program is refused at its first append after the other's.
    """

    def __init__(self, folder: Path, *, patience: float = 1.0):
        """Open the journal in `folder`, or make a new one.

        Args:
            folder: made when missing.
            patience: longest wait [s] of an append for another program's lock.

        Raises:
            JournalError: the folder cannot be used, or a newer workbench wrote it.
        """
        self.folder = folder
        self._lock = threading.Lock()
        self._writer: Writer | None = None
        self._copy: tempfile.TemporaryDirectory[str] | None = None
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._path = self._path_to_open()
            self._connection = sqlite3.connect(
                self._path, timeout=patience, isolation_level=None, check_same_thread=False
            )
        except (OSError, sqlite3.Error, ValueError) as error:
            if self._copy is not None:
                self._copy.cleanup()
            raise JournalError(f"{folder}: cannot hold a journal: {error}") from error
        try:
            self._connection.execute("PRAGMA journal_mode = WAL")
            self._connection.execute("PRAGMA synchronous = FULL")
            self._connection.execute("PRAGMA foreign_keys = ON")
            migrate(self._connection)
            self._count, self._head = _last(self._connection)
        except (JournalError, sqlite3.Error) as error:
            self.close()
            raise JournalError(f"{folder / DATABASE}: {error}") from error

    @property
    def count(self) -> int:
        """The number of entries, which is also the number of the last entry."""
        return self._count

    @property
    def head(self) -> str:
        """The hash of the last entry, which covers the whole journal."""
        return self._head

    def keep(self, files: Mapping[str, Content]) -> None:
        """Write the files of an entry before its append, so that the append is quick.

        Without that append no entry names the files.

        Args:
            files: SHA-256 -> content.

        Raises:
            JournalError: one of them cannot be written.
        """
        if self._copy is None:
            for digest, content in files.items():
                write_file(self.folder / "files", digest, content)

    def append(self, kind: str, body: bytes, files: Mapping[str, Content] = NO_FILES) -> int:
        """Write one entry; it is on the disk when this returns.

        Args:
            kind: kind of the entry.
            body: content of the entry.
            files: SHA-256 -> content, for content that is too large for a row.

        Returns:
            The entry's number, counted from 1.

        Raises:
            JournalError: nothing was appended.
        """
        with self._lock:
            if self._copy is not None:
                raise JournalError(f"{self.folder}: nothing can be written there")
            for digest, content in files.items():
                write_file(self.folder / "files", digest, content)
            number = self._count + 1
            digests = tuple(sorted(files))
            entry_hash = hash_of(self._head, number, kind, body, digests)
            row = Row(number, kind, body, digests, self._head, entry_hash)
            try:
                self._insert(row, files)
            except sqlite3.IntegrityError as error:
                raise JournalError(
                    f"{self._path}: another process writes to this session"
                ) from error
            except sqlite3.Error as error:
                raise JournalError(f"{self._path}: cannot be written: {error}") from error
            self._count, self._head = row.number, row.hash
            return row.number

    def claim(self, at: float) -> None:
        """Become the only program that writes to this folder, until `close`; may be repeated.

        Args:
            at: seconds since the epoch.

        Raises:
            JournalError: another program has claimed it, or the folder cannot be written.
        """
        with self._lock:
            if self._writer is None:
                self._writer = Writer(self.folder, at)
                try:
                    # The program before may have written until now.
                    self._count, self._head = _last(self._connection)
                except sqlite3.Error as error:
                    raise JournalError(f"{self._path}: cannot be read: {error}") from error

    def entries(self, after: int = 0) -> Iterator[Row]:
        """The entries with a higher number than `after`, in order.

        Raises:
            JournalError: the journal cannot be read.
        """
        yield from self._rows("WHERE number > ? ORDER BY number", after)

    def last(self, kind: str = "") -> Row | None:
        """The last entry, or the last one of a kind; None when there is none.

        Raises:
            JournalError: the journal cannot be read.
        """
        return next(
            self._rows("WHERE kind = ? OR ? = '' ORDER BY number DESC LIMIT 1", kind, kind), None
        )

    def read(self, digest: str) -> bytes:
        """The content of a file of this journal, checked against its digest.

        Raises:
            JournalError: the file is missing or was changed.
        """
        return read_file(self.folder / "files", digest)

    def verify(self) -> tuple[str, ...]:
        """Sentences about each sign of a change from outside; empty when there is none.

        Raises:
            JournalError: the journal cannot be read at all.
        """
        problems: list[str] = []
        expected_number, previous = 1, FIRST_HASH
        checked: set[str] = set()
        for row in self.entries():
            if row.number != expected_number:
                problems.append(f"entry {expected_number} is missing before entry {row.number}")
            if row.previous != previous:
                problems.append(f"entry {row.number} does not follow from the one before it")
            if hash_of(row.previous, row.number, row.kind, row.body, row.files) != row.hash:
                problems.append(f"entry {row.number} was changed after it was written")
            for digest in row.files:
                if digest not in checked:
                    checked.add(digest)
                    problems.extend(self._file_problem(row.number, digest))
            expected_number, previous = row.number + 1, row.hash
        if expected_number == 1:
            problems.append("there is no entry, not even the first one, which tells of the cell")
        highest = self._highest_number()
        if highest >= expected_number:
            problems.append(f"the entries {expected_number} to {highest} are missing at the end")
        return tuple(problems)

    def save_copy(self, path: Path) -> None:
        """Write a copy of the database into a new file, also while another program writes to it.

        Raises:
            JournalError: it cannot be read or written.
        """
        try:
            with closing(self._reader()) as source, closing(sqlite3.connect(path)) as target:
                source.backup(target)
                # A single file without a write-ahead log.
                target.execute("PRAGMA journal_mode = DELETE")
        except sqlite3.Error as error:
            raise JournalError(f"{path}: cannot be written: {error}") from error

    def close(self) -> None:
        """Close the journal; a second call does nothing."""
        with self._lock:
            self._connection.close()
            if self._copy is not None:
                self._copy.cleanup()
            if self._writer is not None:
                self._writer.close()
                self._writer = None

    def _path_to_open(self) -> Path:
        """The database, or a copy of it: SQLite reads only in a folder that it can write."""
        path = self.folder / DATABASE
        if not path.exists() or os.access(self.folder, os.W_OK):
            return path
        self._copy = tempfile.TemporaryDirectory(prefix="workbench-journal-")
        for kept in (path, path.with_name(f"{DATABASE}-wal")):
            if kept.exists():
                shutil.copyfile(kept, Path(self._copy.name) / kept.name)
        return Path(self._copy.name) / DATABASE

    def _reader(self) -> sqlite3.Connection:
        return sqlite3.connect(f"{self._path.absolute().as_uri()}?mode=ro", uri=True)

    def _rows(self, which: str, *values: int | str) -> Iterator[Row]:
        """The entries selected by the end of a query and its values."""
        try:
            # The connection's own `with` ends a transaction and leaves the connection open.
            with closing(self._reader()) as reader:
                rows = reader.execute(
                    f"SELECT number, kind, body, previous, hash FROM entries {which}", values
                )
                for number, kind, body, previous, entry_hash in rows:
                    yield Row(number, kind, body, _files_of(reader, number), previous, entry_hash)
        except sqlite3.Error as error:
            raise JournalError(f"{self._path}: cannot be read: {error}") from error

    def _insert(self, row: Row, files: Mapping[str, Content]) -> None:
        execute = self._connection.execute
        execute("BEGIN IMMEDIATE")
        try:
            execute(
                "INSERT INTO entries (number, kind, body, previous, hash) VALUES (?, ?, ?, ?, ?)",
                (row.number, row.kind, row.body, row.previous, row.hash),
            )
            for digest in row.files:
                execute(
                    "INSERT OR IGNORE INTO files (digest, size) VALUES (?, ?)",
                    (digest, len(files[digest])),
                )
                execute(
                    "INSERT INTO entry_files (entry, digest) VALUES (?, ?)", (row.number, digest)
                )
            execute("COMMIT")
        except BaseException:
            if self._connection.in_transaction:
                execute("ROLLBACK")
            raise

    def _file_problem(self, number: int, digest: str) -> tuple[str, ...]:
        try:
            self.read(digest)
        except JournalError as error:
            return (f"entry {number}: {error}",)
        return ()

    def _highest_number(self) -> int:
        try:
            with closing(self._reader()) as reader:
                found = reader.execute("SELECT seq FROM sqlite_sequence WHERE name = 'entries'")
                return next((seq for (seq,) in found), 0)
        except sqlite3.Error as error:
            raise JournalError(f"{self._path}: cannot be read: {error}") from error


def hash_of(previous: str, number: int, kind: str, body: bytes, files: tuple[str, ...]) -> str:
    """The chained hash of an entry; the length of each field is hashed, too, so none can shift."""
    chain = hashlib.sha256()
    texts = (previous, str(number), kind, *files)
    for field in (body, *map(str.encode, texts)):
        chain.update(len(field).to_bytes(8, "big"))
        chain.update(field)
    return chain.hexdigest()


def _last(connection: sqlite3.Connection) -> tuple[int, str]:
    row = connection.execute(
        "SELECT number, hash FROM entries ORDER BY number DESC LIMIT 1"
    ).fetchone()
    return row if row is not None else (0, FIRST_HASH)


def _files_of(connection: sqlite3.Connection, number: int) -> tuple[str, ...]:
    rows = connection.execute(
        "SELECT digest FROM entry_files WHERE entry = ? ORDER BY digest", (number,)
    )
    return tuple(digest for (digest,) in rows)
