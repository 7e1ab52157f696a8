"""A row of plans over real TCP: plan after plan, until all is done or the first thing is odd."""

import json
import subprocess
import sys
import time
import zipfile
from dataclasses import replace

import numpy as np
import pytest
from idle import Idle
from waiting import PATIENCE, wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan, Stop
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.state import Phase
from workbench.app.picking.row import plan_row
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.statistics.statistics import statistics
from workbench.extras.evidence.bundle import write_bundle
from workbench.extras.evidence.steps import approval_problems, step_problems
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.derived.row_parts import parts_taken
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.plugins.robot_link import spoken_to_by


@pytest.fixture(scope="module")
def cell():
    """Parts are taken away at once, and 10 mm are between those of one heap."""
    found = spoken_to_by(read_cell("tx2_90"), "abb-socket/2")
    arms = tuple(replace(arm, passes_parts_on=True) for arm in found.arms)
    return replace(found, arms=arms, policy=replace(found.policy, pair_gap=0.01, picks=3))


@pytest.fixture(scope="module")
def planned(cell):
    """Three parts, each taken by a plan of its own."""
    height = float(np.ptp(cell.parts[0].mesh.points[:, 2])) / 2 + 0.0005
    places = ((-0.08, -0.05), (0.0, 0.05), (0.08, -0.05))
    T = cell.bin.T_world_bin
    parts = tuple(Detection("puck", T * pose_from_rpy((x, y, height)), 0.9) for x, y in places)
    result = plan_row(cell, parts, digest_of(parts), picks=3)
    assert len(result.plans) == 3
    return parts, result


@pytest.fixture
def bench(cell, planned, controller, machines, tmp_path):
    """Makes a bench with the row approved, and a simulated controller that does so at a speed."""
    benches = []

    def make(speed=200.0, faults=()):
        robot = controller(speed, cell, faults)
        parts, result = planned
        address = replace(cell.controller, port=robot.port, state_port=robot.state_port)
        there = replace(cell, controller=address)
        folder = tmp_path / "session"
        first = Bench(there, Journal(folder), effects=Idle)
        first.do(UseDetections(parts), "ada")
        number = first.do(MakePlan(), "ada").number
        first.do(JobEnded(number, result), "worker")
        first.close()
        made = Bench(there, Journal(folder, patience=0.1), effects=machines)
        benches.append(made)
        plan, *row = (one.digest for one in result.plans)
        made.do(WatchPlan(plan, row=tuple(row)), "ada")
        wait_until(lambda: made.live.joints)
        made.do(Approve(plan, row=tuple(row)), "ada")
        return made, robot

    yield make
    for one in benches:
        one.close()


def rows_of(bench):
    return list(bench.entries())


def told(bench):
    return [(row.number, row.kind, json.loads(row.body)) for row in rows_of(bench)]


def test_a_row_goes_out_plan_after_plan_and_is_on_record(bench, cell, planned):
    made, _ = bench()
    _, result = planned
    made.do(SendPlan(result.plan.digest), "ada")
    state = made.wait(lambda state: state.phase in (Phase.DONE, Phase.FAULT), PATIENCE)
    assert (state.phase, state.fault) == (Phase.DONE, "")
    assert state.parts_placed == 3
    taken = {number for plan in result.plans for number in parts_taken(result.plan, plan)}
    assert {one.detection for one in state.outcomes if one.is_picked} == taken == {0, 1, 2}
    entries = told(made)
    ends = [body for _, kind, body in entries if kind == "LinkEnded"]
    assert [body["after"]["phase"] for body in ends] == ["sending", "sending", "done"]
    assert all(body["joints"] for body in ends[:2]), "where the robot stood is on record"
    counted = statistics(rows_of(made))
    (cycle,) = counted.cycles
    assert [(pick.detection, pick.result) for pick in cycle.picks] == [
        (number, "picked") for plan in result.plans for number in parts_taken(result.plan, plan)
    ]
    assert counted.picked == 3
    assert list(approval_problems(entries)) == list(step_problems(entries)) == []
    with pytest.raises(CommandRefused):
        made.do(SendPlan(result.plan.digest), "ada")
    folder = made.folder
    made.close()
    journal = Journal(folder)
    *_, (_, last) = replay(journal, replace(cell, controller=made.cell.controller))
    assert [plan.digest for plan in last.plans] == [plan.digest for plan in result.plans]
    write_bundle(journal, folder / "bundle.zip", time.time())
    journal.close()
    with zipfile.ZipFile(folder / "bundle.zip") as archive:
        archive.extract("verify.py", folder)
        report = archive.read("report.html").decode()
        certified = {name for name in archive.namelist() if name.startswith("certificates/")}
    assert {name[-17:-5] for name in certified} == {plan.digest[:12] for plan in result.plans}
    checked = subprocess.run(
        [sys.executable, "-I", folder / "verify.py", folder / "bundle.zip"],
        capture_output=True,
        text=True,
        check=False,
    )
    assert checked.returncode == 2, checked.stdout
    assert "nothing shows a change" in checked.stdout
    for number in (1, 2, 3):
        assert f"Sending {number}" in report and f"plan {number} of 3 by one approval" in report


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"plan_digest": "0" * 64}, "another plan follow than the one approved"),
        ({"first": "0" * 64}, "by another approval than the one given"),
        ({"actor": "eve"}, "an approval that was changed"),
        ({"row": []}, "another plan follow than the one approved"),
    ],
)
def test_evidence_of_a_row_that_was_let_out_otherwise_is_found(bench, planned, change, said):
    made, _ = bench()
    made.do(SendPlan(planned[1].plan.digest), "ada")
    made.wait(lambda state: state.phase is Phase.DONE, PATIENCE)
    entries = told(made)
    place = next(n for n, (_, kind, _) in enumerate(entries) if kind == "LinkEnded")
    number, kind, body = entries[place]
    entries[place] = (number, kind, {**body, "approval": {**body["approval"], **change}})
    assert said in next(approval_problems(entries))


def test_a_stop_in_the_second_plan_ends_the_row(bench, planned, monkeypatch):
    made, robot = bench()
    runner = made._effects._robot
    see = runner._await_start_of

    def slow_down(plan):
        see(plan)
        robot._body.speed = 0.01

    monkeypatch.setattr(runner, "_await_start_of", slow_down)
    made.do(SendPlan(planned[1].plan.digest), "ada")
    wait_until(lambda: len(made.state.sent_before) == 1 and made.state.receipts)
    made.do(Stop(), "bob")
    state = made.wait(lambda state: state.phase in (Phase.DONE, Phase.FAULT), PATIENCE)
    assert state.phase is Phase.FAULT
    assert state.row == () and "after 2 of 3 plans" in str(state.row_ends)
    for plan in planned[1].plans:
        with pytest.raises(CommandRefused):
            made.do(SendPlan(plan.digest), "ada")


def test_a_stop_between_two_plans_lets_no_other_begin(bench, planned, monkeypatch):
    made, _ = bench()
    runner = made._effects._robot
    see, waits = runner._await_start_of, []

    def slowly(plan):
        see(plan)
        waits.append(plan)
        wait_until(lambda: made.state.stopped_by)

    monkeypatch.setattr(runner, "_await_start_of", slowly)
    made.do(SendPlan(planned[1].plan.digest), "ada")
    wait_until(lambda: waits)
    made.do(Stop(), "bob")
    state = made.wait(lambda state: state.phase in (Phase.DONE, Phase.FAULT), PATIENCE)
    assert state.phase is Phase.DONE and "stopped by bob" in str(state.message)
    sent = [row.kind for row in rows_of(made)]
    assert sent.count("LinkEnded") == 1
    time.sleep(0.2)
    assert [row.kind for row in rows_of(made)] == sent


def test_who_ends_the_workbench_between_two_plans_lets_no_other_begin(bench, planned, monkeypatch):
    made, _ = bench()
    runner = made._effects._robot
    see, waits = runner._await_start_of, []

    def slowly(plan):
        see(plan)
        waits.append(plan)
        wait_until(lambda: runner._stopped.is_set())

    monkeypatch.setattr(runner, "_await_start_of", slowly)
    made.do(SendPlan(planned[1].plan.digest), "ada")
    wait_until(lambda: waits)
    made.stop_sending()
    state = made.wait(lambda state: state.phase in (Phase.DONE, Phase.FAULT), PATIENCE)
    assert state.phase is Phase.FAULT
    assert "stopped before anything of this plan was sent" in str(state.fault)
    ends = [row for row in rows_of(made) if row.kind == LinkEnded.__name__]
    sent = [row for row in rows_of(made) if row.kind == "Sent" and row.number > ends[0].number]
    assert sent == [], "nothing of the second plan has gone out"


def test_a_pick_that_fails_ends_the_row(bench, planned):
    made, _ = bench(faults=("empty-hand",))
    made.do(SendPlan(planned[1].plan.digest), "ada")
    state = made.wait(lambda state: state.phase in (Phase.DONE, Phase.FAULT), PATIENCE)
    assert state.phase is Phase.DONE
    assert state.row == () and "after 1 of 3 plans" in str(state.row_ends)
