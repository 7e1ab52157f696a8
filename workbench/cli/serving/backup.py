"""`workbench backup` and `workbench restore`: cells, parts, sessions and users as one file."""

import contextlib
import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from workbench.app.records.keeping import BACKED_UP_FOLDERS, WITHOUT_SESSIONS, write_backup
from workbench.app.records.restoring import (
    KEPT_USERS,
    LARGEST_MANIFEST,
    Thing,
    put_in_place,
    unpack_backup,
)
from workbench.cli.arguments import top as arguments
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import print_table
from workbench.formats.files.whole_files import read_whole
from workbench.model.errors import FileError, InputError
from workbench.web.access.store import OWNER_ONLY, Store
from workbench.web.access.user_backup import add_users, checked_users, kept_users, new_users


def backup(typed: arguments.Backup) -> int:
    """Write all of it into one zip file."""
    more = {KEPT_USERS: json.dumps(_users_of(typed.users)).encode()} if typed.with_users else {}
    kinds = BACKED_UP_FOLDERS if typed.with_sessions else WITHOUT_SESSIONS
    count = write_backup(Path.cwd(), typed.out, kinds, more)
    if typed.with_users:
        typed.out.chmod(OWNER_ONLY)
    print(f"{typed.out}: {count} files, {typed.out.stat().st_size / 1024:,.0f} kB")
    return SUCCESS


def _users_of(path: Path) -> Mapping[str, Any]:
    with contextlib.closing(Store(path)) as store:
        return kept_users(store)


def restore(typed: arguments.Restore) -> int:
    """Read everything in the backup, and only then put it instead of what is there."""
    root = Path.cwd()
    with unpack_backup(typed.file, root) as kept:
        users = _users_in(typed.file, kept.users)
        names = _restored_users(typed, users)
        things = [
            *kept.things,
            *(
                Thing("users", user["name"], "new" if user["name"] in names else "left as it is")
                for user in users
            ),
        ]
        if not typed.dry_run:
            put_in_place(root, kept)
            if names:
                with contextlib.closing(Store(typed.users)) as store:
                    add_users(store, users)
    does = "would be" if typed.dry_run else "is"
    rows = [(thing.kind, thing.name, thing.fate) for thing in things]
    print_table(f"What {does} restored from {typed.file}", ("of", "name", "it is"), rows)
    return SUCCESS


def _users_in(path: Path, kept: Path | None) -> Sequence[Mapping[str, Any]]:
    """The users in an unpacked backup, none when it has none.

    Raises:
        FileError: they cannot be read.
    """
    if kept is None:
        return ()
    try:
        return checked_users(json.loads(read_whole(kept, LARGEST_MANIFEST)))
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
