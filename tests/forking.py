"""Worker processes forked from one that has imported what they do, for tests of something else.

A worker that starts as it does for people imports for two seconds of a processor.  Here one
process does it for all workers of a run; it has a single thread, so forking it is safe.  They
have its environment, which is that of the test that came first.
"""

import multiprocessing
from types import SimpleNamespace

import pytest

from workbench.app.runtime import jobs


def fork_workers(monkeypatch: pytest.MonkeyPatch) -> None:
    """From now on the workers of benches come from that process, which ends with this one."""
    context = multiprocessing.get_context("forkserver")
    context.set_forkserver_preload([jobs.WORK])
    forking = SimpleNamespace(Pipe=multiprocessing.Pipe, get_context=lambda method: context)
    monkeypatch.setattr(jobs, "multiprocessing", forking)
