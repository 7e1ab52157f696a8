"""Benches with a real worker process, and simulated controllers."""

import functools
from pathlib import Path

import pytest
from idle import Idle
from job_listener import Listener, workers
from patient import PATIENT, in_threads

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.jobs import Jobs
from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.journal.journal import Journal
from workbench.plugins.robot_link import Simulation

HERE = Path(__file__).parents[1]


@pytest.fixture
def listener():
    return Listener()


@pytest.fixture
def jobs(cell, listener, monkeypatch):
    monkeypatch.syspath_prepend(HERE)
    running = Jobs(cell, listener.ended, listener.progressed, module="tiny_work")
    yield running
    running.close()
    assert not workers()


@pytest.fixture
def machines(monkeypatch):
    monkeypatch.syspath_prepend(HERE)
    return functools.partial(EffectRunner, module="tiny_work", patience=PATIENT)


@pytest.fixture
def bench_at(tmp_path, machines, samples):
    """Makes a bench with an approved plan and real machines, for a cell."""
    benches = []

    def make(cell):
        folder = tmp_path / "session"
        first = Bench(cell, Journal(folder), effects=Idle)
        scan = samples.scan()
        first.do(UseScan(scan), "ada")
        first.do(UseDetections(samples.detections()), "ada")
        state = first.do(MakePlan(), "ada")
        result = samples.planned(state.scene_digest)
        first.do(JobEnded(state.number, result), "worker")
        first.close()
        # Continued with machines, as a session is after a restart.
        bench = Bench(cell, Journal(folder, patience=0.1), effects=machines)
        benches.append(bench)
        bench.do(WatchPlan(result.plan.digest), "ada")
        bench.do(Approve(result.plan.digest), "ada")
        return bench

    yield make
    for bench in benches:
        bench.close()


@pytest.fixture
def controller(cell):
    """Starts simulated controllers; they end with the test."""
    with in_threads() as started:

        def make(speed, of=cell, faults=()):
            made = SimulatedController(of, Simulation(speed=speed, faults=faults), patience=PATIENT)
            return started(made)

        yield make


@pytest.fixture
def bench(cell, tmp_path, machines):
    made = Bench(cell, Journal(tmp_path / "session"), effects=machines)
    yield made
    made.close()
