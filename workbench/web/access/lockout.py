"""Lockout after too many failed logins, for an address and for a name.

A browser in which a user has logged in before has its own count for that name.  So failed logins
elsewhere do not lock out the user.
"""

import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass

from workbench.web.access.store import Store
from workbench.web.access.users import digest_of, fold_name
from workbench.web.http.origins import network_of

MOST_FAILURES = 10
"""Number of failed logins in `WHILE` that causes a lockout."""

WHILE = 300.0
"""[s] Interval in which failed logins are counted."""

REMEMBERED = 180 * 86400.0
"""[s] Time for which a browser is known after a login."""

MOST_BROWSERS = 20
"""Largest number of known browsers of a user; the oldest are forgotten."""


@dataclass(frozen=True, slots=True)
class LoginAttempt:
    """A login in progress; it counts as failed until it succeeds."""

    numbers: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class LockedOut:
    """A lockout that ends in this many seconds."""

    seconds: float


class Lockout:
    """Counts failed logins in a store, so that a restart keeps the counts.

    An attempt counts as failed from its start until it succeeds, so parallel attempts count, too.
    Unknown names count like all others.

    Concurrency: any thread.
    """

    def __init__(self, store: Store, now: Callable[[], float] = time.time):
        """Count in `store`; `now` returns the time [s since 1970]."""
        self._store = store
        self._now = now

    def begin(self, address: str, name: str, browser: str = "") -> LoginAttempt | LockedOut:
        """Begin an attempt.

        Args:
            address: address of the browser.
            name: name in the form.
            browser: the browser's value from `remember`; empty: none.

        Returns:
            The attempt, for `note_success`; or the lockout.
        """
        subjects = _subjects(address, name)
        if browser and self._is_of(browser, name):
            # Also by name: at a shared panel one user's failures must not lock out the others.
            subjects = (f"browser {digest_of(browser)} {subjects[1]}",)
        with self._store.change() as connection:
            # Read inside the change, so that parallel attempts are in order.
            now = self._now()
            # Times in the future come from before the clock was set back.
            connection.execute("DELETE FROM failures WHERE at <= ? OR at > ?", (now - WHILE, now))
            numbers: list[int] = []
            for subject in subjects:
                (count, first) = connection.execute(
                    "SELECT count(*), min(at) FROM failures WHERE subject = ?", (subject,)
                ).fetchone()
                if count >= MOST_FAILURES:
                    return LockedOut(max(1.0, float(first) + WHILE - now))
            for subject in subjects:
                row = connection.execute(
                    "INSERT INTO failures (subject, at) VALUES (?, ?)", (subject, now)
                )
                numbers.append(int(row.lastrowid or 0))
        return LoginAttempt(tuple(numbers))

    def note_success(self, attempt: LoginAttempt) -> None:
        """Remove a successful attempt from the count; earlier failures stay."""
        with self._store.change() as connection:
            for number in attempt.numbers:
                connection.execute("DELETE FROM failures WHERE id = ?", (number,))

    def remember(self, name: str, browser: str = "") -> str:
        """Remember a browser in which a user has logged in.

        Args:
            name: name of the user.
            browser: the browser's value from the previous call; empty: none.

        Returns:
            The new value for the browser's next login, so that a copy of the old one is worthless.
        """
        cookie, now = secrets.token_urlsafe(32), self._now()
        with self._store.change() as connection:
            connection.execute("DELETE FROM browsers WHERE expires_at <= ?", (now,))
            connection.execute(
                "UPDATE browsers SET digest = ? WHERE digest = ?",
                (digest_of(cookie), digest_of(browser)),
            )
            connection.execute(
                "INSERT OR REPLACE INTO browsers (digest, user, expires_at)"
                " SELECT ?, key, ? FROM users WHERE key = ?",
                (digest_of(cookie), now + REMEMBERED, fold_name(name)),
            )
            connection.execute(
                "DELETE FROM browsers WHERE user = ? AND digest NOT IN (SELECT digest FROM browsers"
                " WHERE user = ? ORDER BY expires_at DESC LIMIT ?)",
                (fold_name(name), fold_name(name), MOST_BROWSERS),
            )
        return cookie

    def forget(self, name: str | None = None) -> int:
        """End the lockout of a name, or all lockouts, those of addresses included.

        Returns:
            The number of removed failures.
        """
        with self._store.change() as connection:
            if name is None:
                return connection.execute("DELETE FROM failures").rowcount
            subject = _subjects("", name)[1]
            of_name = "DELETE FROM failures WHERE subject = ? OR subject LIKE 'browser % ' || ?"
            return connection.execute(of_name, (subject, subject)).rowcount

    def _is_of(self, browser: str, name: str) -> bool:
        question = "SELECT 1 FROM browsers WHERE digest = ? AND user = ? AND expires_at > ?"
        return bool(self._store.ask(question, digest_of(browser), fold_name(name), self._now()))


def _subjects(address: str, name: str) -> tuple[str, str]:
    # Digests of names have one length, however long a stranger's input is.
    return f"address {network_of(address)}", f"name {digest_of(fold_name(name))}"
