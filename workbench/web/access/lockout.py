"""After too many failed logins in a while, no more: for an address, and for a name."""

import ipaddress
import time
from collections.abc import Callable
from dataclasses import dataclass

from workbench.web.access.store import Store
from workbench.web.access.users import digest_of, folded

MOST = 10
"""Failed logins in `WHILE`."""

WHILE = 300.0
"""[s]"""


@dataclass(frozen=True, slots=True)
class Attempt:
    """A login that is being tried; counts as failed so far."""

    numbers: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class LockedOut:
    """No login may be tried for so many seconds."""

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

    def begin(self, address: str, name: str) -> Attempt | LockedOut:
        """Begin an attempt.

        Args:
            address: of the browser.
            name: that is tried.

        Returns:
            What to hand to `succeeded`; or that there were too many.
        """
        now = self._now()
        with self._store.change() as connection:
            connection.execute("DELETE FROM failures WHERE at <= ?", (now - WHILE,))
            numbers: list[int] = []
            for subject in _subjects(address, name):
                (count, first) = connection.execute(
                    "SELECT count(*), min(at) FROM failures WHERE subject = ?", (subject,)
                ).fetchone()
                if count >= MOST:
                    return LockedOut(max(1.0, float(first) + WHILE - now))
            for subject in _subjects(address, name):
                row = connection.execute(
                    "INSERT INTO failures (subject, at) VALUES (?, ?)", (subject, now)
                )
                numbers.append(int(row.lastrowid or 0))
        return Attempt(tuple(numbers))

    def succeeded(self, attempt: Attempt) -> None:
        """An attempt has not failed; earlier ones that did still count."""
        with self._store.change() as connection:
            for number in attempt.numbers:
                connection.execute("DELETE FROM failures WHERE id = ?", (number,))


def _subjects(address: str, name: str) -> tuple[str, str]:
    # Names come from whoever tries; as digests they are all of one length.
    return f"address {network_of(address)}", f"name {digest_of(folded(name))}"


def network_of(address: str) -> str:
    """What counts as one address: whoever has one of IPv6 has all of a /64."""
    try:
        parsed = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if isinstance(parsed, ipaddress.IPv6Address):
        if parsed.ipv4_mapped is not None:
            return str(parsed.ipv4_mapped)
        return str(ipaddress.ip_network((parsed, 64), strict=False))
    return str(parsed)
