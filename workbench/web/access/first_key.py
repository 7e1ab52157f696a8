"""The link that lets one browser in when there are no users yet."""

import hmac
import secrets
import threading

from workbench.plugins.addresses import is_loopback
from workbench.web.access.users import Users


class FirstKey:
    """A key that was printed where the workbench was started; it opens once.

    Concurrency: any thread.
    """

    def __init__(self, users: Users, *, from_anywhere: bool):
        """A new key, or none when there are users.

        Args:
            users: who may log in without it.
            from_anywhere: whether it opens for browsers on other machines, too.
        """
        self._users = users
        self._from_anywhere = from_anywhere
        self._lock = threading.Lock()
        self._key = "" if users.are_there() else secrets.token_urlsafe(32)

    @property
    def key(self) -> str:
        """The key; empty when there is none, or none any more."""
        return self._key

    def take(self, key: str, address: str | None) -> bool:
        """Whether this key opens, for a browser at this address; it does so once."""
        if not (self._from_anywhere or is_loopback(address)):
            return False
        with self._lock:
            is_right = hmac.compare_digest(key.encode(), self._key.encode())
            if not (self._key and is_right) or self._users.are_there():
                return False
            self._key = ""
            return True
