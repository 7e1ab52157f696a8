"""A backup put back: all of it is read first, and then it is there wholly or not at all.

A process of its own looks into a backup, or restores it, for whoever must not do so: reading what
comes from outside may end a process, and cells name parts below the working directory.
"""

import contextlib
import filecmp
import json
import logging
import threading
import time
from collections.abc import Callable, Generator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Literal

from workbench.app.records.keeping import (
    BACKED_UP_FOLDERS,
    FORMAT,
    MANIFEST,
    WITHOUT_SESSIONS,
    files_of,
    things_in,
    write_backup,
)
from workbench.app.records.session_archive import check_journal
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.archives import unpacked_beside
from workbench.formats.files.change_log import LOG, add_line, utc
from workbench.formats.files.reader_process import Answer, apart, finish
from workbench.formats.files.whole_files import make_folder, read_whole
from workbench.formats.parts.reading import read_part
from workbench.model.errors import CommandRefused, FileError, InputError
from workbench.model.messages.files import FileProblem, FileText
from workbench.plugins.progress import Cancelled, never

log = logging.getLogger(__name__)

BACKUPS = Path("backups")
"""Below the working directory: what was there before something was restored, and a log."""

_RESTORING = threading.Lock()
"""Held during a restore: only one runs at a time."""

KEPT_USERS = "users.json"
"""The users in a backup, if it has them."""

LARGEST_MANIFEST = 10 * 2**20
"""[bytes] Of the manifest, and of the users."""

LONGEST_READING = 300.0
"""[s] Of processor time that a process of its own may take for a backup."""

Fate = Literal["new", "replaced", "the same", "left as it is"]


@dataclass(frozen=True, slots=True)
class Thing:
    """One cell, part or session in a backup, and what restoring does about it."""

    kind: str
    name: str
    fate: Fate


@dataclass(frozen=True, slots=True)
class Unpacked:
    """A backup that was read as a whole and may be put back: where it lies, and what is in it."""

    place: Path
    things: tuple[Thing, ...]

    @property
    def users(self) -> Path | None:
        """The file of its users, which are no matter of the things; None when it has none."""
        kept = self.place / KEPT_USERS
        return kept if kept.is_file() else None


@contextlib.contextmanager
def unpack_backup(file: Path, root: Path) -> Generator[Unpacked]:
    """Unpack a backup on the disk of a working directory, and read everything in it.

    It works in that directory meanwhile, so it is for processes with one thread.

    Raises:
        FileError: it is no backup, or something in it cannot be used.
        JournalError: a session was changed.
    """
    with unpacked_beside(file, root) as place:
        _check(file, place)
        things = [
            Thing(kind, thing.name, _fate(root / kind / thing.name, thing))
            for kind in BACKED_UP_FOLDERS
            for thing in things_in(place / kind)
        ]
        yield Unpacked(place, tuple(things))


def _check(path: Path, place: Path) -> None:
    try:
        stated = json.loads(read_whole(place / MANIFEST, LARGEST_MANIFEST))["format"]
    except (FileError, KeyError, TypeError, ValueError):
        raise FileError(path, FileProblem.NO_BACKUP()) from None
    if stated != FORMAT:
        detail = f"format {stated!r}, expected {FORMAT!r}"
        raise FileError(path, FileProblem.OTHER_BACKUP(detail=detail))
    strange = {member.name for member in place.iterdir()} - {
        MANIFEST,
        KEPT_USERS,
        *BACKED_UP_FOLDERS,
    }
    if strange:
        detail = f"it holds {sorted(strange)[0]!r}, which no backup does"
        raise FileError(path, FileProblem.OTHER_BACKUP(detail=detail))
    # Cells name parts, which are looked for below the working directory.
    with contextlib.chdir(place):
        for part in sorted(Path("parts").glob("*/part.toml")):
            read_part(part.parent)
        for cell in sorted(Path("robots").glob("*/cell.toml")):
            read_cell(str(cell))
    for session in things_in(place / "sessions"):
        check_journal(path, session)


def _fate(there: Path, thing: Path) -> Fate:
    if not there.exists():
        return "new"
    # A session is only ever appended to: an older copy never replaces one that is there.
    if there.parent.name == "sessions":
        return "left as it is"
    return "the same" if _is_same(there, thing) else "replaced"


def _is_same(path: Path, other: Path) -> bool:
    """Whether two files, or all files in two folders, have the same names and contents."""
    names = [file.relative_to(path) for file in files_of(path)]
    return names == [file.relative_to(other) for file in files_of(other)] and all(
        filecmp.cmp(path / name, other / name, shallow=False) for name in names
    )


def put_in_place(root: Path, backup: Unpacked) -> None:
    """Move new things in and old ones out.

    When that fails or is interrupted midway, all is as it was.

    Raises:
        FileError: something cannot be moved.
    """
    moved: list[tuple[Path, Path]] = []
    place, out = backup.place, backup.place / ".replaced"
    try:
        for thing in backup.things:
            if thing.fate not in ("new", "replaced"):
                continue
            target = root / thing.kind / thing.name
            target.parent.mkdir(parents=True, exist_ok=True)
            if target.exists():
                old = out / thing.kind / thing.name
                old.parent.mkdir(parents=True, exist_ok=True)
                moved.append((old, target))
                target.rename(old)
            new = place / thing.kind / thing.name
            moved.append((target, new))
            new.rename(target)
    except BaseException as error:
        # What was replaced would be gone with the unpacked files, also after Ctrl-C.
        for now, before in reversed(moved):
            if now.exists():
                now.rename(before)
        if isinstance(error, OSError):
            problem = FileProblem.NOT_RESTORED(reason=str(error.strerror))
            raise FileError(error.filename or root, problem) from None
        raise


def look_apart(file: Path, root: Path, *, cancelled: Cancelled = never) -> tuple[Thing, ...]:
    """What restoring a backup would change in a working directory, found by a separate process.

    Args:
        file: the backup.
        root: the working directory.
        cancelled: True ends the process.

    Raises:
        InputError: it cannot be restored.
        JobCancelled: it was cancelled.
    """
    return _apart(file, root, is_put=False, cancelled=cancelled)


def restore_apart(file: Path, root: Path) -> tuple[Thing, ...]:
    """Restore a backup below a working directory, by a process of its own; what that has done.

    Raises:
        InputError: nothing was restored, and why.
    """
    return _apart(file, root, is_put=True, cancelled=never)


def _apart(file: Path, root: Path, *, is_put: bool, cancelled: Cancelled) -> tuple[Thing, ...]:
    try:
        answer = apart(
            file,
            _inspect_or_restore,
            str(root.resolve()),
            is_put,
            longest=LONGEST_READING,
            cancelled=cancelled,
        )
    except FileError as error:
        # Where the file lies for now says nothing to anybody.
        raise InputError(FileText.PROBLEM(path=file.name, problem=error.problem)) from None
    return tuple(Thing(**fields) for fields in answer.value)


def _inspect_or_restore(file: Path, root: str, is_put: bool) -> Answer:
    """What the process of its own does.

    Raises:
        InputError: as `look_apart` has it.
    """
    try:
        with unpack_backup(file, Path(root)) as backup:
            if backup.users is not None:
                raise InputError(FileProblem.HOLDS_USERS())
            if is_put:
                finish()
                put_in_place(Path(root), backup)
            return Answer([asdict(thing) for thing in backup.things])
    except FileError as error:
        name = file.name if error.path == str(file) else error.path
        raise InputError(FileText.PROBLEM(path=name, problem=error.problem)) from None


def restore_and_log(
    opened: Callable[[], contextlib.AbstractContextManager[Path]],
    name: str,
    by: str,
    check: Callable[[], None],
) -> Path:
    """Restore a backup into the working directory; what it replaces is kept as a backup first.

    Args:
        opened: has the backup as a file for a while.
        name: of the backup, for the log.
        by: the name of the person who restores it.
        check: raises what speaks against it now; called again before anything is replaced.

    Returns:
        The backup of what was there before.

    Raises:
        CommandRefused: somebody else restores a backup now, or `check` refuses.
        FileError: something cannot be read or written.
        InputError: the backup cannot be used.
    """
    if not _RESTORING.acquire(blocking=False):
        raise CommandRefused(FileProblem.RESTORES_NOW())
    try:
        check()
        make_folder(BACKUPS)
        at = time.time()
        before = BACKUPS / f"before-{utc(at).replace(':', '')}.zip"
        write_backup(Path.cwd(), before, WITHOUT_SESSIONS, {})
        check()  # that may have taken a while
        with opened() as file:
            things = restore_apart(file, Path.cwd())
        changed = [
            f"{thing.kind}/{thing.name}" for thing in things if thing.fate in ("new", "replaced")
        ]
        said = {"by": by, "restored": name, "before": before.name}
        add_line(BACKUPS / LOG, {"at": utc(at), **said, "changed": changed})
    finally:
        _RESTORING.release()
    log.warning("%s has restored %s: %s", by, name, ", ".join(changed))
    return before
