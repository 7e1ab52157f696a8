"""The next cycle beside the motion of this one: real scans, searches and plans, and real TCP."""

import functools
import json
from dataclasses import replace

import numpy as np
import pytest
from idle import done
from patient import PATIENT
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.state import Phase
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.statistics.statistics import statistics
from workbench.extras.evidence.steps import approval_problems, step_problems
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.perception.simulation.piles import drop_parts
from workbench.web.api.forms import state_form

CRAWL = 0.002
"""Times real time: nothing ends while a test looks."""

NEXT = GoOn(TakeScan(11, 2), FindParts(11), MakePlan("right", seed=11))


@pytest.fixture(scope="module")
def cell():
    found = read_cell("yumi")
    return replace(found, scanner=replace(found.scanner, while_moving=True))


@pytest.fixture
def bench(cell, controller, tmp_path):
    """Makes a bench with a plan of its own making approved, and a controller for it."""
    benches = []

    def make(faults=(), speed=1.0):
        robot = controller(speed, cell, faults)
        address = replace(cell.controller, port=robot.port, state_port=robot.state_port)
        there = replace(cell, controller=address)
        effects = functools.partial(EffectRunner, patience=PATIENT)
        made = Bench(there, Journal(tmp_path / "session"), effects=effects)
        benches.append(made)
        pile = drop_parts([cell.parts[0]] * 2, cell.bin, seed=3)
        made.do(UseDetections(pile), "ada")
        made.do(MakePlan("right", seed=3), "ada")
        done(made)
        assert made.state.phase is Phase.PLANNED, made.state.message
        release(made)
        return made, robot

    yield make
    for one in benches:
        one.close()


def release(made):
    digest = made.state.plan.digest
    made.do(WatchPlan(digest), "ada")
    # What is reported may be older than the end of the motion before.
    wait_until(lambda: stands_at_start(made))
    made.do(Approve(digest), "ada")


def stands_at_start(made):
    reported = made.live.joints
    starts = [
        (made.state.cell.arm(one.arm).joints, one.legs[0].q[0]) for one in made.state.plan.arms
    ]
    return reported and all(
        np.allclose([reported[joint] for joint in joints], q, atol=1e-3) for joints, q in starts
    )


def crawling(made, robot):
    """Send, go on at once, and have the robot crawl from where the scanner sees past it."""
    made.do(SendPlan(made.state.plan.digest), "ada")
    made.do(NEXT, "ada")
    assert made.state.ahead.wanted.sees_from == 5, "the hand brings the part to its place"
    state = made.wait(lambda state: state.job is not None, PATIENCE)
    robot._body.speed = CRAWL
    assert (state.job.name, state.phase) == ("scan", Phase.SENDING)
    return state.plan.digest


def end_of(made):
    return made.wait(lambda state: state.phase is not Phase.SENDING, PATIENCE)


def kinds(made):
    return [row.kind for row in made.entries()]


def test_the_next_plan_waits_when_the_motion_ends_and_is_sent(bench, cell):
    made, robot = bench()
    first = crawling(made, robot)
    state = made.wait(lambda state: state.ahead and len(state.ahead.brought) == 3, PATIENCE)
    assert (state.phase, state.plan.digest, state.job) == (Phase.SENDING, first, None)
    assert LinkEnded.__name__ not in kinds(made), "all of it is done before the motion has ended"
    told = state_form(state, made.live)
    assert told["ahead"] == ["scan", "localize", "plan"] and told["plan"] == first
    robot._body.speed = 100.0
    state = end_of(made)
    assert (state.phase, state.ahead) == (Phase.PLANNED, None), state.message
    assert state.plan.digest != first and state.proof.holds
    assert state.plan.scan_digest == state.scan.digest == state.scene_digest
    second = state.plan.digest
    release(made)
    made.do(SendPlan(second), "ada")
    state = end_of(made)
    assert (state.phase, state.plan.digest, state.fault) == (Phase.DONE, second, "")
    entries = [(row.number, row.kind, json.loads(row.body)) for row in made.entries()]
    assert list(approval_problems(entries)) == list(step_problems(entries)) == []
    counted = statistics(made.entries())
    one, other = counted.cycles
    assert one.end == other.end == "done"
    assert [pick.result for cycle in counted.cycles for pick in cycle.picks] == ["picked"] * 2
    assert set(other.seconds) == {"scan", "find parts", "plan", "approve", "send"}
    assert one.until <= other.at
    folder = made.folder
    made.close()
    *_, (_, last) = replay(Journal(folder), replace(cell, controller=made.cell.controller))
    assert (last.plan.digest, last.phase) == (second, Phase.DONE)


def test_a_robot_that_is_quicker_than_the_scanner_is_waited_for_by_nobody(bench):
    made, _ = bench(speed=200.0)
    first = made.state.plan.digest
    made.do(SendPlan(first), "ada")
    made.do(NEXT, "ada")
    # The robot is done in a fraction of a second, the search takes longer.
    assert end_of(made).phase is not Phase.FAULT
    state = done(made)
    while state.phase is not Phase.PLANNED:
        state = made.wait(lambda state: state.phase is Phase.PLANNED, PATIENCE)
    assert state.plan.digest != first and state.plan.scan_digest == state.scan.digest
    assert kinds(made).count("LinkEnded") == 1


def test_a_stop_in_the_middle_leaves_nothing_of_it(bench):
    made, robot = bench()
    first = crawling(made, robot)
    made.do(Stop(), "bob")
    state = end_of(made)
    assert (state.phase, state.job, state.ahead) == (Phase.FAULT, None, None)
    assert state.plan.digest == first
    assert kinds(made).count("SendPlan") == 1


@pytest.mark.parametrize(
    ("fault", "phase"), [("emergency-stop:6", Phase.FAULT), ("empty-hand", Phase.DONE)]
)
def test_a_fault_or_a_lost_part_throws_it_away(bench, fault, phase):
    made, robot = bench((fault,))
    first = crawling(made, robot)
    made.wait(lambda state: not state.ahead or len(state.ahead.brought) == 3, PATIENCE)
    robot._body.speed = 100.0
    state = end_of(made)
    assert (state.phase, state.job, state.ahead) == (phase, None, None)
    assert state.plan.digest == first
    assert "the next cycle was not prepared" in str(state.message) or phase is Phase.FAULT
