"""Logins: a random cookie in the browser, and here who it stands for and until when."""

import secrets
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass

from workbench.app.core.people import NOBODY, Person, Role
from workbench.web.access.store import Store
from workbench.web.access.users import digest_of, fold_name

HOURS = 8.0
"""How long a login lasts: a shift."""


@dataclass(frozen=True, slots=True)
class Session:
    """One browser's login; `digest` stands for its cookie, which is not kept."""

    digest: str
    person: Person


class Sessions:
    """The logins in a store; they outlive a restart.

    Concurrency: any thread.
    """

    def __init__(self, store: Store, *, hours: float = HOURS, now: Callable[[], float] = time.time):
        """The logins in `store`, which last for `hours`; `now` is the time [s since 1970]."""
        self._store = store
        self._seconds = hours * 3600
        self._now = now

    @property
    def seconds(self) -> float:
        """How long a login lasts [s]."""
        return self._seconds

    def begin(self, person: Person | None) -> str:
        """A new login; None is who uses the page before there are users.

        Returns:
            The cookie.  It stands for no login when the user has been removed or disabled
            since the password was tried; or the first user added since the link was opened.
        """
        cookie = secrets.token_urlsafe(32)
        now = self._now()
        user = None if person is None else fold_name(person.name)
        with self._store.change() as connection:
            connection.execute("DELETE FROM sessions WHERE expires_at <= ?", (now,))
            connection.execute(
                """
                INSERT INTO sessions (digest, user, expires_at)
                SELECT :digest, :user, :until WHERE CASE WHEN :user IS NULL
                    THEN NOT EXISTS (SELECT 1 FROM users)
                    ELSE EXISTS (SELECT 1 FROM users WHERE key = :user AND is_disabled = 0)
                END
                """,
                {"digest": digest_of(cookie), "user": user, "until": now + self._seconds},
            )
        return cookie

    def find(self, cookie: str) -> Session | None:
        """The login that a cookie stands for, if it still does."""
        question = """
            SELECT sessions.digest, sessions.user, users.name, users.role
            FROM sessions LEFT JOIN users ON users.key = sessions.user
            WHERE sessions.digest = ? AND sessions.expires_at > ?
                AND coalesce(users.is_disabled, 0) = 0
                AND (sessions.user IS NOT NULL OR NOT EXISTS (SELECT 1 FROM users))
        """
        rows = self._store.ask(question, digest_of(cookie), self._now())
        if not rows:
            return None
        digest, user, name, role = rows[0]
        person = Person(NOBODY, Role.ENGINEER) if user is None else Person(name, Role(role))
        return Session(digest, person)

    def over(self, digests: Iterable[str]) -> frozenset[str]:
        """Which of these logins hold no more: expired, logged out, or taken from their user."""
        asked = frozenset(digests)
        if not asked:
            return asked
        now = self._now()
        rows = self._store.ask("SELECT digest FROM sessions WHERE expires_at > ?", now)
        return asked - {row[0] for row in rows}

    def end(self, digest: str) -> None:
        """Log out; a login that is over already does no harm."""
        with self._store.change() as connection:
            connection.execute("DELETE FROM sessions WHERE digest = ?", (digest,))
