"""Effects that are noted, a clock that stands, and a bench brought to an approved plan."""

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.runtime.live import Live


class Noted:
    """Effects that are noted and not carried out."""

    def __init__(self, cell, do, now):
        self.ran = []
        self.live = Live()
        self.closed = False

    def run(self, effect):
        self.ran.append(effect)

    def close(self):
        self.closed = True


class Clock:
    """Time that passes when the test says so."""

    def __init__(self):
        self.now = 1_000_000.0

    def __call__(self):
        return self.now


def approved(bench, samples):
    """Bring the bench to an approved plan; its digest."""
    scan = samples.scan()
    bench.do(UseScan(scan), "ada")
    bench.do(UseDetections(samples.detections()), "ada")
    state = bench.do(MakePlan(), "ada")
    result = samples.planned(state.scene_digest)
    bench.do(JobEnded(state.number, result), "worker")
    bench.do(WatchPlan(result.plan.digest), "ada")
    bench.do(Approve(result.plan.digest), "ada")
    return result.plan.digest
