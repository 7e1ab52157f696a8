"""The look at recorded scans in a process of its own: it takes seconds, and can be given up.

Imported by that process as well: its `JOBS` are here.
"""

from collections.abc import Mapping, Sequence
from pathlib import Path
from threading import Event
from typing import Any

from workbench.app.review.scanner_drift import RecordedDrift, recorded_drift
from workbench.app.runtime.own_process import in_own_process
from workbench.app.runtime.worker import JobFunction
from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled
from workbench.model.messages.message import Message
from workbench.plugins.progress import Cancelled, Report


def drift(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> RecordedDrift:
    """What the sessions in `folders` say of the scanner of a cell."""

    def report_or_stop(done: float, note: Message | str) -> None:
        if cancelled():
            raise JobCancelled("the look at recorded scans was given up")
        report(done, note)

    return recorded_drift([Path(folder) for folder in arguments["folders"]], cell, report_or_stop)


JOBS: Mapping[str, JobFunction] = {"drift": drift}


def drift_apart(
    folders: Sequence[Path], cell: Cell, report: Report, given_up: Event
) -> RecordedDrift:
    """See `recorded_drift`; until it has come, whoever asks waits in this thread.

    Args:
        folders: of the sessions.
        cell: as it is now.
        report: called from another thread with the progress.
        given_up: set by who does not want to wait any longer.

    Raises:
        WorkbenchError: the scanner was never calibrated, a folder holds no session, or the process
            has ended.
        JobCancelled: it was given up.
    """
    asked = {"folders": [str(folder) for folder in folders]}
    return in_own_process(__name__, "drift", cell, asked, report, given_up)
