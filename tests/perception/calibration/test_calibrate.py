"""The scanner's pose from what is seen of a plate: known truths, bad poses, too few, too alike."""

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.model.calibration import BallPlate
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.perception.calibration.calibrate import PlatePose, _check, calibrate
from workbench.perception.calibration.rigid import fitted_motion

X = pose_from_rpy((0.41, 0.01, 0.9), (np.pi + 0.02, 0.01, 1.5))
Y = pose_from_rpy((0.05, 0.02, 0.12), (0.3, 0.2, 0.1))
CENTRES = BallPlate().centres
NOISE = 0.00005
"""[m] Of a ball's centre."""

TURNS = [
    (0.4, 0.0, 0.0),
    (-0.4, 0.1, 0.5),
    (0.0, 0.45, -0.6),
    (0.1, -0.4, 1.2),
    (0.3, 0.3, 2.0),
    (-0.3, 0.3, -1.5),
    (0.3, -0.35, 2.8),
    (-0.35, -0.3, 0.2),
]


def seen(turns, *, noise=NOISE, seed=0, X=X, Y=Y) -> list[PlatePose]:
    """The plate at flange poses that are turned like that."""
    rng = np.random.default_rng(seed)
    poses = []
    for number, turn in enumerate(turns, start=1):
        place = rng.uniform(-0.08, 0.08, 3) + (0.41, 0.0, 0.3)
        T = pose_from_rpy(place, np.array(turn) + (np.pi, 0, 0))
        U = X.actInv(T * Y)
        balls = CENTRES @ U.rotation.T + U.translation + rng.normal(0, noise, (3, 3))
        poses.append(PlatePose(f"pose {number}", T, balls))
    return poses


def off(T: pin.SE3, truth: pin.SE3 = X) -> tuple[float, float]:
    """In mm and degrees."""
    between = truth.actInv(T)
    angle = np.linalg.norm(pin.log3(between.rotation))
    return np.linalg.norm(between.translation) * 1000, np.rad2deg(angle)


@pytest.mark.parametrize("seed", range(10))
def test_eight_poses_find_the_mount(seed):
    found = calibrate(seen(TURNS, seed=seed), CENTRES)
    distance, angle = off(found.T_world_scanner)
    assert distance < 0.35 and angle < 0.03
    # What it says about itself is not far from the truth.
    assert distance < 4 * found.position_error * 1000
    assert angle < 4 * np.rad2deg(found.angle_error)
    assert 0.00003 < found.rms < 0.00015
    assert [one.light for one in found.residuals] == ["good"] * 8
    assert found.used == 8
    distance, _ = off(found.T_flange_plate, Y)
    assert distance < 0.35


@settings(max_examples=25, deadline=None)
@given(
    xyz=st.tuples(*[st.floats(-1.0, 1.0)] * 3),
    rpy=st.tuples(*[st.floats(-1.5, 1.5)] * 3),
    held=st.tuples(*[st.floats(-1.5, 1.5)] * 3),
)
def test_without_noise_any_mount_comes_back(xyz, rpy, held):
    X, Y = pose_from_rpy(xyz, rpy), pose_from_rpy((0.05, 0.1, 0.02), held)
    found = calibrate(seen(TURNS, noise=0.0, X=X, Y=Y), CENTRES)
    distance, angle = off(found.T_world_scanner, X)
    assert distance < 1e-4 and angle < 1e-5


def test_four_poses_are_enough():
    found = calibrate(seen(TURNS[:4]), CENTRES)
    distance, angle = off(found.T_world_scanner)
    assert distance < 1.0 and angle < 0.1
    assert found.used == 4


def bent(poses: list[PlatePose], *numbers: int) -> list[PlatePose]:
    """With other joint values written for some: another pose of the flange."""
    wrong = pose_from_rpy((0.012, -0.006, 0.004), (0.0, 0.05, 0.02))
    return [
        PlatePose(pose.name, pose.T_world_flange * wrong, pose.balls) if k in numbers else pose
        for k, pose in enumerate(poses)
    ]


@pytest.mark.parametrize("number", range(8))
def test_one_bad_pose_is_named_and_left_out(number):
    found = calibrate(bent(seen(TURNS), number), CENTRES)
    assert off(found.T_world_scanner)[0] < 0.4
    (left,) = [one for one in found.residuals if one.left_out]
    assert left.name == f"pose {number + 1}" and left.light == "bad"
    assert left.distance > 0.005 and left.angle > np.deg2rad(1)
    assert "in conflict: " in str(left.left_out) and "mm" in str(left.left_out)
    assert found.used == 7


def test_three_bad_poses_of_eight_are_left_out():
    poses = seen(TURNS)
    other = bent(poses, 1)
    other[4] = bent(seen(TURNS, seed=3), 4)[4]
    other[6] = PlatePose("pose 7", poses[2].T_world_flange, poses[6].balls)
    found = calibrate(other, CENTRES)
    assert {one.name for one in found.residuals if one.left_out} == {"pose 2", "pose 5", "pose 7"}
    assert off(found.T_world_scanner)[0] < 0.6


def test_a_bad_pose_of_four_leaves_too_few():
    with pytest.raises(InputError, match=r"in conflict with the others: .*needs 4"):
        calibrate(bent(seen(TURNS[:4]), 2), CENTRES)


def test_a_person_may_leave_a_pose_out():
    poses = seen(TURNS)
    poses[3] = PlatePose(poses[3].name, poses[3].T_world_flange, poses[3].balls, is_used=False)
    found = calibrate(poses, CENTRES)
    assert found.used == 7
    assert str(found.residuals[3].left_out) == "left out by a person"
    assert found.residuals[3].distance < 0.001


def test_too_few_poses_are_refused():
    with pytest.raises(InputError, match=r"needs 4 different poses.*there are 3"):
        calibrate(seen(TURNS[:3]), CENTRES)
    with pytest.raises(InputError, match="there are 0"):
        calibrate([], CENTRES)


def test_the_same_pose_again_does_not_count():
    poses = seen(TURNS[:3])
    twin = PlatePose("pose 4", poses[0].T_world_flange, poses[0].balls)
    with pytest.raises(InputError, match="pose 4 is the same as pose 1"):
        calibrate([*poses, twin], CENTRES)


def test_poses_without_a_turn_leave_the_position_open():
    with pytest.raises(InputError, match=r"same orientation .* unknown in every direction"):
        calibrate(seen([(0.0, 0.0, 0.01 * k) for k in range(8)]), CENTRES)


def test_turns_about_one_axis_leave_the_position_along_it_open():
    """The wrist about the vertical only."""
    with pytest.raises(InputError, match=r"\(-?0\.00, -?0\.00, -?1\.00\) in the world") as refused:
        calibrate(seen([(0.0, 0.0, 0.4 * k) for k in range(8)]), CENTRES)
    assert "one axis only" in str(refused.value)


@pytest.mark.parametrize(("tilt", "is_enough"), [(10, False), (16, True)])
def test_the_order_of_poses_does_not_decide_whether_they_turn_enough(tilt, is_enough):
    turns = [(0, np.deg2rad(y), 0) for y in (-25, -10, 10, 25)] + [(np.deg2rad(tilt), 0, 0)]
    poses = seen(turns, noise=0)
    problems = []
    for first in range(len(poses)):
        try:
            _check([*poses[first:], *poses[:first]])
        except InputError as error:
            problems.append(str(error))
    assert len(problems) == (0 if is_enough else len(poses))
    assert all("one axis" in problem for problem in problems)


def test_poses_that_all_disagree_are_refused():
    rng = np.random.default_rng(0)
    poses = [
        PlatePose(one.name, one.T_world_flange, one.balls + rng.uniform(-0.1, 0.1, 3))
        for one in seen(TURNS)
    ]
    with pytest.raises(InputError, match="poses are in conflict"):
        calibrate(poses, CENTRES)


def test_the_same_poses_give_the_same_answer():
    first, second = (calibrate(seen(TURNS), CENTRES) for _ in range(2))
    assert np.array_equal(first.T_world_scanner.homogeneous, second.T_world_scanner.homogeneous)


def test_a_motion_is_fitted_and_never_a_mirror():
    T = pose_from_rpy((0.1, 0.2, 0.3), (1.0, -0.4, 2.0))
    R, p = fitted_motion(CENTRES, CENTRES @ T.rotation.T + T.translation)
    assert np.allclose(R, T.rotation) and np.allclose(p, T.translation)
    R, _ = fitted_motion(CENTRES, CENTRES * [1.0, -1.0, 1.0])
    assert np.linalg.det(R) == pytest.approx(1.0)


@pytest.mark.parametrize(
    ("radius", "sides", "problem"),
    [
        (0.015, (0.08, 0.08, 0.12), "must differ"),
        (0.015, (0.02, 0.1, 0.11), "longer than their diameter"),
        (0.015, (0.08, 0.1, 0.179), "on one line"),
        (0.5, (0.08, 0.1, 0.12), "4 to 400 mm"),
        (0.015, (0.08, 0.1, np.nan), "longer than"),
    ],
)
def test_a_plate_that_cannot_be_told_apart_is_refused(radius, sides, problem):
    with pytest.raises(InputError, match=problem):
        BallPlate(radius, np.array(sides))


def test_the_centres_are_as_far_apart_as_the_sides_say():
    plate = BallPlate(0.01, np.array([0.05, 0.09, 0.07]))
    ends = np.roll(plate.centres, -1, axis=0)
    assert np.allclose(np.linalg.norm(plate.centres - ends, axis=1), plate.sides)
