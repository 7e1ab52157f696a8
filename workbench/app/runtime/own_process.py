"""A job in a process that is started for it: it takes long, and may be given up at any moment."""

from collections.abc import Mapping
from contextlib import suppress
from queue import Empty, Queue
from threading import Event
from typing import Any

from workbench.app.runtime.jobs import Jobs
from workbench.model.cell import Cell
from workbench.plugins.progress import Report

NUMBER = 1
"""Of the only job."""

NOTHING_YET: Any = object()
"""Stands for a result that has not come; a job may end with any value, None included."""

POLL_EVERY = 0.2
"""[s] How soon it is noticed that somebody gives up."""


def in_own_process(
    module: str,
    name: str,
    cell: Cell,
    arguments: Mapping[str, Any],
    report: Report,
    given_up: Event,
) -> Any:
    """The result of a job; until it has come, whoever asks waits in this thread.

    Args:
        module: its `JOBS` has the job.
        name: of the job.
        cell: that it works on.
        arguments: of the job.
        report: called from another thread with the progress.
        given_up: set by who does not want to wait any longer.

    Raises:
        WorkbenchError: what ended the job, or the process has ended.
        JobCancelled: it was given up.
    """
    ends: Queue[Any] = Queue()
    jobs = Jobs(
        cell,
        lambda _, result: ends.put(result),
        lambda _, done, note: report(done, note),
        module=module,
    )
    try:
        jobs.start(NUMBER, name, arguments)
        is_cancelled, result = False, NOTHING_YET
        while result is NOTHING_YET:
            if given_up.is_set() and not is_cancelled:
                jobs.cancel(NUMBER)
                is_cancelled = True
            with suppress(Empty):
                result = ends.get(timeout=POLL_EVERY)
    finally:
        jobs.close()
    if isinstance(result, Exception):
        raise result
    return result
