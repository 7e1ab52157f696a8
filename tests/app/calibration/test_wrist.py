"""A scanner on an arm: its pose on the flange by scans of a plate that stands."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import on_arm_cell

from workbench.app.calibration.ball_plate import (
    first_poses,
    seen_plate,
    simulated_plate,
    simulated_sight,
    suggested_poses,
)
from workbench.app.calibration.calibration import (
    compute_calibration,
    corner_errors,
    moved_by,
    plate_flange,
    with_calibration,
)
from workbench.app.calibration.next_pose import next_poses
from workbench.model.calibration import BallPlate
from workbench.model.derived.scanner_poses import (
    calibration_covariance,
    flange_at_view,
    scanner_pose,
    with_scanner_at,
)
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.perception.calibration.balls import sight_plate
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.viewpoints import ASIDE

PLATE = BallPlate()
WRONG = pose_from_rpy((0.012, -0.008, 0.015), np.deg2rad((1.2, -0.8, 1.5)))


@pytest.fixture(scope="module")
def cell():
    return on_arm_cell()


@pytest.fixture(scope="module")
def truth(cell):
    """The cell with its scanner where it truly hangs."""
    return with_scanner_at(cell, cell.scanner.T_world_scanner * WRONG)


@pytest.fixture(scope="module")
def poses(cell):
    return suggested_poses(cell, cell.arm("left"), PLATE, 6, seed=0)


@pytest.fixture(scope="module")
def observations(cell, truth, poses):
    return tuple(sight(truth, q, k + 1) for k, q in enumerate(poses))


def sight(cell, q, number):
    scan = simulated_sight(cell, cell.arm("left"), q, PLATE, seed=number)
    return sight_plate(scan, PLATE, f"pose {number}", "left", q)


def plate_in_world(cell):
    return flange_at_view(cell.scanner) * simulated_plate(cell, cell.arm("left"), PLATE)


def test_the_plate_stands_while_the_scanner_moves(cell, poses):
    middles = []
    for number, q in enumerate(poses[:2]):
        found = sight(cell, q, number)
        T = scanner_pose(cell, q)
        middles.append((found.balls @ T.rotation.T + T.translation).mean(axis=0))
    there = plate_in_world(cell).act(PLATE.centres.mean(axis=0))
    assert np.abs(np.array(middles) - there).max() < 5e-4
    assert len({tuple(np.round(scanner_pose(cell, q).translation, 2)) for q in poses}) == len(poses)


def test_suggested_poses_are_within_the_limits_and_clear_of_everything(cell, poses):
    lower, upper, _ = cell.robot.limits(cell.arm("left").joints)
    world = World(cell, ())
    world.enter(LegPhase(frozenset(arm.name for arm in cell.arms)))
    for q in poses:
        assert np.all((q >= lower) & (q <= upper))
        assert world.contact(world.configuration({"left": q})) is None


def test_the_first_pose_is_the_view_and_then_the_plate_may_lie_anywhere(cell):
    arm = cell.arm("left")
    assert [tuple(q) for q in first_poses(cell, arm, PLATE, 3, seed=0, observations=())] == [
        tuple(cell.scanner.on_arm.view.q)
    ]
    seen = sight(cell, cell.scanner.on_arm.view.q, 1)
    off = seen_plate(cell, seen).actInv(simulated_plate(cell, arm, PLATE))
    assert np.linalg.norm(off.translation) < 1e-3
    moved = replace(seen, balls=seen.balls + (0.06, 0.0, 0.0))
    for one in (seen, moved):
        (q,) = first_poses(cell, arm, PLATE, 1, seed=0, observations=[one])
        T_world_plate = flange_at_view(cell.scanner) * seen_plate(cell, one)
        middle = T_world_plate.act(PLATE.centres.mean(axis=0))
        x, y, z = scanner_pose(cell, q).actInv(middle)
        assert np.hypot(x, y) < 2 * ASIDE and cell.scanner.near < z < cell.scanner.far


def test_a_flange_that_moves_the_plate_alike_is_the_arms_at_the_view(cell):
    arm, kinematics = cell.arm("left"), Kinematics(cell)
    at_view = plate_flange(cell, kinematics, arm, cell.scanner.on_arm.view.q)
    assert at_view.isApprox(flange_at_view(cell.scanner), 1e-9)


def test_a_scanner_that_hangs_elsewhere_on_its_flange_is_found(cell, truth, observations):
    found = compute_calibration(cell, observations)
    after = with_calibration(cell, found, 1_000.4, "ada")
    right = truth.scanner.on_arm.T_flange_scanner
    off = right.actInv(after.scanner.on_arm.T_flange_scanner)
    assert np.linalg.norm(off.translation) < 0.0005
    assert np.linalg.norm(pin.log3(off.rotation)) < np.deg2rad(0.05)
    there = flange_at_view(cell.scanner) * found.T_flange_plate
    assert np.linalg.norm(there.actInv(plate_in_world(cell)).translation) < 0.0005
    assert moved_by(cell, found)[0] == pytest.approx(np.linalg.norm(WRONG.translation), abs=0.001)
    assert moved_by(after, found)[0] < 1e-9
    # Views and waiting poses stay; the record is along the flange's axes.
    assert np.array_equal(after.scanner.on_arm.view.q, cell.scanner.on_arm.view.q)
    assert np.allclose(calibration_covariance(after.scanner), found.covariance, atol=1e-15)
    assert not np.allclose(after.scanner.calibration.covariance, found.covariance, atol=1e-12)
    said = corner_errors(after, calibration_covariance(after.scanner))
    assert max(said.values()) < 0.001
    assert max(residual.predicted[0] for residual in found.residuals) < 0.0005


def test_a_wrong_joint_value_is_named_and_left_out(cell, observations):
    wrong = replace(observations[3], q=observations[3].q + np.deg2rad([2.0, 0, 0, 0, 0, 0, 0]))
    found = compute_calibration(cell, (*observations[:3], wrong, *observations[4:]))
    assert [one.name for one in found.residuals if one.left_out] == ["pose 4"]


def test_poses_that_leave_something_open_are_refused(cell, truth, observations):
    with pytest.raises(InputError, match="needs 4 different poses"):
        compute_calibration(cell, observations[:3])
    view, joint = np.array(cell.scanner.on_arm.view.q), cell.arm("left").joints
    turned = [view + np.deg2rad(k * 15.0) * np.eye(len(joint))[-1] for k in range(4)]
    alike = [sight(truth, q, number) for number, q in enumerate(turned)]
    with pytest.raises(InputError, match="turned about one axis only"):
        compute_calibration(cell, alike)


def test_poses_of_another_arm_are_refused(cell, observations):
    other = [replace(one, arm="right") for one in observations]
    with pytest.raises(InputError, match="the left arm carries the scanner; remove it"):
        compute_calibration(cell, other)


@pytest.mark.extensive
def test_the_pose_to_take_next_is_seen_and_helps(cell, truth, observations):
    found = compute_calibration(cell, observations[:5])
    best = next_poses(cell, observations[:5], found, seed=0)
    errors = [one.error_with for one in best]
    assert errors == sorted(errors) and errors[0] < best[0].error
    assert best[0].after == "pose 5" and 1 <= len(best[0].steps) <= 4
    assert "the plate" not in " ".join(map(str, best[0].steps))
    after = compute_calibration(cell, [*observations[:5], sight(truth, best[0].q, 6)])
    assert after.used == 6
