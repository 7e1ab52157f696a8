"""Entries of a session one cycle after the other, also where two of them overlap.

What is worked on for the next cycle while a plan is sent (`app.core.cycle.ahead`) is held back
until that plan has ended.  It is listed then if it has become the next cycle's, else not at all.
"""

import json
from collections.abc import Collection, Iterator
from typing import Any

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.jobs import CancelJob, JobEnded
from workbench.app.core.cycle.sending import LinkEnded, Sent
from workbench.journal.journal import Row

TurnEntry = tuple[str, int, Any]
"""An entry: its kind, its number, and what it holds."""


class Turns:
    """Takes entries as they come.

    Concurrency: one thread.
    """

    def __init__(self, kinds: Collection[str]) -> None:
        """Only entries of these kinds are reported."""
        self._kinds = kinds
        # While it is wanted to go on: the entry that has begun the scan, and ends of tasks.
        self._held: list[TurnEntry] | None = None

    def release_entries(self, row: Row) -> Iterator[TurnEntry]:
        """What there is to tell once this entry has come.

        Where a cycle was begun beside the one before, its first entry `began` before it is `at`.

        Raises:
            LookupError, TypeError, ValueError: the entry cannot be read.
        """
        may_begin = self._held == [] and row.kind == Sent.__name__
        if row.kind not in self._kinds and not may_begin:
            return
        body = json.loads(row.body)
        after, record = body["after"], (row.kind, row.number, body)
        is_sending = after.get("phase") == "sending"
        if is_sending and row.kind in (GoOn.__name__, Sent.__name__):
            self._held = [record] if after["job"] == row.number else []
        elif is_sending and row.kind == CancelJob.__name__:
            self._held = None
        elif is_sending and row.kind == JobEnded.__name__:
            if self._held:
                self._held.append(record)
        elif not is_sending and row.kind == LinkEnded.__name__ and self._held is not None:
            held, self._held = self._held, None
            if after["job"] == row.number and after["phase"] == "localized":
                held = []  # after a missed grip a plan without a scan has begun instead
            yield record
            if after["job"] is not None or after["phase"] not in ("done", "fault"):
                began, *ends = held or [record]
                number, at = began[1], began[2]["at"]
                yield GoOn.__name__, number, {**body, "began": at, "command": {}}
                yield from ends
        else:
            yield record
