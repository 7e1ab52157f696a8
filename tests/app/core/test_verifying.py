"""Checks of the scanner in the state: scans of balls, touches, what is refused, what stays."""

from dataclasses import replace

import numpy as np
import pytest
from idle import Noting

from workbench.app.calibration.simulated_checks import simulated_place, touching_joints
from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.people import WORKER
from workbench.app.core.verifying import LimitChecks, RecordTouch, RemoveCheck, ScanBalls
from workbench.app.review.recompute import recompute_tasks
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.work import JOBS
from workbench.formats.cells.reading import read_cell
from workbench.gui.calibration.check_views import touches_html, trueness_html
from workbench.journal.journal import Journal
from workbench.model.calibration import BallArtefact, CalibrationRecord
from workbench.model.errors import CommandRefused, InputError
from workbench.model.geometry import pose_from_rpy
from workbench.perception.calibration.touch_test import assess_touches

PLATE = BallArtefact()


@pytest.fixture(scope="module")
def yumi():
    cell = read_cell("yumi")
    record = CalibrationRecord(1.0, "ada", 8, 3e-4, 3e-4, 3e-4, np.eye(6) * 9e-8)
    return replace(cell, scanner=replace(cell.scanner, calibration=record))


@pytest.fixture(scope="module")
def seen(yumi):
    """The result of the task, without a bench."""
    wanted = {"name": "scan 1", "artefact": PLATE, "seed": 3, "joints": {}}
    return JOBS["balls"](yumi, wanted, lambda done, note: None, lambda: False)


@pytest.fixture(scope="module")
def qs(yumi):
    T, arm = simulated_place(yumi, PLATE, 3), yumi.arms[0]
    return [
        touching_joints(yumi, arm, T.act(centre), PLATE.radius, 0.0, seed=number)
        for number, centre in enumerate(PLATE.centres)
    ]


@pytest.fixture
def bench(yumi, tmp_path):
    bench = Bench(yumi, Journal(tmp_path / "session"), effects=Noting)
    yield bench
    bench.close()


def scanned(bench, seen):
    state = bench.do(ScanBalls(PLATE, seed=3), "ada")
    (job,) = bench._effects.jobs[-1:]
    assert (state.job.name, job.arguments["name"], job.arguments["seed"]) == ("balls", "scan 1", 3)
    return bench.do(JobEnded(state.number, seen), WORKER)


def test_scans_and_touches_are_recorded_judged_and_computed_again(bench, seen, qs, tmp_path):
    state = scanned(bench, seen)
    assert "scan 1: balls found (1 in all)" in str(state.message)
    assert "scan the balls in 3 places" in trueness_html(state.ball_scans, 3e-4)
    for number, q in enumerate(qs, start=1):
        state = bench.do(RecordTouch("scan 1", "right", q), "ada")
        assert f"touch {number}: ball {number} of scan 1" in str(state.message)
    state = bench.do(LimitChecks(2e-4, 1e-3), "ada")
    assert assess_touches(state.cell, state.ball_scans, state.touches).light == "good"
    assert "limit 1.00 mm" in touches_html(state)
    bench.close()
    journal = Journal(tmp_path / "session")
    assert [(one.task, one.says) for one in recompute_tasks(journal)] == [("balls", "equal")]
    again = Bench(bench.cell, journal, effects=Noting)
    assert [touch.name for touch in again.state.touches] == ["touch 1", "touch 2", "touch 3"]
    assert np.array_equal(again.state.ball_scans[0].balls, seen.balls)
    assert again.state.check_limits == (2e-4, 1e-3)
    again.close()


def test_a_scanner_elsewhere_and_a_wrong_tcp_are_told_apart(bench, yumi, seen, qs):
    state = scanned(bench, seen)
    for q in qs:
        state = bench.do(RecordTouch("scan 1", "right", q), "ada")

    def says(cell):
        return str(assess_touches(cell, state.ball_scans, state.touches).says)

    assert "agree" in says(yumi)
    T = pose_from_rpy((0.004, 0.0, 0.0), (0.0, 0.0, 0.0))
    mount = replace(yumi.scanner, T_world_scanner=T * yumi.scanner.T_world_scanner)
    said = says(replace(yumi, scanner=mount))
    assert "disagree: 4.0" in said and "common shift: calibrate again" in said
    assert "change from touch" not in said
    arm = yumi.arms[0]
    tool = replace(arm.tool, T_flange_tcp=arm.tool.T_flange_tcp * T)
    said = says(replace(yumi, arms=(replace(arm, tool=tool), *yumi.arms[1:])))
    assert "change from touch to touch: check TCP" in said
    # A tool that was never turned hides its TCP.
    place = simulated_place(yumi, PLATE, 3)
    alike = tuple(
        replace(touch, q=touching_joints(yumi, arm, place.act(ball), PLATE.radius, 0.0, seed=0))
        for touch, ball in zip(state.touches, PLATE.centres, strict=True)
    )
    said = str(assess_touches(replace(yumi, scanner=mount), state.ball_scans, alike).says)
    assert "the tool was hardly turned between touches" in said


def test_too_few_touches_or_touches_on_a_line_say_so(bench, yumi, seen, qs):
    scanned(bench, seen)
    state = bench.do(RecordTouch("scan 1", "right", qs[0]), "ada")
    with pytest.raises(InputError, match="needs 3 touches; there are 1"):
        assess_touches(yumi, state.ball_scans, state.touches)
    bench.do(RecordTouch("scan 1", "right", qs[1]), "ada")
    shifted = qs[1] + np.deg2rad(0.05)
    state = bench.do(RecordTouch("scan 1", "right", shifted), "ada")
    with pytest.raises(InputError, match="lie on one line"):
        assess_touches(yumi, state.ball_scans, state.touches)
    state = bench.do(RecordTouch("scan 1", "right", qs[2]), "ada")
    bare = replace(yumi, scanner=replace(yumi.scanner, calibration=None))
    with pytest.raises(InputError, match="no calibration predicts an error"):
        assess_touches(bare, state.ball_scans, state.touches)
    assert assess_touches(bare, state.ball_scans, state.touches, 0.005).light == "good"


def test_touches_that_say_nothing_are_refused(bench, yumi, seen, qs):
    scanned(bench, seen)
    q = qs[0]
    for command, says in (
        (RecordTouch("scan 9", "right", q), "no scan 'scan 9'"),
        (RecordTouch("scan 1", "middle", q), "middle"),
        (RecordTouch("scan 1", "right", np.full(7, np.nan)), "within the limits"),
        (RecordTouch("scan 1", "right", np.full(7, 100.0)), "within the limits"),
        (RecordTouch("scan 1", "right", q[:3]), "7 joint values"),
        (RecordTouch("scan 1", "right", yumi.arms[0].home), "mm from ball"),
        (RecordTouch("scan 1", "right", q, seat=0.03), "less than that of the ball, 30 mm"),
        (RecordTouch("scan 1", "right", q, seat=-0.001), "less than that of the ball, 30 mm"),
        (RecordTouch("scan 1", "right", q, seat=np.nan), "less than that of the ball, 30 mm"),
    ):
        with pytest.raises(CommandRefused, match=says):
            bench.do(command, "ada")
    bench.do(RecordTouch("scan 1", "right", q), "ada")
    with pytest.raises(CommandRefused, match="those of touch 1 already"):
        bench.do(RecordTouch("scan 1", "right", q), "ada")
    arm = yumi.arms[0]
    tool = replace(arm.tool, T_flange_tcp=pose_from_rpy((0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    bench.do(ChangeCell(replace(yumi, arms=(replace(arm, tool=tool), *yumi.arms[1:])), "bare"), "a")
    with pytest.raises(CommandRefused, match="has no TCP"):
        bench.do(RecordTouch("scan 1", "right", qs[1]), "ada")


@pytest.mark.parametrize(
    "command",
    [
        LimitChecks(0.0),
        LimitChecks(np.nan),
        LimitChecks(1e-3, -1.0),
        LimitChecks(1e-3, np.nan),
        ScanBalls(PLATE, seed=-1),
        RemoveCheck("scan 1"),
    ],
)
def test_so_are_limits_seeds_and_names_that_mean_nothing(bench, command):
    with pytest.raises(CommandRefused):
        bench.do(command, "ada")


def test_touches_go_with_their_scan_and_those_of_another_cell_are_named(bench, yumi, seen, qs):
    scanned(bench, seen)
    state = bench.do(RecordTouch("scan 1", "right", qs[0]), "ada")
    odd = replace(state.touches[0], q=np.zeros(6))
    assert "is of another robot or scanner" in touches_html(replace(state, touches=(odd,)))
    state = bench.do(RemoveCheck("scan 1"), "ada")
    assert (state.ball_scans, state.touches) == ((), ())
