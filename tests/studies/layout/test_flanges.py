"""The tool stands where the last axis points, whatever the links are called."""

import made_arm
import numpy as np
import pytest

from workbench.formats.robots.descriptions import read_description
from workbench.model.errors import InputError
from workbench.studies.layout.flanges import lean_of, mounts_of, named_mounts

HALF = np.pi / 2


def fixed(name: str, parent: str, rpy=(0, 0, 0), xyz=(0, 0, 0)) -> str:
    numbers = (" ".join(map(repr, one)) for one in (xyz, rpy))
    at = '<origin xyz="{}" rpy="{}"/>'.format(*numbers)
    return (
        f'<link name="{name}"/><joint name="to_{name}" type="fixed">{at}'
        f'<parent link="{parent}"/><child link="{name}"/></joint>'
    )


@pytest.fixture
def robot(tmp_path):
    def made(flange: str, *, axis: str = "1 0 0"):
        text = made_arm.arm(flange=flange)
        head, _, tail = text.rpartition('<axis xyz="1 0 0"/>')
        path = made_arm.written(tmp_path / "arm.urdf", f'{head}<axis xyz="{axis}"/>{tail}')
        return read_description(path).robot

    return made


@pytest.mark.parametrize("axis", ["1 0 0", "-1 0 0"])
def test_a_flange_whose_z_is_the_last_axis_is_taken(robot, axis):
    found = mounts_of(robot(fixed("tool0", "s6", (0, HALF, 0)), axis=axis), ["s6"])
    assert found.flanges == ("tool0",) and found.notes == ()
    assert lean_of(found.robot, "tool0") == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("axis", ["1 0 0", "-1 0 0"])
def test_another_link_is_taken_where_the_flange_looks_to_the_side(robot, axis):
    links = fixed("flange", "s6") + fixed("maker_flange", "flange", (np.pi, -HALF, 0))
    found = mounts_of(robot(links, axis=axis), ["s6"])
    assert found.flanges == ("maker_flange",)
    (note,) = found.notes
    assert "z of link flange is turned 90 degrees against the last axis" in note


@pytest.mark.parametrize("rpy", [(0, 0, 0), (0, -HALF, 0), (HALF, 0, 0.3)])
def test_a_link_is_added_where_no_frame_points_out_of_the_arm(robot, rpy):
    found = mounts_of(robot(fixed("flange", "s6", rpy, (0.05, 0, 0))), ["s6"])
    assert found.flanges == ("tool_flange",)
    assert "(added to the URDF)" in found.notes[0]
    chain = found.robot.chain("tool_flange")
    assert chain[-1].parent == "s6"
    np.testing.assert_allclose(chain[-1].T_parent_joint.translation, [0.05, 0, 0], atol=1e-12)
    np.testing.assert_allclose(chain[-1].T_parent_joint.rotation[:, 2], [1, 0, 0], atol=1e-9)


def test_x_of_a_flange_that_looks_along_x_turns_down_as_in_the_frames_of_ros(robot):
    found = mounts_of(robot(fixed("flange", "s6")), ["s6"])
    R = found.robot.chain("tool_flange")[-1].T_parent_joint.rotation
    np.testing.assert_allclose(R, [[0, 0, 1], [0, 1, 0], [-1, 0, 0]], atol=1e-12)


def test_a_camera_beside_the_axis_is_no_flange(robot):
    links = fixed("camera_tool", "s6", (0, HALF, 0), (0, 0, 0.06)) + fixed(
        "mount_tool", "s6", (0, HALF, 0)
    )
    assert mounts_of(robot(links), ["s6"]).flanges == ("mount_tool",)


def test_without_a_flange_the_tool_stands_at_the_face_of_the_last_link(robot):
    found = mounts_of(robot(""), ["s6"])
    assert found.flanges == ("tool_flange",)
    T = found.robot.chain("tool_flange")[-1].T_parent_joint
    np.testing.assert_allclose(T.translation, [0, 0, 0], atol=1e-12)  # the box ends there
    assert "no link is called a flange" not in found.notes[0]


def test_a_link_that_a_person_names_is_taken_and_its_lean_told(robot):
    there = robot(fixed("flange", "s6"))
    found = named_mounts(there, ["flange"])
    assert found.flanges == ("flange",)
    assert "z of link flange is turned 90 degrees against the last axis" in found.notes[0]
    with pytest.raises(InputError, match="--flange base: no joint moves this link"):
        named_mounts(there, ["base"])
    with pytest.raises(InputError, match="has no link 'nobody'"):
        named_mounts(there, ["nobody"])
