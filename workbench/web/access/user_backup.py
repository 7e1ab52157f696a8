"""Users as a backup keeps them: names, roles, hashes; nobody who is logged in."""

import sqlite3
from collections.abc import Mapping, Sequence
from typing import Any, cast

from workbench.app.core.people import Role
from workbench.model.errors import InputError
from workbench.web.access.passwords import is_hash
from workbench.web.access.store import Store
from workbench.web.access.users import key_of

FORMAT = "workbench-users/1"
MOST_USERS = 10_000


def kept_users(store: Store) -> Mapping[str, Any]:
    """All users, as JSON; whoever reads it can try passwords against the hashes."""
    tokens = store.ask("SELECT user, digest, name, made_at FROM tokens ORDER BY user, name")
    return {
        "format": FORMAT,
        "users": [
            {
                "name": name,
                "role": role,
                "hash": kept,
                "is_disabled": bool(is_disabled),
                "tokens": [
                    {"digest": digest, "name": called, "made_at": made_at}
                    for user, digest, called, made_at in tokens
                    if user == key
                ],
            }
            for key, name, role, kept, is_disabled in store.ask(
                "SELECT key, name, role, hash, is_disabled FROM users ORDER BY key"
            )
        ],
    }


def checked_users(form: Any) -> Sequence[Mapping[str, Any]]:
    """The users of a backup, each checked.

    Raises:
        InputError: it holds something else.
    """
    if not isinstance(form, dict) or cast(dict[str, Any], form).get("format") != FORMAT:
        raise InputError(f"users: format {FORMAT!r} was expected")
    users: Any = cast(dict[str, Any], form).get("users")
    if not isinstance(users, list) or len(cast(list[Any], users)) > MOST_USERS:
        raise InputError(f"users: a list of up to {MOST_USERS} was expected")
    keys: set[str] = set()
    for number, user in enumerate(cast(list[Any], users), start=1):
        try:
            key = key_of(user["name"])
            Role(user["role"])
            sound = is_hash(user["hash"]) and isinstance(user["is_disabled"], bool)
            for token in user["tokens"]:
                sound = sound and len(bytes.fromhex(token["digest"])) == 32
                sound = sound and isinstance(token["name"], str)
                float(token["made_at"])
        except (KeyError, TypeError, ValueError, AttributeError) as error:
            raise InputError(f"users: number {number} cannot be one: {error!r}") from error
        if not sound:
            raise InputError(f"users: number {number} has no hash that could be a password's")
        if key in keys:
            raise InputError(f"users: number {number} is there twice")
        keys.add(key)
    return cast(Sequence[Mapping[str, Any]], users)


def new_users(store: Store, users: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Names of those in a backup who are not there yet."""
    known = {key for (key,) in store.ask("SELECT key FROM users")}
    return tuple(user["name"] for user in users if key_of(user["name"]) not in known)


def add_users(store: Store, users: Sequence[Mapping[str, Any]]) -> None:
    """Let in again who is in a backup and not there; whoever is there stays as they are.

    Raises:
        FileError: the file cannot be written, or a token is somebody else's there; nobody was
            added then.
    """
    names = set(new_users(store, users))
    with store.change() as connection:
        for user in users:
            if user["name"] in names:
                _add(connection, user)
        if names:
            # As with the first user who is added: whoever came by the link is nobody any more.
            connection.execute("DELETE FROM sessions WHERE user IS NULL")


def _add(connection: sqlite3.Connection, user: Mapping[str, Any]) -> None:
    key = key_of(user["name"])
    connection.execute(
        "INSERT INTO users (key, name, role, hash, is_disabled) VALUES (?, ?, ?, ?, ?)",
        (key, user["name"], user["role"], user["hash"], int(user["is_disabled"])),
    )
    connection.executemany(
        "INSERT INTO tokens (digest, user, name, made_at) VALUES (?, ?, ?, ?)",
        [(token["digest"], key, token["name"], token["made_at"]) for token in user["tokens"]],
    )
