"""A process that continues a session and runs cycles against a controller until it is killed.

`python killed_cycles.py` reads lines `folder port state_port` and forks for each, so that
nothing is imported again; it answers with the process' id, and with what the process has done:
the number of each entry once the bench says that it is done.  An empty line: it is gone.
"""

import dataclasses
import os
import sys
import threading
import time
from pathlib import Path

from patient import PATIENT
from samples import Samples, made_cell
from waiting import PATIENCE

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.drop_back import ConfirmHandsEmpty
from workbench.app.core.effects import Send, StartJob
from workbench.app.core.hands import arms_that_may_hold
from workbench.app.core.state import Phase
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.live import Live
from workbench.app.runtime.robot_link import LinkRunner
from workbench.journal.journal import Journal
from workbench.plugins.robot_link import controller_by


class QuickMachines:
    """The real link to the robot; jobs bring their results from a thread, without a worker."""

    def __init__(self, cell, do, now):
        self.live = Live()
        self._samples, self._do = Samples(cell), do
        self._robot = LinkRunner(cell, do, now, lambda **changes: None, patience=PATIENT)

    def run(self, effect):
        if isinstance(effect, StartJob):
            threading.Thread(target=self._job, args=(effect,)).start()
        elif isinstance(effect, Send):
            self._robot.send(effect.plan, effect.approval)

    def _job(self, job):
        made = {
            "scan": lambda: self._samples.scan(job.number, points=3000),
            "localize": self._samples.detections,
            "plan": lambda: self._samples.planned(job.arguments["scan_digest"]),
        }
        self._do(JobEnded(job.number, made[job.name]()), "worker")

    def close(self):
        self._robot.close()


def next_command(state):
    digest = state.plan.digest if state.plan is not None else ""
    if state.phase is Phase.PLANNED and arms_that_may_hold(state):
        return ConfirmHandsEmpty()
    return {
        Phase.IDLE: TakeScan(),
        Phase.SCANNED: FindParts(),
        Phase.LOCALIZED: MakePlan(),
        Phase.PLANNED: Approve(digest) if state.watched else WatchPlan(digest),
        Phase.APPROVED: SendPlan(digest),
        Phase.DONE: TakeScan(),
        Phase.FAULT: AcknowledgeFault(),
    }[state.phase]


def run(folder: str, port: str, state_port: str) -> None:
    cell = dataclasses.replace(
        made_cell(), controller=controller_by("abb-socket", "127.0.0.1", int(port), int(state_port))
    )
    bench = Bench(cell, Journal(Path(folder)), effects=QuickMachines)
    # Told only once it is done: what is read here must be on the disk.
    os.write(1, f"{bench.state.number}\n".encode())
    bench.subscribe(lambda old, new: os.write(1, f"{new.number}\n".encode()))
    while True:
        state = bench.wait(lambda s: s.job is None and s.phase is not Phase.SENDING, PATIENCE)
        bench.do(next_command(state), "ada")
        time.sleep(0)


def main() -> None:
    os.write(1, b"ready\n")
    for line in sys.stdin:
        child = os.fork()
        if child == 0:
            try:
                run(*line.split())
            finally:
                os._exit(1)
        os.write(1, f"pid {child}\n".encode())
        os.waitpid(child, 0)
        os.write(1, b"\n")


if __name__ == "__main__":
    main()
