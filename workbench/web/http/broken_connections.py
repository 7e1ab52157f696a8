"""Connections that break off: no fault of anybody's here, and nothing that a log has to tell."""

import errno

GONE = frozenset({errno.ENOTCONN, errno.EPIPE, errno.ESHUTDOWN, errno.ECONNRESET})


def is_broken_off(error: BaseException | None) -> bool:
    """Whether an error only says that the other end has gone."""
    return isinstance(error, ConnectionError) or (
        isinstance(error, OSError) and error.errno in GONE
    )
