"""A grip that closes on nothing, over real TCP: the next plan is made in the same scan."""

import functools
import json
from dataclasses import replace

import numpy as np
import pytest
from idle import Idle
from patient import PATIENT
from waiting import PATIENCE, wait_until

from workbench.app.core.after_a_miss import is_rest_known
from workbench.app.core.cycle.ahead import GoOn
from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import UseScan
from workbench.app.core.cycle.sending import SendPlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.core.state import Phase
from workbench.app.picking.proving import prove
from workbench.app.picking.row import plan_row
from workbench.app.records.replay import replay
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.statistics.statistics import statistics
from workbench.extras.evidence.steps import approval_problems, step_problems
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.robot_link import spoken_to_by
from workbench.proof.claims.moved import room_of_moved


@pytest.fixture(scope="module")
def cell():
    """Parts are taken away at once, and the next cycle goes on in the scan."""
    found = spoken_to_by(read_cell("tx2_90"), "abb-socket/2")
    arms = tuple(replace(arm, passes_parts_on=True) for arm in found.arms)
    policy = replace(found.policy, pair_gap=0.01, retry_without_scan=True)
    return replace(found, arms=arms, policy=policy)


@pytest.fixture
def bench(cell, controller, tmp_path):
    """After a scan of three pucks, with a plan for one of them approved; the hand will miss it."""
    height = float(np.ptp(cell.parts[0].mesh.points[:, 2])) / 2 + 0.0005
    places = ((-0.1, -0.15), (0.1, -0.15), (0.0, 0.15))
    T = cell.bin.T_world_bin
    parts = tuple(Detection("puck", T * pose_from_rpy((x, y, height)), 0.9) for x, y in places)
    scan = synthesize(cell, parts, seed=1)
    robot = controller(200.0, cell, ("empty-hand:1",))
    there = replace(
        cell,
        controller=replace(cell.controller, port=robot.port, state_port=robot.state_port),
    )
    first = Bench(there, Journal(tmp_path / "session"), effects=Idle)
    first.do(UseScan(scan), "ada")
    first.do(JobEnded(first.do(FindParts(), "ada").number, parts), "worker")
    result = plan_row(cell, parts, scan.digest)
    first.do(JobEnded(first.do(MakePlan(), "ada").number, result), "worker")
    first.close()
    effects = functools.partial(EffectRunner, patience=PATIENT)
    made = Bench(there, Journal(tmp_path / "session", patience=0.1), effects=effects)
    release(made)
    yield made
    made.close()


def release(made):
    digest = made.state.plan.digest
    made.do(WatchPlan(digest), "ada")
    wait_until(lambda: made.live.joints)
    made.do(Approve(digest), "ada")


def sent(made):
    made.do(SendPlan(made.state.plan.digest), "ada")
    return made.wait(lambda state: state.phase is not Phase.SENDING, PATIENCE)


def test_the_next_part_is_taken_without_a_scan_and_around_the_missed_one(bench, cell):
    missed = bench.state.plan.detections[bench.state.plan.arms[0].detection]
    scan = bench.state.scan.digest
    state = sent(bench)
    assert (state.phase, state.parts_placed) == (Phase.DONE, 0)
    assert [part.is_missed for part in state.part_reports] == [True]
    assert is_rest_known(state)
    bench.do(GoOn(), "ada")
    state = bench.wait(lambda state: state.job is None, PATIENCE)
    assert state.phase is Phase.PLANNED, state.message
    plan = state.plan
    assert (plan.scan_digest, state.scan.digest) == (scan, scan)
    assert len(plan.detections) == 2
    room = room_of_moved(cell, missed)
    assert any(
        box.T_world_box.isApprox(room.T_world_box) and np.allclose(box.size, room.size)
        for box in plan.obstacles
    )
    assert state.proof.holds and state.approval is None
    assert prove(bench.state.cell, plan, scan=state.scan).holds
    assert not any(row.kind in ("TakeScan", "FindParts") for row in list(bench.entries())[-6:])
    release(bench)
    state = sent(bench)
    assert (state.phase, state.parts_placed) == (Phase.DONE, 1)
    assert not is_rest_known(state)
    entries = [(row.number, row.kind, json.loads(row.body)) for row in bench.entries()]
    assert list(approval_problems(entries)) == list(step_problems(entries)) == []
    first, second = statistics(bench.entries()).cycles
    assert [cycle.picks[0].result for cycle in (first, second)] == ["failed", "picked"]
    folder = bench.folder
    bench.close()
    *_, (_, last) = replay(Journal(folder), replace(cell, controller=bench.cell.controller))
    assert (last.plan.digest, last.phase) == (plan.digest, Phase.DONE)
