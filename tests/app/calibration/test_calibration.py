"""Observations of the plate in the state: taken, left out, kept, recorded, computed again."""

from dataclasses import replace

import numpy as np
import pytest
from idle import Noting

from workbench.app.calibration.ball_plate import simulated_sight, suggested_poses
from workbench.app.calibration.calibration import (
    bin_corners,
    compute_calibration,
    corner_errors,
    moved_by,
    with_calibration,
)
from workbench.app.core.cell.changes import ChangeCell, UndoCell
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.scanning import SightPlate, UseObservations
from workbench.app.core.people import WORKER
from workbench.app.core.value_checks import MOST_OBSERVATIONS
from workbench.app.review.recompute import recompute_tasks
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.work import JOBS
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.calibration import BallPlate
from workbench.model.errors import CommandRefused, InputError
from workbench.model.geometry import pose_from_rpy
from workbench.perception.calibration.balls import sight_plate

PLATE = BallPlate()
WRONG = pose_from_rpy((0.012, -0.008, 0.015), np.deg2rad((1.2, -0.8, 1.5)))


@pytest.fixture(scope="module")
def yumi():
    return read_cell("yumi")


@pytest.fixture(scope="module")
def poses(yumi):
    return suggested_poses(yumi, yumi.arms[0], PLATE, 5, seed=0)


@pytest.fixture(scope="module")
def observations(yumi, poses):
    arm = yumi.arms[0]
    return tuple(
        sight_plate(
            simulated_sight(yumi, arm, q, PLATE, seed=k), PLATE, f"pose {k + 1}", arm.name, q
        )
        for k, q in enumerate(poses)
    )


@pytest.fixture
def bench(yumi, tmp_path):
    bench = Bench(yumi, Journal(tmp_path / "session"), effects=Noting)
    yield bench
    bench.close()


def test_the_suggested_poses_are_seen_and_different(yumi, poses):
    assert len(poses) == 5
    lower, upper, _ = yumi.robot.limits(yumi.arms[0].joints)
    for q in poses:
        assert np.all((q >= lower) & (q <= upper))
    assert np.abs(poses[0] - poses[1]).max() > 0.1


@pytest.mark.extensive
def test_a_scanner_that_hangs_elsewhere_is_found(yumi, observations):
    mount = replace(yumi.scanner, T_world_scanner=yumi.scanner.T_world_scanner * WRONG)
    wrong = replace(yumi, scanner=mount)
    found = compute_calibration(wrong, observations)
    off = yumi.scanner.T_world_scanner.actInv(found.T_world_scanner)
    assert np.linalg.norm(off.translation) < 0.0008
    distance, angle, shift = moved_by(wrong, found)
    assert distance == pytest.approx(np.linalg.norm(WRONG.translation), abs=0.001)
    assert angle == pytest.approx(np.deg2rad(2.08), abs=0.002)
    assert 0.02 < shift < 0.05
    after = with_calibration(wrong, found, 1_000.4, "ada")
    assert (after.scanner.calibration.by, after.scanner.calibration.at) == ("ada", 1000.0)
    assert moved_by(after, found)[0] < 1e-12
    assert np.array_equal(after.scanner.calibration.covariance, found.covariance)
    said = corner_errors(after, found.covariance)
    assert said == corner_errors(wrong, found.covariance, found.T_world_scanner)
    assert list(said) == list(bin_corners(yumi.bin)) and len(said) == 8
    shift = found.T_world_scanner * yumi.scanner.T_world_scanner.inverse()
    for name, corner in bin_corners(yumi.bin).items():
        assert np.linalg.norm(shift.act(corner) - corner) < 2 * said[name] < 0.004
    assert "floor front left" in said and "rim back right" in said


def test_observations_of_two_plates_or_of_none_are_refused(yumi, observations):
    with pytest.raises(InputError, match="no pose was scanned"):
        compute_calibration(yumi, ())
    other = replace(observations[1], plate=BallPlate(0.015, np.array([0.09, 0.1, 0.12])))
    with pytest.raises(InputError, match="of another plate"):
        compute_calibration(yumi, (observations[0], other, *observations[2:]))


def test_a_pose_is_scanned_recorded_and_computed_again(bench, poses, tmp_path):
    state = bench.do(SightPlate("right", poses[0], PLATE, seed=3), "ada")
    (job,) = bench._effects.jobs
    assert (state.job.name, job.arguments["name"]) == ("sight", "pose 1")
    seen = JOBS["sight"](bench.cell, job.arguments, lambda done, note: None, lambda: False)
    state = bench.do(JobEnded(state.number, seen), WORKER)
    assert [one.name for one in state.observations] == ["pose 1"] and "pose 1" in str(state.message)
    with pytest.raises(CommandRefused, match="stands as in pose 1, so another scan adds nothing"):
        bench.do(SightPlate("right", poses[0], PLATE), "ada")
    left = replace(state.observations[0], is_used=False)
    state = bench.do(UseObservations((left,), "pose 1 is left out"), "ada")
    assert not state.observations[0].is_used
    bench.close()
    journal = Journal(tmp_path / "session")
    assert [(one.task, one.says) for one in recompute_tasks(journal)] == [("sight", "equal")]
    again = Bench(bench.cell, journal, effects=Noting)
    assert np.array_equal(again.state.observations[0].balls, seen.balls)
    again.close()


def test_poses_stay_when_the_cell_changes_and_a_calibration_is_undone(bench, observations):
    bench.do(UseObservations(observations, "from elsewhere"), "ada")
    found = compute_calibration(bench.state.cell, observations)
    before = bench.state.cell.digest
    state = bench.do(ChangeCell(with_calibration(bench.cell, found, 5.0, "ada"), "calib"), "ada")
    assert state.cell.scanner.calibration is not None and len(state.observations) == 5
    state = bench.do(UndoCell(), "ada")
    assert state.cell.digest == before and state.cell.scanner.calibration is None


def test_so_many_poses_are_taken_and_no_more(bench, poses, observations):
    elsewhere = observations[0].q - 0.05
    many = tuple(
        replace(observations[0], name=f"pose {k}", q=elsewhere) for k in range(MOST_OBSERVATIONS)
    )
    bench.do(UseObservations(many, "from elsewhere"), "ada")
    with pytest.raises(CommandRefused, match="remove one of them first"):
        bench.do(SightPlate("right", poses[0], PLATE), "ada")
    bench.do(UseObservations(many[1:], "pose 0 is removed"), "ada")
    assert bench.do(SightPlate("right", poses[0], PLATE), "ada").job is not None


@pytest.mark.parametrize(
    "command",
    [
        SightPlate("middle", np.zeros(7), PLATE),
        SightPlate("right", np.zeros(3), PLATE),
        SightPlate("right", np.full(7, 100.0), PLATE),
        SightPlate("right", np.full(7, np.nan), PLATE),
        SightPlate("right", np.zeros(7), PLATE, seed=-1),
    ],
)
def test_what_no_arm_can_do_is_refused(bench, command):
    with pytest.raises(CommandRefused):
        bench.do(command, "ada")
    assert bench.state.job is None
