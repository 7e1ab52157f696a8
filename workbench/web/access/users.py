"""Users with a role and a password, and tokens for their programs."""

import hashlib
import secrets
import sqlite3
import time
import unicodedata
from collections.abc import Callable
from dataclasses import dataclass

from workbench.app.core.people import MACHINES, NOBODY, Person, Role
from workbench.model.errors import InputError
from workbench.web.access.passwords import NOBODYS, hash_of, is_right
from workbench.web.access.store import Store

LONGEST_NAME = 64

TOKEN_MARK = "wb_"
"""Beginning of every token, so that scanners recognise a leaked one."""


@dataclass(frozen=True, slots=True)
class ProgramToken:
    """A program's token; its text was shown once and is not stored."""

    name: str
    made_at: float


@dataclass(frozen=True, slots=True)
class User:
    """A user, who may log in unless disabled."""

    name: str
    role: Role
    is_disabled: bool
    tokens: tuple[ProgramToken, ...]

    @property
    def person(self) -> Person:
        """The user as the actor of commands."""
        return Person(self.name, self.role)


class Users:
    """The users in a store.

    A change that removes a right from a user also ends that user's logins.

    Concurrency: any thread.
    """

    def __init__(self, store: Store, now: Callable[[], float] = time.time):
        """The users in `store`; `now` is the time [s since 1970]."""
        self._store = store
        self._now = now

    def all(self) -> tuple[User, ...]:
        """All users, sorted by name."""
        tokens: dict[str, list[ProgramToken]] = {}
        for key, name, made_at in self._store.ask(
            "SELECT user, name, made_at FROM tokens ORDER BY name"
        ):
            tokens.setdefault(key, []).append(ProgramToken(name, made_at))
        return tuple(
            User(name, Role(role), bool(is_disabled), tuple(tokens.get(key, ())))
            for key, name, role, is_disabled in self._store.ask(
                "SELECT key, name, role, is_disabled FROM users ORDER BY key"
            )
        )

    def are_there(self) -> bool:
        """Whether there are users, disabled ones included."""
        return bool(self._store.ask("SELECT 1 FROM users LIMIT 1"))

    def add(self, name: str, role: Role, password: str) -> None:
        """Add a user.  This ends the login by the first link, which needs an empty list of users.

        Raises:
            InputError: the name is impossible or taken, or the password is too short.
        """
        key, kept = key_of(name), hash_of(password)
        with self._store.change() as connection:
            if connection.execute("SELECT 1 FROM users WHERE key = ?", (key,)).fetchone():
                raise InputError(f"there is a user {name!r} already")
            connection.execute(
                "INSERT INTO users (key, name, role, hash) VALUES (?, ?, ?, ?)",
                (key, name, role, kept),
            )
            connection.execute("DELETE FROM sessions WHERE user IS NULL")

    def remove(self, name: str) -> None:
        """Remove a user, with tokens and logins.

        Raises:
            InputError: there is no such user.
        """
        self._alter(name, "DELETE FROM users WHERE key = :key")

    def set_disabled(self, name: str, is_disabled: bool) -> None:
        """Disable or enable a user.

        Raises:
            InputError: there is no such user.
        """
        self._alter(name, "UPDATE users SET is_disabled = :to WHERE key = :key", int(is_disabled))

    def set_role(self, name: str, role: Role) -> None:
        """Change the role of a user.

        Raises:
            InputError: there is no such user.
        """
        self._alter(name, "UPDATE users SET role = :to WHERE key = :key", role)

    def language(self, name: str) -> str:
        """The language that a user has chosen for the page; empty: none."""
        rows = self._store.ask("SELECT language FROM users WHERE key = ?", fold_name(name))
        return rows[0][0] if rows else ""

    def keep_language(self, name: str, language: str) -> None:
        """Store the language that a user has chosen; does nothing for a removed user."""
        with self._store.change() as connection:
            connection.execute(
                "UPDATE users SET language = ? WHERE key = ?", (language, fold_name(name))
            )

    def set_password(self, name: str, password: str) -> None:
        """Change the password of a user.

        Raises:
            InputError: there is no such user, or the password is too short.
        """
        self._alter(name, "UPDATE users SET hash = :to WHERE key = :key", hash_of(password))

    def make_token(self, name: str, called: str) -> str:
        """Make a token for a program that acts for a user; only this call returns its text.

        Raises:
            InputError: there is no such user, or the user has a token of that name.
        """
        if not called.strip() or len(called) > LONGEST_NAME or not called.isprintable():
            raise InputError(f"a token's name has 1 to {LONGEST_NAME} characters, not {called!r}")
        token = TOKEN_MARK + secrets.token_urlsafe(32)
        with self._store.change() as connection:
            key = self._find_user(connection, name)
            known = "SELECT 1 FROM tokens WHERE user = ? AND name = ?"
            if connection.execute(known, (key, called)).fetchone():
                raise InputError(f"{name} has a token {called!r} already; revoke it first")
            connection.execute(
                "INSERT INTO tokens (digest, user, name, made_at) VALUES (?, ?, ?, ?)",
                (digest_of(token), key, called, self._now()),
            )
        return token

    def revoke_token(self, name: str, called: str) -> None:
        """Revoke a token.

        Raises:
            InputError: there is no such user or token.
        """
        with self._store.change() as connection:
            key = self._find_user(connection, name)
            gone = connection.execute(
                "DELETE FROM tokens WHERE user = ? AND name = ?", (key, called)
            )
            if not gone.rowcount:
                raise InputError(f"{name} has no token {called!r}")

    def by_password(self, name: str, password: str) -> Person | None:
        """The user with this name and password, else None; an unknown name takes the same time."""
        question = "SELECT name, role, hash FROM users WHERE key = ? AND is_disabled = 0"
        rows = self._store.ask(question, fold_name(name))
        known, role, kept = rows[0] if rows else ("", Role.VIEWER, NOBODYS)
        is_theirs = is_right(password, kept)
        return Person(known, Role(role)) if rows and is_theirs else None

    def by_token(self, token: str) -> Person | None:
        """The user of a token; None: the token is not valid."""
        question = """
            SELECT users.name, users.role FROM tokens JOIN users ON users.key = tokens.user
            WHERE tokens.digest = ? AND users.is_disabled = 0
        """
        rows = self._store.ask(question, digest_of(token))
        return Person(rows[0][0], Role(rows[0][1])) if rows else None

    def _alter(self, name: str, statement: str, to: object = None) -> None:
        with self._store.change() as connection:
            key = self._find_user(connection, name)
            connection.execute("DELETE FROM sessions WHERE user = ?", (key,))
            connection.execute("DELETE FROM browsers WHERE user = ?", (key,))
            connection.execute(statement, {"key": key, "to": to})

    def _find_user(self, connection: sqlite3.Connection, name: str) -> str:
        """The key of an existing user."""
        key = fold_name(name)
        if connection.execute("SELECT 1 FROM users WHERE key = ?", (key,)).fetchone():
            return key
        names = [row[0] for row in connection.execute("SELECT name FROM users ORDER BY key")]
        listed = ", ".join(names) if names else "nobody"
        raise InputError(f"there is no user {name!r} (there is {listed})")


def digest_of(secret: str) -> str:
    """The stored hash of a random secret, whose 256 bits need no slow hash."""
    return hashlib.sha256(secret.encode(errors="replace")).hexdigest()


def fold_name(name: str) -> str:
    """The form in which names are compared: without capitals, and with accents composed.

    Surrogates, which stand for undecodable bytes of a command line, become question marks.
    """
    return unicodedata.normalize("NFKC", name).casefold().encode(errors="replace").decode()


def key_of(name: str) -> str:
    """The key of a name for a new user.

    Raises:
        InputError: the name is not allowed.
    """
    is_plain = name.isprintable() and name.split() == name.split(" ")
    if not 0 < len(name) <= LONGEST_NAME or not is_plain:
        raise InputError(
            f"a user's name has 1 to {LONGEST_NAME} printable characters and single spaces "
            f"between them, not {name[: LONGEST_NAME + 1]!r}"
        )
    if fold_name(name) in {fold_name(taken) for taken in (*MACHINES, NOBODY)}:
        raise InputError(f"the name {name!r} stands for no person in the record; choose another")
    return fold_name(name)
