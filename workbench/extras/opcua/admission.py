"""Logins over OPC UA, and the person as which each client acts."""

import hmac
import logging
import time
from collections import deque
from collections.abc import Callable
from contextvars import ContextVar
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from asyncua import ua
from asyncua.crypto.permission_rules import User, UserRole
from asyncua.server.user_managers import UserManager

from workbench.app.core.people import Person
from workbench.extras.opcua.bounds import CALLER
from workbench.extras.opcua.certificates import problem
from workbench.plugins.addresses import is_loopback
from workbench.web.access.lockout import MOST_FAILURES, WHILE, LockedOut, Lockout
from workbench.web.access.users import Users

log = logging.getLogger(__name__)

LONGEST_WORD = 1000
"""Longest name or password [characters]."""


@dataclass(frozen=True, slots=True)
class OpcUaLogins:
    """The users of the page, and the counter of their failed logins."""

    users: Users
    lockout: Lockout


@dataclass(frozen=True, slots=True)
class OpcUaOptions:
    """Options of the server.

    Attributes:
        operator: the person as which a client without its own login acts.
        password: password of the operator; empty: only clients on this machine, without one.
        certificates: folder of certificates; None: no channel is signed or encrypted.
        is_plain: whether to accept plain channels, too, when there are certificates.
        logins: logins of the page's users, for encrypted channels; None: not accepted.
    """

    port: int
    operator: Person
    host: str = "127.0.0.1"
    password: str = ""
    certificates: Path | None = None
    is_plain: bool = False
    logins: OpcUaLogins | None = None

    @property
    def takes_plain(self) -> bool:
        """Whether the server accepts channels without protection."""
        return self.is_plain or self.certificates is None


PERSON: ContextVar[Person | None] = ContextVar("opcua_person", default=None)
"""The last login on the connection of the current task."""


class Door(UserManager):
    """Admits clients with the right password; without a password all clients on this machine.

    After too many wrong passwords it refuses new clients for a while.  Failed logins of the page's
    users count together with those on the page.
    """

    def __init__(self, options: OpcUaOptions, now: Callable[[], float] = time.monotonic):
        """Admit clients by these options; `now` returns monotonic seconds."""
        self._options, self._now = options, now
        self._failed: deque[float] = deque(maxlen=MOST_FAILURES)

    def problem(self, certificate: bytes | None) -> str:
        """The problem of a certificate that prevents a channel; empty when there is none."""
        folder = self._options.certificates
        return "" if folder is None else problem(folder, certificate)

    def get_user(
        self,
        iserver: Any,
        username: str | None = None,
        password: str | None = None,
        certificate: Any = None,
    ) -> User | None:
        """The library's user for a login; None: the login is refused."""
        caller = CALLER.get(None)
        mode = ua.MessageSecurityMode.None_ if caller is None else caller.mode
        if mode == ua.MessageSecurityMode.None_ and not self._options.takes_plain:
            log.warning("refused a login over OPC UA: the channel is neither signed nor encrypted")
            return None
        if len(username or "") > LONGEST_WORD or len(password or "") > LONGEST_WORD:
            return None
        address = "" if caller is None else caller.address
        person = self._of_page(mode, address, username, password)
        if person is None:
            person = self._operator(username, password)
        if person is None:
            return None
        PERSON.set(person)
        return User(role=UserRole.User, name=person.name)

    def is_still_in(self, person: Person) -> bool:
        """Whether a person who has logged in may still call methods, with the same role."""
        logins = self._options.logins
        if person == self._options.operator or logins is None:
            return True
        return any(
            (user.name, user.role) == (person.name, person.role) and not user.is_disabled
            for user in logins.users.all()
        )

    def _of_page(
        self, mode: ua.MessageSecurityMode, address: str, name: str | None, password: str | None
    ) -> Person | None:
        logins = self._options.logins
        if logins is None or not (name and password) or name == self._options.operator.name:
            return None
        if mode != ua.MessageSecurityMode.SignAndEncrypt or not logins.users.are_there():
            return None
        attempt = logins.lockout.begin(address, name)
        if isinstance(attempt, LockedOut):
            return None
        person = logins.users.by_password(name, password)
        if person is not None:
            logins.lockout.note_success(attempt)
        return person

    def _operator(self, username: str | None, password: str | None) -> Person | None:
        operator, wanted = self._options.operator, self._options.password
        if not wanted:
            # A login with a password is a page user's; a wrong one does not become the operator.
            is_named = self._options.logins is not None and bool(password)
            return operator if is_loopback(self._options.host) and not is_named else None
        if not (username and password):
            # Programs that browse servers connect without a name; this counts as no attempt.
            return None
        if len(self._failed) == MOST_FAILURES and self._now() - self._failed[0] < WHILE:
            return None
        is_right = hmac.compare_digest(password.encode(), wanted.encode())
        if username == operator.name and is_right:
            return operator
        self._failed.append(self._now())
        why = (
            "wrong password" if username == operator.name else f"the operator is {operator.name!r}"
        )
        log.warning("refused a login over OPC UA as %r: %s", username, why)
        if len(self._failed) == MOST_FAILURES and self._now() - self._failed[0] < WHILE:
            log.warning("for %g s nobody logs in over OPC UA: too many wrong passwords", WHILE)
        return None
