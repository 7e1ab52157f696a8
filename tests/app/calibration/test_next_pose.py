"""Which pose of the plate to take next: what it would bring, and the way there in words."""

import numpy as np
import pinocchio as pin
import pytest
from held_plates import CENTRES, CORNERS, X, Y, scene
from shipped import shipped

from workbench.app.calibration.ball_plate import simulated_sight, suggested_poses
from workbench.app.calibration.calibration import compute_calibration
from workbench.app.calibration.next_pose import SIDE_NAMES, next_poses, steps_to
from workbench.model.calibration import BallPlate
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.calibration import PoseText
from workbench.perception.calibration.balls import sight_plate
from workbench.perception.calibration.next_pose import errors_with
from workbench.perception.calibration.plate_poses import PlatePose
from workbench.perception.calibration.sureness import best_fit, point_errors

PLATE = BallPlate()


def test_what_a_pose_would_bring_is_what_it_brings():
    """Judged by taking it, exactly where it is expected, and the noise as it was."""
    poses = scene(5, count=6, shift=3e-4)
    fit = best_fit(poses, (X, Y), CENTRES)
    wanted = [pose.T_world_flange for pose in scene(9, count=4)]
    now, said = errors_with(poses, fit.answer, CENTRES, wanted, CORNERS)
    origin = fit.answer[0].translation
    assert now == pytest.approx(point_errors(fit.covariance, origin, CORNERS).max(), rel=1e-6)
    assert np.all(said < now)
    for T, error in zip(wanted, said, strict=True):
        U = fit.answer[0].actInv(T * fit.answer[1])
        balls = CENTRES @ U.rotation.T + U.translation
        more = best_fit([*poses, PlatePose("more", T, balls)], fit.answer, CENTRES)
        # A pose without noise has the deviations look smaller, by their share of it.
        assert error * 0.75 < point_errors(more.covariance, origin, CORNERS).max() < error * 1.1


def test_the_pose_to_take_next_is_seen_and_helps_more_than_others():
    cell = shipped("yumi")
    arm = cell.arms[0]

    def sight(q, number):
        scan = simulated_sight(cell, arm, q, PLATE, seed=number)
        return sight_plate(scan, PLATE, f"pose {number}", arm.name, q)

    qs = suggested_poses(cell, arm, PLATE, 5, seed=0)
    observations = [sight(q, number) for number, q in enumerate(qs, 1)]
    found = compute_calibration(cell, observations)
    best = next_poses(cell, observations, found, seed=0)
    errors = [one.error_with for one in best]
    assert errors == sorted(errors) and errors[0] < best[0].error
    assert best[0].after == "pose 5" and 1 <= len(best[0].steps) <= 4
    again = next_poses(cell, observations, found, seed=0)
    assert np.array_equal(best[0].q, again[0].q)
    after = compute_calibration(cell, [*observations, sight(best[0].q, 6)])
    assert after.used == 6


STEPS = [
    (pose_from_rpy((0, 0, 0.05), (0, 0, 0.5)), "turn the plate by 29 deg counterclockwise", 1),
    (pose_from_rpy((0, 0, 0.05), (0, 0, -0.5)), "turn the plate by 29 deg clockwise", 1),
    # A positive turn about y brings what is above it towards x, where the front is.
    (pose_from_rpy((0, 0, 0.05), (0, 0.5, 0)), "tip its upper side by 29 deg towards the front", 1),
    (pose_from_rpy((0, 0, 0.05), (0.5, 0, 0)), "tip its upper side by 29 deg towards the right", 1),
    (pose_from_rpy((-0.03, 0.03, 0.05)), "move it by 42 mm towards the back left corner", 1),
    (pose_from_rpy((0, 0, 0.12)), "raise it by 70 mm", 1),
    (pose_from_rpy((0, -0.02, 0.02)), "lower it by 30 mm", 2),
    (pose_from_rpy((0, 0.001, 0.05), (0.01, 0, 0)), "", 0),
]


@pytest.mark.parametrize(("T", "said", "count"), STEPS)
def test_the_way_is_told_by_the_walls_of_the_bin(T, said, count):
    steps = steps_to(pose_from_rpy((0, 0, 0.05)), T, PoseText.PLATE())
    assert len(steps) == count and said in ", ".join(map(str, steps))


@pytest.mark.parametrize("seed", range(5))
def test_the_steps_one_after_the_other_lead_there(seed):
    """Their numbers, read back, are the motion but for rounding."""
    rng = np.random.default_rng(seed)
    yaw, tip, lean = rng.uniform(-3, 3), rng.uniform(0.1, 0.5), np.pi / 4 * rng.integers(8)
    # Tipped towards `lean`: about the level axis a quarter turn before it.
    axis = np.array([-np.sin(lean), np.cos(lean), 0.0])
    before = pin.SE3(pin.exp3(rng.normal(0, 1, 3)), np.zeros(3))
    turn = pin.exp3(tip * axis) @ pin.exp3(np.array([0.0, 0.0, yaw]))
    after = pin.SE3(turn @ before.rotation, np.zeros(3))
    steps = list(map(str, steps_to(before, after, PoseText.PLATE())))
    assert f"{abs(np.rad2deg(yaw)):.0f} deg" in steps[0]
    assert ("counter" in steps[0]) == (yaw > 0)
    assert f"{np.rad2deg(tip):.0f} deg" in steps[1]
    assert SIDE_NAMES[round(lean / (np.pi / 4)) % 8].template in steps[1]
