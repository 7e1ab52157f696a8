"""Worlds for Klamp't, read back with what reads such files here."""

import xml.etree.ElementTree as ElementTree
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.extras.klampt.urdf_writer import depth_first, write_urdf
from workbench.extras.klampt.worlds import Snapshot, WorldPart, robot_with_tools, write_world
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.robots.urdf import read_urdf
from workbench.model.cell import Cell, Fixture
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy
from workbench.model.robot import Joint, Link

T_TCP_PART = pose_from_rpy((0, 0.001, 0.005), (0.1, 0.2, 0.3))


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="module")
def snapshot(cell: Cell) -> Snapshot:
    part = cell.part("keyed_cylinder")
    arm = cell.arm("right")
    return Snapshot(
        standing=(WorldPart("part-2", part, pose_from_rpy((0.4, 0.1, 0.02), (1.5, 0, 0.2))),),
        openings={"right": 0.03},
        held={"right": WorldPart("part-1", part, T_TCP_PART)},
        joints=arm.joints,
        t=np.array([0.0, 0.5]),
        q=np.stack([arm.home, arm.home + 0.1]),
    )


def test_tool_and_held_part_hang_on_the_flange(cell: Cell, snapshot: Snapshot) -> None:
    robot = robot_with_tools(cell, snapshot)
    assert [joint.child for joint in robot.chain("part-1")][-2:] == ["right_tool", "part-1"]
    tool = cell.arm("right").tool
    np.testing.assert_allclose(
        robot.joint("part-1_mount").T_parent_joint.homogeneous,
        (tool.T_flange_tcp * T_TCP_PART).homogeneous,
    )
    fingers = robot.link("right_tool").collision[-2:]
    inner = [finger.T_owner_shape.translation[0] for finger in fingers]
    closed = [finger.solid.T_owner_shape.translation[0] for finger in tool.fingers]
    assert np.subtract(inner, closed).tolist() == pytest.approx([-0.015, 0.015])


def test_what_cannot_meet_is_disabled(cell: Cell, snapshot: Snapshot) -> None:
    pairs = robot_with_tools(cell, snapshot).disabled_pairs
    assert pairs >= cell.robot.disabled_pairs
    assert {("part-1", "right_tool"), ("part-1", "right_link_6")} <= pairs
    assert ("left_tool", "part-1") not in pairs


def test_a_world_names_files_that_are_there(tmp_path: Path, cell: Cell, snapshot: Snapshot) -> None:
    world = write_world(tmp_path, "01-right-return", cell, snapshot)
    root = ElementTree.parse(world).getroot()
    terrains = {element.get("name"): element.get("file") for element in root.iter("terrain")}
    assert set(terrains) == {"bin", "table", "tray_right", "tray_left", "part-2"}
    part = trimesh.load_mesh(world.parent / terrains["part-2"])
    np.testing.assert_allclose(part.bounds.mean(axis=0), [0.4, 0.1, 0.02], atol=0.003)
    robot = read_urdf(world.parent / root.find("robot").get("file"))
    assert robot.link("part-1").collision


def test_the_motion_has_a_column_for_every_joint_of_the_file(
    tmp_path: Path, cell: Cell, snapshot: Snapshot
) -> None:
    folder = write_world(tmp_path, "world", cell, snapshot).parent
    rows = [line.split() for line in (folder / "motion.path").read_text().splitlines()]
    assert [float(row[0]) for row in rows] == [0.0, 0.5]
    model = pin.buildModelFromUrdf(str(folder / "robot.urdf"))
    joints = read_urdf(folder / "robot.urdf").joints
    assert [int(row[1]) for row in rows] == [len(joints)] * 2
    # Pinocchio sorts as Klamp't does, but leaves out fixed joints, which stand as zero.
    values = np.array([[float(word) for word in row[2:]] for row in rows])
    moving = values[:, np.any(values != 0, axis=0)]
    columns = [model.getJointId(joint) - 1 for joint in snapshot.joints]
    expected = np.zeros((2, model.nq))
    expected[:, columns] = snapshot.q
    left = cell.arm("left")
    expected[:, [model.getJointId(joint) - 1 for joint in left.joints]] = left.home
    np.testing.assert_array_equal(moving, expected[:, np.any(expected != 0, axis=0)])


def test_things_may_be_called_anything_or_have_no_solids(
    tmp_path: Path, cell: Cell, snapshot: Snapshot
) -> None:
    solid = cell.fixtures[0].solids[0]
    still = pin.SE3.Identity()
    fixtures = (Fixture("nothing", still, ()), Fixture("../../up", still, (solid,)))
    links = (*cell.robot.links, Link("../../away", (solid,)))
    mount = Joint("mount", "fixed", cell.robot.root, "../../away", still, np.array([0.0, 0, 1]))
    robot = replace(cell.robot, links=links, joints=(*cell.robot.joints, mount))
    changed = replace(cell, fixtures=fixtures, robot=robot)
    world = write_world(tmp_path / "out", "world", changed, snapshot)
    names = [one.get("name") for one in ElementTree.parse(world).getroot().iter("terrain")]
    assert names == ["bin", "../../up", "part-2"]
    assert [item.name for item in tmp_path.iterdir()] == ["out"]
    assert [item.name for item in (tmp_path / "out").iterdir()] == ["world"]


def test_a_folder_that_cannot_be_made_is_an_error(
    tmp_path: Path, cell: Cell, snapshot: Snapshot
) -> None:
    (tmp_path / "file").write_text("")
    with pytest.raises(FileError, match="file"):
        write_world(tmp_path / "file", "world", cell, snapshot)


def test_a_robot_written_and_read_by_pinocchio_stands_where_ours_stands(tmp_path: Path) -> None:
    robot = read_urdf(find("robots", "yumi") / "yumi.urdf")
    (tmp_path / "meshes").mkdir()
    write_urdf(tmp_path / "yumi.urdf", robot)
    ours = read_urdf(tmp_path / "yumi.urdf")
    theirs = pin.buildModelFromUrdf(str(tmp_path / "yumi.urdf"))
    movable = [joint for joint in depth_first(robot) if joint.kind != "fixed"]
    assert list(theirs.names)[1:] == [joint.name for joint in movable]
    for joint in movable:
        again = ours.joint(joint.name)
        np.testing.assert_allclose(
            again.T_parent_joint.homogeneous, joint.T_parent_joint.homogeneous, atol=1e-12
        )
        np.testing.assert_allclose(
            theirs.jointPlacements[theirs.getJointId(joint.name)].homogeneous,
            joint.T_parent_joint.homogeneous,
            atol=1e-12,
        )
