"""A task that takes long is cancelled by who watches it."""

import os
import signal
from multiprocessing import active_children

from workbench.app.core.state import Phase


def test_a_task_can_be_cancelled(screen, bench, wait):
    def workers():
        return [one for one in active_children() if one.name == "workbench worker"]

    # It does not get done before somebody has pressed.
    wait(workers, "the worker")
    os.kill(workers()[0].pid, signal.SIGSTOP)
    screen.press("Scan")
    wait(lambda: bench.state.job is not None, "the task")
    screen.press("Cancel task")
    wait(lambda: bench.state.job is None, "the end of the task")
    assert bench.state.phase is Phase.IDLE
    screen.wait_for("cancelled by")
