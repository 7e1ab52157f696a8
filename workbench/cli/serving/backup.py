"""`workbench backup` and `workbench restore`: cells, parts, sessions and users as one file."""

import contextlib
import filecmp
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from workbench.app.records.keeping import FORMAT, KINDS, MANIFEST, files_of, things_in, write_backup
from workbench.app.records.session_archive import check_journal
from workbench.cli.arguments import top as arguments
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import print_table
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.archives import unpacked_beside
from workbench.formats.files.whole_files import read_whole
from workbench.formats.parts.reading import read_part
from workbench.model.errors import FileError, InputError
from workbench.web.access.kept_users import add_users, checked_users, kept_users, new_users
from workbench.web.access.store import OWNER_ONLY, Store

KEPT_USERS = "users.json"

LARGEST = 10 * 2**20
"""[bytes] Of the manifest, and of the users."""

Fate = Literal["new", "replaced", "the same", "left as it is"]


@dataclass(frozen=True, slots=True)
class Thing:
    """One cell, part or session in a backup, and what restoring does about it."""

    kind: str
    name: str
    fate: Fate


def backup(typed: arguments.Backup) -> int:
    """Write all of it into one zip file."""
    more = {KEPT_USERS: json.dumps(_users_of(typed.users)).encode()} if typed.with_users else {}
    kinds = KINDS if typed.with_sessions else KINDS[:-1]
    count = write_backup(Path.cwd(), typed.out, kinds, more)
    if typed.with_users:
        typed.out.chmod(OWNER_ONLY)
    print(f"{typed.out}: {count} files, {typed.out.stat().st_size / 1024:,.0f} kB")
    return SUCCESS


def _users_of(path: Path) -> Mapping[str, Any]:
    with contextlib.closing(Store(path)) as store:
        return kept_users(store)


def restore(typed: arguments.Restore) -> int:
    """Read everything in the backup, and only then put it in place of what is there."""
    root = Path.cwd()
    with unpacked_beside(typed.file, root) as place:
        _check(typed.file, place)
        things = [
            Thing(kind, thing.name, _fate(root / kind / thing.name, thing))
            for kind in KINDS
            for thing in things_in(place / kind)
        ]
        users = _users_in(typed.file, place)
        names = _restored_users(typed, users)
        things += [
            Thing("users", user["name"], "new" if user["name"] in names else "left as it is")
            for user in users
        ]
        if not typed.dry_run:
            _put_in_place(root, place, [thing for thing in things if thing.kind != "users"])
            if names:
                with contextlib.closing(Store(typed.users)) as store:
                    add_users(store, users)
    does = "would be" if typed.dry_run else "is"
    rows = [(thing.kind, thing.name, thing.fate) for thing in things]
    print_table(f"What {does} restored from {typed.file}", ("of", "name", "it is"), rows)
    return SUCCESS


def _users_in(path: Path, place: Path) -> Sequence[Mapping[str, Any]]:
    """The users in an unpacked backup, none when it has none.

    Raises:
        FileError: they cannot be read.
    """
    kept = place / KEPT_USERS
    if not kept.is_file():
        return ()
    try:
        return checked_users(json.loads(read_whole(kept, LARGEST)))
    except ValueError as error:
        raise FileError(path, f"users: {error}") from None
    except InputError as error:
        raise FileError(path, str(error)) from None


def _restored_users(
    typed: arguments.Restore, users: Sequence[Mapping[str, Any]]
) -> tuple[str, ...]:
    """Names of those who come back; the file of users is made only when somebody does."""
    if not users or not typed.users.is_file():
        return tuple(user["name"] for user in users)
    with contextlib.closing(Store(typed.users)) as store:
        return new_users(store, users)


def _check(path: Path, place: Path) -> None:
    """Read every cell, part and session of an unpacked backup.

    Raises:
        FileError: it is no backup, or something in it cannot be used.
        JournalError: a session was changed.
    """
    try:
        stated = json.loads(read_whole(place / MANIFEST, LARGEST))["format"]
    except (FileError, KeyError, TypeError, ValueError):
        raise FileError(path, "is no backup of a workbench") from None
    if stated != FORMAT:
        raise FileError(path, f"has format {stated!r}, expected {FORMAT!r}")
    strange = {one.name for one in place.iterdir()} - {MANIFEST, KEPT_USERS, *KINDS}
    if strange:
        raise FileError(path, f"holds {sorted(strange)[0]!r}, which no backup does")
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


def _is_same(one: Path, other: Path) -> bool:
    """Whether two files, or all files in two folders, have the same names and contents."""
    names = [file.relative_to(one) for file in files_of(one)]
    return names == [file.relative_to(other) for file in files_of(other)] and all(
        filecmp.cmp(one / name, other / name, shallow=False) for name in names
    )


def _put_in_place(root: Path, place: Path, things: list[Thing]) -> None:
    """Move new things in and old ones out.

    When that fails or is interrupted midway, all is as it was.

    Raises:
        FileError: something cannot be moved.
    """
    moved: list[tuple[Path, Path]] = []
    out = place / ".replaced"
    try:
        for thing in things:
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
            raise FileError(error.filename or root, f"not restored: {error.strerror}") from None
        raise
