"""One line in the log for each refusal: what, who, from where, why."""

import json
import logging

log = logging.getLogger("workbench.web")

LONGEST_TEXT = 200


def log_refusal(what: str, *, why: str, origin: str | None, who: str | None = None) -> None:
    """Write the line.

    Args:
        what: was refused, in few words that can be searched for.
        why: in words; may quote what came from outside.
        origin: the address that it came from.
        who: name of the user; None when nobody has logged in.
    """
    log.warning(
        # A form for each: of those that come too often some are left out (`sparing.py`).
        f"refused {what}: who=%s from=%s why=%s",
        _quote(who or "nobody"),
        _quote(origin or "unknown"),
        _quote(why),
    )


def _quote(text: str) -> str:
    """As one word on one line, whatever somebody has put into it."""
    return json.dumps(text if len(text) <= LONGEST_TEXT else text[:LONGEST_TEXT] + "...")
