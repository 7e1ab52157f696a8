"""What a scan shows that nothing known explains."""

from dataclasses import replace

import numpy as np
import pytest
from shipped import shipped

from workbench.model.cell import Fixture
from workbench.model.geometry import Box, Solid, pose_from_rpy
from workbench.model.scan import Scan
from workbench.perception.scene.unexplained import (
    OF_THE_CELL,
    UNEXPLAINED,
    explained_by,
    unexplained,
)
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize

CELL = shipped("yumi")
PART = CELL.parts[0]


def pile(seed: int, count: int = 2):
    truth = drop_parts((PART,) * count, CELL.bin, seed=seed)
    return synthesize(CELL, truth, seed=seed), truth


def holds(obstacle, points):
    """Which points (n, 3) lie in the box of an obstacle, or within 1 mm of it."""
    T = obstacle.T_world_box.inverse()
    inside = np.abs(points @ T.rotation.T + T.translation)
    return np.all(inside <= obstacle.size / 2 + 0.001, axis=1)


@pytest.mark.parametrize("seed", range(6))
def test_where_everything_is_known_nothing_is_left(seed):
    scan, detections = pile(seed, 2 + 3 * (seed % 2))
    assert unexplained(CELL, scan, detections) == ()


@pytest.mark.parametrize("seed", range(6))
def test_a_part_that_was_not_found_is_boxed_and_the_boxes_hold_its_points(seed):
    scan, detections = pile(seed, 3)
    obstacles = unexplained(CELL, scan, detections[:-1])
    assert 1 <= len(obstacles) <= 12
    points = scan.points_world
    own = points[explained_by(CELL, detections, points) == 2]
    boxed = np.any([holds(one, own) for one in obstacles], axis=0)
    known = explained_by(CELL, detections[:-1], own) != UNEXPLAINED
    assert np.mean(boxed | known) > 0.98
    # And no more than a hand's breadth around it.
    volume = sum(float(np.prod(one.size)) for one in obstacles)
    assert volume < 12 * 0.08 * 0.038 * 0.038


def test_boxes_reach_down_to_the_floor():
    scan, detections = pile(0)
    for one in unexplained(CELL, scan, detections[:1]):
        bottom = one.T_world_box.translation[2] - one.size[2] / 2
        assert bottom == pytest.approx(CELL.bin.T_world_bin.translation[2], abs=1e-6)


def test_points_belong_to_what_they_lie_on():
    scan, detections = pile(1)
    owners = explained_by(CELL, detections, scan.points_world)
    assert set(np.unique(owners)) <= {UNEXPLAINED, OF_THE_CELL, 0, 1}
    for number, detection in enumerate(detections):
        away = scan.points_world[owners == number] - detection.T_world_part.translation
        assert np.linalg.norm(away, axis=1).max() < 0.06


def test_a_strange_thing_in_the_bin_is_found_where_it_is():
    at = CELL.bin.T_world_bin.translation + (0.03, 0.05, 0.02)
    stone = Solid("stone", Box(np.array([0.05, 0.03, 0.04])), pose_from_rpy((0, 0, 0)))
    fixtures = (*CELL.fixtures, Fixture("stone", pose_from_rpy(at), (stone,)))
    scan = synthesize(replace(CELL, fixtures=fixtures), [], seed=0)
    (found,) = unexplained(CELL, scan, ())
    np.testing.assert_allclose(found.T_world_box.translation[:2], at[:2], atol=0.006)
    np.testing.assert_allclose(np.sort(found.size), [0.03, 0.04, 0.05], atol=0.012)


@pytest.mark.parametrize("far", [10.0, 1e4, 1e30, 1e300])
def test_points_far_away_do_not_exhaust_the_memory(far):
    scan, detections = pile(0, 3)
    points = np.array(scan.points)
    points[:: len(points) // 200] = far
    boxes = unexplained(CELL, Scan(points, scan.T_world_scanner, "far"), detections[:-1])
    assert boxes
    assert all(np.abs(one.T_world_box.translation).max() < 2 for one in boxes)


@pytest.mark.parametrize("count", [5, 49, 50, 300])
def test_however_few_points_are_in_reach_a_dense_block_of_them_is_an_obstacle(count):
    generator = np.random.default_rng(0)
    at = CELL.bin.T_world_bin.translation + (0.03, 0.05, 0.04)
    points = at + generator.uniform(-0.004, 0.004, (count, 3))
    T = CELL.scanner.T_world_scanner.inverse()
    scan = Scan(points @ T.rotation.T + T.translation, T.inverse(), "few")
    boxes = unexplained(CELL, scan, ())
    assert np.any([holds(one, points) for one in boxes], axis=0).mean() > 0.9
