"""Points on the robot are taken out of a scan by a scanner on an arm."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import at_view, on_arm_cell, pose_at

from workbench.app.runtime.work import as_taken
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.scan import Scan
from workbench.perception.scene.own_robot import without_robot
from workbench.perception.simulation.synthesize import synthesize


@pytest.fixture(scope="module")
def cell() -> Cell:
    return on_arm_cell()


def seen(cell: Cell, points_world: Floats) -> Scan:
    T = cell.scanner.T_world_scanner
    points = (points_world - T.translation) @ T.rotation
    pixels = np.arange(len(points))
    colours = np.full((len(points), 3), 90)
    return Scan(points, T, "made", pixels, (100, 10), colours=colours, joints=at_view(cell))


def at_tool(cell: Cell, *points: list[float]) -> Floats:
    """Points of the left flange's frame in the world."""
    carrier = cell.scanner.on_arm
    assert carrier is not None
    T_world_flange = cell.scanner.T_world_scanner * carrier.T_flange_scanner.inverse()
    return np.array([T_world_flange.act(np.array(point)) for point in points])


def test_points_on_tool_and_fingers_go_and_those_beside_stay(cell: Cell) -> None:
    on = at_tool(cell, [0.003, 0, 0.11], [0.028, 0, 0.11], [0, 0, 0.05])
    beside = at_tool(cell, [0.003, 0.05, 0.11], [0, 0, 0.16], [0, 0, 0.4])
    scan = seen(cell, np.concatenate([on, beside]))
    left = without_robot(scan, cell)
    assert left.pixels is not None and left.pixels.tolist() == [3, 4, 5]
    assert left.colours is not None and len(left.colours) == 3
    assert np.allclose(left.points_world, beside)
    assert left.joints == scan.joints


def test_the_robot_is_where_the_scan_says_it_stood(cell: Cell) -> None:
    scan = seen(cell, at_tool(cell, [0.003, 0, 0.11], [0, 0, 0.4]))
    elsewhere = at_view(cell) | {"left_joint_1": 0.0}
    assert without_robot(replace(scan, joints=elsewhere), cell) is not None
    assert len(without_robot(replace(scan, joints=elsewhere), cell).points) == 2


def test_a_scan_of_nothing_but_the_robot_is_refused(cell: Cell) -> None:
    with pytest.raises(InputError, match="nothing but the robot"):
        without_robot(seen(cell, at_tool(cell, [0.003, 0, 0.11])), cell)


def test_a_simulated_scan_loses_the_hand_and_keeps_the_bin(cell: Cell) -> None:
    carrier = cell.scanner.on_arm
    assert carrier is not None
    # Tilted, so that the fingers are in the picture.
    tilted = pin.SE3(pin.rpy.rpyToMatrix(-0.35, 0.0, 0.0), np.array([0.0, -0.075, 0.035]))
    on_arm = replace(carrier, T_flange_scanner=tilted)
    mount = replace(cell.scanner, on_arm=on_arm, near=0.03)
    looking = replace(cell, scanner=mount)
    with_hand = synthesize(looking, (), seed=0, shows_robot=True)
    alone = synthesize(looking, (), seed=0)
    taken = as_taken(looking, with_hand, at_view(looking))
    near = 0.25
    assert np.count_nonzero(with_hand.points[:, 2] < near) > 1000
    assert np.count_nonzero(taken.points[:, 2] < near) == 0
    assert len(taken.points) > 0.5 * len(alone.points)


def test_the_pose_of_a_scan_follows_from_the_joints(cell: Cell) -> None:
    joints = at_view(cell) | {"left_joint_1": at_view(cell)["left_joint_1"] + 1e-3}
    scan = as_taken(cell, replace(seen(cell, np.array([[0.41, 0.0, 0.0]])), joints=None), joints)
    q = np.array([joints[name] for name in cell.arm("left").joints])
    assert scan.joints == joints
    assert scan.T_world_scanner.isApprox(pose_at(cell, q), 1e-12)
    assert not scan.T_world_scanner.isApprox(cell.scanner.T_world_scanner, 1e-5)


def test_a_scan_far_from_the_view_is_refused(cell: Cell) -> None:
    joints = at_view(cell) | {"left_joint_1": 0.0}
    with pytest.raises(InputError, match="does not stand at view bin"):
        as_taken(cell, seen(cell, np.array([[0.41, 0.0, 0.0]])), joints)
