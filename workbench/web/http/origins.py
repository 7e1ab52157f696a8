"""Which pages are our own: what the headers Host and Origin may say.

Any page of any site can have a browser send requests and open websockets to here, cookies
included; it can make its own name lead to this machine (DNS rebinding).  Hence names other than
those known are refused, and whatever changes something has to come from a page of ours.
"""

import ipaddress
import re
from collections.abc import Iterable
from urllib.parse import urlsplit

WILDCARDS = frozenset({"0.0.0.0", "::"})
"""Addresses that stand for all of this machine's."""

BARE = re.compile(r"(\[[\w.:%-]+\]|[\w.-]+)(:\d+)?", re.ASCII)
"""A host and a port, nothing else: it is written into policies that browsers follow."""


class Origins:
    """The names that we answer to.

    Concurrency: immutable; any thread.
    """

    def __init__(self, scheme: str, host: str, names: Iterable[str] = ()):
        """Answer to addresses, `localhost`, the host that is listened on, and further names.

        Args:
            scheme: `http` or `https`.
            host: that is listened on.
            names: under which browsers reach us beside that.
        """
        self._scheme = scheme
        self._names = {"localhost", *(name.casefold() for name in (host, *names))} - WILDCARDS

    def is_known(self, host: str | None) -> bool:
        """Whether a `Host` header names us."""
        if host is None or not BARE.fullmatch(host):
            return False
        try:
            split = urlsplit(f"//{host}")
            name, _ = split.hostname, split.port
        except ValueError:
            return False
        return name is not None and (name in self._names or _is_address(name))

    def is_own(self, origin: str | None, host: str | None) -> bool:
        """Whether an `Origin` header names a page of ours, exactly as it was asked for."""
        return origin is not None and origin.casefold() == f"{self._scheme}://{host}".casefold()


def network_of(address: str) -> str:
    """What counts as one address: whoever has one of IPv6 has all of a /64."""
    try:
        found = ipaddress.ip_address(address.partition("%")[0])
    except ValueError:
        return address
    if isinstance(found, ipaddress.IPv4Address):
        return address
    if found.ipv4_mapped is not None:
        return str(found.ipv4_mapped)
    return str(ipaddress.ip_network((found, 64), strict=False))


def _is_address(name: str) -> bool:
    try:
        ipaddress.ip_address(name)
    except ValueError:
        return False
    return True
