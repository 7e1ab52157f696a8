"""After too many failed logins in a while, no more: for an address, and for a name.

A browser in which somebody has logged in before counts by itself when the same name is tried: what
others get wrong keeps nobody out who has been in.
"""

import secrets
import time
from collections.abc import Callable
from dataclasses import dataclass

from workbench.web.access.store import Store
from workbench.web.access.users import digest_of, fold_name
from workbench.web.http.origins import network_of

MOST_FAILURES = 10
"""Failed logins in `WHILE`."""

WHILE = 300.0
"""[s]"""

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
    """No login may be tried for this many seconds."""

    seconds: float


class Lockout:
    """Counts failed logins, in a store, so that a restart forgets none.

    An attempt counts as failed from its start until it has succeeded: attempts made side by side
    are no way around.  Names that nobody has count like any other.

    Concurrency: any thread.
    """

    def __init__(self, store: Store, now: Callable[[], float] = time.time):
        """Counts in `store`; `now` is the time [s since 1970]."""
        self._store = store
        self._now = now

    def begin(self, address: str, name: str, browser: str = "") -> LoginAttempt | LockedOut:
        """Begin an attempt.

        Args:
            address: of the browser.
            name: that is tried.
            browser: what `remember` has given to it, if anything.

        Returns:
            What to hand to `note_success`; or that there were too many.
        """
        subjects = _subjects(address, name)
        if browser and self._is_of(browser, name):
            # By name, too: what one gets wrong at a panel keeps out nobody else who works there.
            subjects = (f"browser {digest_of(browser)} {subjects[1]}",)
        with self._store.change() as connection:
            # In here, so that of attempts side by side none is later than another's now.
            now = self._now()
            # What is still to come was written before the clock was set back.
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
        """An attempt has not failed; earlier ones that did still count."""
        with self._store.change() as connection:
            for number in attempt.numbers:
                connection.execute("DELETE FROM failures WHERE id = ?", (number,))

    def remember(self, name: str, browser: str = "") -> str:
        """Take note of a browser in which somebody has logged in.

        Args:
            name: of who has.
            browser: what the browser has shown, if anything.

        Returns:
            What the browser has to show the next time.  It is another one each time: a copy of the
            one before is worth nothing to whoever has it.
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
        """End a lockout: of one name, or all of them, those of addresses included.

        Returns:
            How many failed logins are forgotten.
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
    # Names come from whoever tries; as digests they are all of one length.
    return f"address {network_of(address)}", f"name {digest_of(fold_name(name))}"
