"""A long session: a recorded cycle is given again and again, by the rules, into a new journal."""

import tempfile
from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

from workbench.app.core.command import Entry
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.decide import check_allowed, decide
from workbench.app.core.state import State
from workbench.app.records.record import command_form, entry_record
from workbench.app.records.replay import replay
from workbench.app.records.session_archive import export_session, list_session
from workbench.app.records.sessions import cell_of, new_session
from workbench.app.review.history import History
from workbench.app.statistics.statistics import Statistics, statistics
from workbench.app.statistics.statistics_table import csv_text
from workbench.journal.journal import Journal
from workbench.model.errors import InputError
from workbench.studies.scale.growth import Costs, processor_seconds, seconds_and_megabytes

APPENDED = 200
"""Entries that are appended to a session to measure one of them."""

PAUSE = 5.0
"""[s] Between two cycles, by the clock of the entries."""

MS = 1000.0

OtherSteps = Callable[[Journal, Statistics, Path], Costs]
"""More that is measured of a session: its journal, what it brought, a folder to write into."""


class SessionWriter:
    """Writes a session as long as wanted: the last cycle of a recorded one, again and again.

    Concurrency: one thread.
    """

    def __init__(self, recorded: Journal, root: Path):
        """A session that has only begun.

        Args:
            recorded: a session whose last cycle ended well, after another one.
            root: folder for the folder of the new session.

        Raises:
            InputError: no cycle was recorded.
        """
        cell = cell_of(recorded)
        entries = [entry for entry, _ in replay(recorded, cell)]
        begins = [k for k, entry in enumerate(entries) if isinstance(entry.command, TakeScan)]
        if not begins:
            raise InputError(f"{recorded.folder}: no cycle was recorded")
        self._cycle: Sequence[Entry] = entries[begins[-1] :]
        self._place, self._later = 0, 0.0
        self._state = State(cell, number=1, saved=cell.digest)
        self.journal = new_session(root, cell, self._cycle[0].at)

    def write(self, count: int) -> None:
        """Append entries until there are `count`."""
        while self.journal.count < count:
            self._append(self._cycle[self._place])
            self._place += 1
            if self._place == len(self._cycle):
                self._place = 0
                self._later += self._cycle[-1].at - self._cycle[0].at + PAUSE

    def _append(self, recorded: Entry) -> None:
        state, command = self._state, recorded.command
        if isinstance(command, JobEnded) and state.job is not None:
            command = replace(command, number=state.job.number)
        entry = replace(
            recorded, number=state.number + 1, at=recorded.at + self._later, command=command
        )
        check_allowed(state, command, entry.actor, entry.at, entry.joints, entry.role)
        self._state, _ = decide(state, entry)
        record = entry_record(entry, command_form(command), self._state)
        self.journal.append(record.kind, record.body, record.files)


def measure_session(writer: SessionWriter, count: int, others: OtherSteps) -> Costs:
    """Processor times of a session with `count` entries.

    Args:
        writer: of the session, which has fewer.
        count: entries.
        others: measures more.
    """
    writer.write(count)
    journal, cell = writer.journal, cell_of(writer.journal)
    counted = statistics(journal.entries())
    with tempfile.TemporaryDirectory(prefix="workbench-scale-") as folder:
        place = Path(folder)
        viewed, memory = seconds_and_megabytes(lambda: History(journal))
        costs = {
            "open, ms": MS * processor_seconds(lambda: Journal(journal.folder).close()),
            "verify, s": processor_seconds(journal.verify),
            "list its entries, s": processor_seconds(lambda: list_session(journal)),
            "statistics, s": processor_seconds(lambda: statistics(journal.entries())),
            "statistics as CSV, ms": MS * processor_seconds(lambda: csv_text(counted)),
            "replay the states, s": processor_seconds(
                lambda: deque(replay(journal, cell), maxlen=0)
            ),
            "open to view, s": viewed,
            "open to view, MB of memory": memory,
            "export, s": processor_seconds(
                lambda: export_session(journal, place / "session.zip", None)
            ),
            **others(journal, counted, place),
        }
    appended = processor_seconds(lambda: writer.write(journal.count + APPENDED))
    return {**costs, "one more entry, ms": MS * appended / APPENDED}
