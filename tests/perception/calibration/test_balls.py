"""The plate found in clouds: with a robot around it, half hidden, or not there."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.calibration.ball_plate import simulated_sight, suggested_poses
from workbench.model.calibration import BallPlate
from workbench.model.errors import InputError
from workbench.model.scan import Scan
from workbench.perception.calibration.balls import find_balls, sight_plate
from workbench.perception.simulation.ball_plate import held_pose, is_plate_in_sight
from workbench.planning.kinematics.robot import Kinematics

PLATE = BallPlate()


def ball(centre, radius=0.015, points=400, seed=0):
    """The half of a ball that looks at the scanner, with a little noise."""
    rng = np.random.default_rng(seed)
    directions = rng.normal(size=(6 * points, 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    facing = directions @ (np.array(centre) / np.linalg.norm(centre)) < -0.25
    chosen = directions[facing][:points]
    return np.array(centre) + (radius + rng.normal(0, 0.0001, (len(chosen), 1))) * chosen


def plane(depth=0.9, count=20_000, seed=0):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-0.2, 0.2, (count, 3))
    points[:, 2] = depth + rng.normal(0, 0.0003, count)
    return points


def test_balls_are_found_among_planes_and_cylinders():
    rng = np.random.default_rng(1)
    angle, along = rng.uniform(np.pi, 2 * np.pi, 6000), rng.uniform(-0.1, 0.1, 6000)
    rod = np.stack([along, 0.015 * np.cos(angle) + 0.1, 0.015 * np.sin(angle) + 0.7], axis=1)
    truth = [(0.0, 0.0, 0.7), (0.08, -0.02, 0.75)]
    cloud = np.concatenate([plane(), rod, *(ball(c, seed=k) for k, c in enumerate(truth))])
    centres, spreads = find_balls(cloud, 0.015)
    assert len(centres) == 2
    for centre in truth:
        assert np.linalg.norm(centres - centre, axis=1).min() < 0.0002
    assert spreads.max() < 0.0003


@pytest.mark.parametrize("far", [1e4, 1e9])
def test_points_far_away_do_not_hide_a_ball(far):
    cloud = np.concatenate([plane(), ball((0.0, 0.0, 0.7)), np.full((3, 3), far)])
    (centre,), _ = find_balls(cloud, 0.015)
    assert np.linalg.norm(centre - (0.0, 0.0, 0.7)) < 0.0002


def test_balls_of_another_size_are_none():
    assert len(find_balls(np.concatenate([plane(), ball((0, 0, 0.7), 0.03)]), 0.015)[0]) == 0
    assert len(find_balls(plane(), 0.015)[0]) == 0
    assert len(find_balls(np.ones((3, 3)), 0.015)[0]) == 0


def test_the_order_of_the_balls_is_that_of_the_plate(cell):
    rng = np.random.default_rng(3)
    place = np.array([0.02, -0.03, 0.65])
    centres = PLATE.centres + place
    cloud = np.concatenate([ball(centre, seed=k) for k, centre in enumerate(centres)])
    scan = Scan(rng.permutation(cloud), cell.scanner.T_world_scanner, "made")
    found = sight_plate(scan, PLATE, "pose 1", "right", np.zeros(7))
    assert np.linalg.norm(found.balls - centres, axis=1).max() < 0.0003


def test_two_balls_are_no_plate(cell):
    cloud = np.concatenate([ball(c + (0, 0, 0.7)) for c in PLATE.centres[:2]])
    scan = Scan(cloud, cell.scanner.T_world_scanner, "made")
    with pytest.raises(InputError, match=r"pose 7: the plate is not seen: 2 balls of 30 mm"):
        sight_plate(scan, PLATE, "pose 7", "right", np.zeros(7))


def test_a_plate_in_the_hand_of_the_robot_is_measured(cell):
    arm = cell.arms[1]
    q = suggested_poses(cell, arm, PLATE, 1, seed=4)[0]
    scan = simulated_sight(cell, arm, q, PLATE, seed=1)
    found = sight_plate(scan, PLATE, "pose 1", arm.name, q)
    T = Kinematics(cell).tcp_pose(arm, q) * held_pose(PLATE)
    truth = PLATE.centres @ T.rotation.T + T.translation
    S = cell.scanner.T_world_scanner
    assert np.linalg.norm(found.balls @ S.rotation.T + S.translation - truth, axis=1).max() < 3e-4
    assert found.spread < 0.0004
    again = simulated_sight(cell, arm, q, PLATE, seed=1)
    assert again.digest == scan.digest


def test_a_plate_outside_the_picture_or_behind_the_arm_is_not_in_sight(cell):
    arm = cell.arms[0]
    q = suggested_poses(cell, arm, PLATE, 1, seed=0)[0]
    links = Kinematics(cell).link_poses(dict(zip(arm.joints, map(float, q), strict=True)))
    T_scanner, T_tcp_plate = cell.scanner.T_world_scanner, held_pose(PLATE)
    held = Kinematics(cell).tcp_pose(arm, q) * T_tcp_plate
    assert is_plate_in_sight(cell, links, PLATE, held, T_scanner)
    at_home, nowhere = Kinematics(cell).link_poses({}), np.zeros(len(arm.joints))
    held = Kinematics(cell).tcp_pose(arm, nowhere) * T_tcp_plate
    assert not is_plate_in_sight(cell, at_home, PLATE, held, T_scanner)
    # From three metres up, through a narrow opening, it is out of the picture.
    T = cell.scanner.T_world_scanner.copy()
    T.translation[2] = 3.0
    far = replace(cell, scanner=replace(cell.scanner, field_of_view=0.05))
    assert not is_plate_in_sight(far, at_home, PLATE, held, T)
