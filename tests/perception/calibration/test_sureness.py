"""What a calibration says of itself: covariance, poses predicted by others, errors of points."""

import numpy as np
import pinocchio as pin
import pytest
from held_plates import (
    CENTRES,
    CORNERS,
    NEAR,
    STANDS,
    H,
    V,
    X,
    Y,
    off_at_corners,
    off_truth,
    scene,
    wrist_scene,
)

from workbench.perception.calibration import sureness
from workbench.perception.calibration.calibrate import PlatePose, calibrate
from workbench.perception.calibration.plate_poses import distances, moved, offsets, slopes
from workbench.perception.calibration.pose_errors import LEVER, error_covariances, rigid_errors
from workbench.perception.calibration.rigid import fitted_motion
from workbench.perception.calibration.sureness import best_fit, point_errors, predicted_offsets

SEEDS = 200
CHI_SQUARE = 16.81
"""99 % of six standard normals have a sum of squares up to this."""


@pytest.mark.extensive
@pytest.mark.parametrize(
    "noise",
    [
        {"ball": 1e-4},
        {"shift": 3e-4},
        {"shift": 3e-4, "turn": np.deg2rad(0.05)},
        {"shift": 1e-4, "turn": np.deg2rad(0.1)},
    ],
    ids=["balls", "shifts", "both", "turns"],
)
def test_the_truth_lies_within_the_covariance_and_corners_within_their_errors(noise):
    """Also where it is the robot that is not exact, so that three balls are off alike."""
    inside, corners = 0, []
    for seed in range(SEEDS):
        fit = best_fit(scene(seed, **noise), NEAR, CENTRES)
        T = fit.answer[0]
        off = off_truth(T)
        inside += off @ np.linalg.solve(fit.covariance, off) < CHI_SQUARE
        corners.append(off_at_corners(T) < point_errors(fit.covariance, T.translation, CORNERS))
    assert 0.97 <= inside / SEEDS <= 1.0
    assert 0.92 <= np.mean(corners) <= 0.99


def test_the_truth_of_a_scanner_on_an_arm_lies_within_the_covariance():
    """Far from the plate the flange turns: that shifts the plate, too."""
    truth, inside, corners = V * H, 0, []
    for seed in range(60):
        poses = wrist_scene(seed, shift=1e-4, turn=np.deg2rad(0.1))
        fit = best_fit(poses, (truth, V.actInv(STANDS)), CENTRES)
        T = fit.answer[0]
        off = off_truth(T, truth)
        inside += off @ np.linalg.solve(fit.covariance, off) < CHI_SQUARE
        far = off_at_corners(T, truth)
        corners.append(far < point_errors(fit.covariance, T.translation, CORNERS))
    assert inside >= 55 and 0.88 <= np.mean(corners) <= 0.995


def test_errors_are_told_apart_by_their_kind():
    poses = wrist_scene(0, count=40, shift=3e-4, turn=np.deg2rad(0.1))
    fit = best_fit(poses, (V * H, V.actInv(STANDS)), CENTRES)
    shift, turn, seen_turned, ball = np.sqrt(fit.variances)
    assert shift == pytest.approx(3e-4, rel=0.35)
    assert turn / LEVER == pytest.approx(np.deg2rad(0.1), rel=0.35)
    assert seen_turned / LEVER < np.deg2rad(0.05)
    assert ball == pytest.approx(5e-5, rel=0.1)


def test_turns_of_the_flange_are_left_out_where_many_poses_predict_each_other_better(monkeypatch):
    few, many = (wrist_scene(0, count=count, turn=np.deg2rad(0.1)) for count in (8, 12))
    start = (V * H, V.actInv(STANDS))
    assert best_fit(many, start, CENTRES).variances[1] > 0.0
    monkeypatch.setattr(sureness, "CLEARLY_BETTER", 10.0)  # as if they did
    assert best_fit(many, start, CENTRES).variances[1] == 0.0
    assert best_fit(few, start, CENTRES).variances[1] > 0.0


def test_slopes_are_those_of_small_motions():
    poses = scene(0)
    found = slopes(poses, (X, Y), CENTRES)
    for k, step in enumerate(np.eye(12) * 1e-6):
        ahead, back = (offsets(poses, moved((X, Y), one), CENTRES) for one in (step, -step))
        assert np.allclose(found[..., k], (ahead - back) / 2e-6, atol=1e-8)


@pytest.mark.parametrize("count", [5, 8, 30])
def test_each_pose_is_predicted_as_by_a_fit_without_it(count):
    """Judged by that fit, of the same weights."""
    poses = scene(3, count=count, shift=2e-4, turn=5e-4)
    fit = best_fit(poses, NEAR, CENTRES)
    for k, said in enumerate(predicted_offsets(poses, fit, CENTRES)):
        rest = [pose for number, pose in enumerate(poses) if number != k]
        answer = refitted(rest, fit)
        distance = distances([poses[k]], answer, CENTRES)[0]
        R, _ = fitted_motion(CENTRES, poses[k].balls)
        turn = (poses[k].T_world_flange.rotation @ answer[1].rotation).T @ answer[0].rotation @ R
        assert said is not None
        assert said[0] == pytest.approx(distance, rel=0.01)
        assert said[1] == pytest.approx(np.linalg.norm(pin.log3(turn)), rel=0.03, abs=2e-6)


def refitted(poses, fit):
    """Least squares weighed by the variances of a fit, by steps along numerical slopes."""
    answer = fit.answer

    def off(step):
        _, seen, to_turns = rigid_errors(poses, moved(answer, step), CENTRES)
        kinds = error_covariances(poses, fit.answer, CENTRES, to_turns)
        roots = np.linalg.cholesky(np.einsum("c,cnij->nij", fit.variances, kinds))
        return np.linalg.solve(roots, seen[..., None]).ravel()

    for _ in range(4):
        rows = np.array([(off(s) - off(-s)) / 2e-6 for s in np.eye(12) * 1e-6]).T
        answer = moved(answer, -np.linalg.lstsq(rows, off(np.zeros(12)), rcond=None)[0])
    return answer


def test_a_pose_without_which_the_mount_is_open_is_predicted_by_nothing():
    """The only one that turns about another axis than the vertical."""
    turns = [(0.0, 0.0, 0.4 * k) for k in range(5)] + [(0.5, 0.0, 0.0)]
    said = predicted_offsets(
        scene(0, turns=turns), best_fit(scene(0, turns=turns), NEAR, CENTRES), CENTRES
    )
    assert [one is None for one in said] == [False] * 5 + [True]
    found = calibrate(scene(0, turns=turns), CENTRES)
    assert found.residuals[-1].predicted is None and found.residuals[-1].light == "warning"
    assert found.predicted_rms is None and found.worst_predicted is not found.residuals[-1]


def test_a_pose_left_out_is_as_far_off_as_the_others_say():
    poses = scene(0)
    poses[2] = PlatePose("pose 3", poses[2].T_world_flange, poses[2].balls, is_used=False)
    found = calibrate(poses, CENTRES)
    said = predicted_offsets(scene(0), best_fit(scene(0), NEAR, CENTRES), CENTRES)[2]
    assert found.residuals[2].predicted[0] == pytest.approx(said[0], rel=0.05)


def test_poses_predicted_by_the_others_are_off_by_more_than_what_is_left_over():
    found = calibrate(scene(1, count=6, shift=3e-4), CENTRES)
    for one in found.residuals:
        assert one.predicted[0] > one.distance
    assert found.predicted_rms[0] > found.rms
    worst = max(one.predicted[0] for one in found.residuals)
    assert found.worst_predicted.predicted[0] == worst


@pytest.mark.parametrize("sizes", [(1.0, 1.0, 1.0), (1.0, 0.1, 0.01), (1.0, 0.8, 0.1)])
def test_errors_of_points_hold_95_percent(sizes):
    """Judged by drawing; the scanner is known but for a shift."""
    covariance = np.zeros((6, 6))
    covariance[:3, :3] = np.diag(sizes)
    said = point_errors(covariance, np.zeros(3), np.zeros((1, 3)))[0]
    drawn = np.random.default_rng(0).standard_normal((100_000, 3)) * np.sqrt(sizes)
    inside = np.mean(np.linalg.norm(drawn, axis=1) < said)
    assert inside == pytest.approx(0.95, abs=0.006)


def test_a_turn_moves_far_points_more():
    covariance = np.diag([0.0, 0.0, 0.0, 1e-6, 0.0, 0.0])
    near, far, along = point_errors(
        covariance, np.zeros(3), np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]])
    )
    assert far == pytest.approx(2 * near) and far == pytest.approx(1.96e-3, rel=1e-3)
    assert along == 0.0
