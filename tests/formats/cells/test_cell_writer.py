"""A cell that is written comes back as it was."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.robots.descriptions import read_description
from workbench.formats.robots.urdf import read_urdf
from workbench.formats.robots.urdf_package import write_package
from workbench.formats.robots.xacro_files import expand_xacro, is_xacro
from workbench.model.calibration import CalibrationRecord
from workbench.model.cell import Fixture
from workbench.model.derived.policies import POLICIES
from workbench.model.digest import digest_of
from workbench.model.errors import FileError
from workbench.model.geometry import Mesh, Solid, pose_from_rpy
from workbench.model.part import Region
from workbench.model.scan import PosesFolder
from workbench.planning.collision.link_pairs import pairs_without_check
from workbench.planning.kinematics.robot import Kinematics


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_a_cell_comes_back(name, tmp_path):
    cell = read_cell(name)
    unchecked = dict.fromkeys(cell.robot.disabled_pairs, "Adjacent")
    again = read_cell(write_cell(tmp_path / "cell", cell, unchecked))
    assert again.robot.disabled_pairs == cell.robot.disabled_pairs
    for one, other in zip(cell.arms, again.arms, strict=True):
        assert (one.name, one.joints, one.axis_order) == (
            other.name,
            other.joints,
            other.axis_order,
        )
        np.testing.assert_allclose(other.home, one.home, atol=1e-4)
        np.testing.assert_allclose(other.acceleration, one.acceleration, rtol=1e-6)
        assert other.tool.T_flange_tcp.isApprox(one.tool.T_flange_tcp, 1e-6)
        assert len(other.tool.body) == len(one.tool.body)
        for T, U in zip(one.Ts_world_place, other.Ts_world_place, strict=True):
            assert U.isApprox(T, 1e-6)
    assert again.bin.T_world_bin.isApprox(cell.bin.T_world_bin, 1e-6)
    assert again.scanner.T_world_scanner.isApprox(cell.scanner.T_world_scanner, 1e-6)
    assert again.policy == replace(cell.policy, lift_lean=again.policy.lift_lean)
    assert [one.name for one in again.fixtures] == [one.name for one in cell.fixtures]
    home = {joint: 0.3 for arm in cell.arms for joint in arm.joints}
    here, there = Kinematics(cell).link_poses(home), Kinematics(again).link_poses(home)
    for link in here:
        assert there[link].isApprox(here[link], 1e-9)
    for link, other in zip(cell.robot.links, again.robot.links, strict=True):
        assert [s.shape.kind for s in link.collision] == [s.shape.kind for s in other.collision]


def written(folder, cell):
    return read_cell(write_cell(folder / "cell", cell, {}))


def test_what_is_seldom_changed_comes_back_too(tmp_path):
    cell = read_cell("yumi")
    record = CalibrationRecord(1.7e9, 'Ada "\U0001f916" Nö', 8, 0.0001)
    scanner = replace(
        cell.scanner,
        source="folder",
        address=str(tmp_path / "scans"),
        unit="mm",
        patience=5.0,
        calibration=record,
        while_moving=True,
    )
    policy = replace(
        cell.policy,
        free_points=12,
        straight_points=7,
        seconds=3.0,
        metric=0.5,
        approval_minutes=2.5,
        lifts=("up", "off-wall"),
        least_air=0.002,
        pair_gap=0.004,
        picks=4,
        tcp_speed=0.4,
        point_speed=0.5,
        held_speed=0.3,
        stirs=2,
        stir_speed=0.15,
        slot_speed=0.03,
        manual_speed=True,
        contact_energy=0.49,
    )
    folder = PosesFolder(str(tmp_path / "poses"), "keyed_cylinder")
    careful, other = (replace(arm, moving_mass=9.5) for arm in cell.arms)
    arms = (replace(careful, needs_roll=True, passes_parts_on=True), other)
    changed = replace(cell, scanner=scanner, policy=policy, poses_folder=folder, arms=arms)
    again = written(tmp_path, changed)
    assert [arm.needs_roll for arm in again.arms] == [True, False]
    assert [arm.passes_parts_on for arm in again.arms] == [True, False]
    assert [arm.moving_mass for arm in again.arms] == [9.5, 9.5]
    assert digest_of(again.scanner) == digest_of(scanner)
    assert again.policy == policy
    assert digest_of(again.poses_folder) == digest_of(folder)


@pytest.mark.parametrize(
    "other",
    [{}, {"lifts": ("up",)}, {"least_air": None}, {"pair_gap": 0.0}, {"lifts": ("up", "back")}],
)
def test_a_cell_that_empties_bins_thoroughly_says_so_and_what_differs(tmp_path, other):
    policy = replace(POLICIES["thorough"], **other)
    assert written(tmp_path, replace(read_cell("yumi"), policy=policy)).policy == policy
    texts = [path.read_text() for path in tmp_path.rglob("cell.toml")]
    says = sum('emptying = "thorough"' in text for text in texts)
    assert says == (0 if "least_air" in other or other.get("lifts") == ("up",) else 1)


def test_solids_keep_their_names_and_flat_ones_stay_flat(tmp_path):
    cell = read_cell("yumi")
    flat = Mesh(np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    sheet = Fixture("sheet", pin.SE3.Identity(), (Solid("sheet_a", flat, pin.SE3.Identity()),))
    tool = cell.arms[0].tool
    body = tuple(replace(one, name=f"{tool.name}_{one.name}") for one in tool.body)
    tool = replace(tool, body=body)
    arms = tuple(replace(arm, tool=tool, tools=(tool,)) for arm in cell.arms)
    again = written(tmp_path, replace(cell, arms=arms, fixtures=(sheet,)))
    assert again.fixtures[0].solids[0].name == "sheet_a"
    assert not again.fixtures[0].solids[0].shape.is_convex
    assert [one.name for one in again.arms[0].tool.body] == [one.name for one in arms[0].tool.body]


def test_what_is_seen_and_what_is_checked_of_a_link_are_files_of_their_own(tmp_path):
    cell = read_cell("yumi")
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]]) * 0.1
    seen, checked = (
        Mesh(corners * size, np.array([[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]))
        for size in (1.0, 2.0)
    )
    link = replace(
        cell.robot.links[0],
        visual=(Solid("seen", seen, pin.SE3.Identity()),),
        collision=(Solid("checked", checked, pin.SE3.Identity()),),
    )
    write_package(tmp_path / "robot.urdf", replace(cell.robot, links=(link,), joints=()))
    again = read_urdf(tmp_path / "robot.urdf").link(link.name)
    assert np.ptp(again.visual[0].shape.points) == pytest.approx(0.1)
    assert np.ptp(again.collision[0].shape.points) == pytest.approx(0.2)


def test_an_arm_may_stand_at_a_limit(tmp_path):
    cell = read_cell("yumi")
    right, left = cell.arms
    lower, upper, _ = cell.robot.limits(right.joints)
    for home in (lower, upper):
        again = written(tmp_path, replace(cell, arms=(replace(right, home=home), left)))
        np.testing.assert_allclose(again.arms[0].home, home, atol=1e-6)


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_pairs_found_by_trying_are_among_those_that_people_wrote(name):
    cell = read_cell(name)
    found = pairs_without_check(cell)
    assert set(found) <= cell.robot.disabled_pairs
    assert len(found) >= 0.75 * len(cell.robot.disabled_pairs)
    assert found == pairs_without_check(cell)


XACRO = """<robot xmlns:xacro="http://www.ros.org/wiki/xacro" name="r">
  <xacro:arg name="length" default="0.5"/>
  <xacro:macro name="link" params="n size"><link name="link_${n}"><collision><geometry>
    <box size="${size} 0.1 0.1"/></geometry></collision></link></xacro:macro>
  <xacro:link n="1" size="$(arg length)"/>
</robot>"""


def test_xacro_is_expanded_with_its_arguments(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(XACRO)
    assert is_xacro(path)
    with pytest.raises(FileError, match="workbench cell new"):
        read_urdf(path)
    for arguments, size in (({}, 0.5), ({"length": "0.8"}, 0.8)):
        robot = read_description(path, arguments=arguments).robot
        assert robot.link("link_1").collision[0].shape.size[0] == size


@pytest.mark.parametrize(
    "text",
    [
        XACRO.replace("${n}", "${unknown}"),
        XACRO.replace("${n}", "${__import__('os').getpid()}"),
        XACRO.replace(
            '<xacro:link n="1" size="$(arg length)"/>', '<xacro:include filename="no.xacro"/>'
        ),
        XACRO.replace("</robot>", ""),
    ],
    ids=["unknown name", "code", "missing include", "not closed"],
)
def test_xacro_that_cannot_be_expanded_says_so(tmp_path, text):
    path = tmp_path / "robot.xacro"
    path.write_text(text)
    with pytest.raises(FileError, match="cannot be expanded by xacro"):
        expand_xacro(path, {})


def test_a_bin_without_walls_comes_back_without_them(tmp_path):
    cell = read_cell("yumi")
    table = replace(cell, bin=replace(cell.bin, has_walls=False))
    assert not written(tmp_path, table).bin.has_walls


def test_where_a_hand_drops_back_comes_back(tmp_path):
    cell = read_cell("yumi")
    place = (0.4, -0.05, 0.35)
    with_place = replace(cell, bin=replace(cell.bin, p_world_drop=place))
    assert written(tmp_path, with_place).bin.p_world_drop == pytest.approx(place)
    assert with_place.digest != cell.digest and cell.bin.p_world_drop is None


def test_regions_come_back(tmp_path):
    cell = read_cell("yumi")
    one = Region(
        'a "b"', pose_from_rpy((0.01, -0.02, 0.0), (0, 0, 0.5)), np.array([0.1, 0.05, 0.2])
    )
    (again,) = written(tmp_path, replace(cell, bin=replace(cell.bin, regions=(one,)))).bin.regions
    assert again.name == one.name and again.T_bin_region.isApprox(one.T_bin_region, 1e-6)
    np.testing.assert_allclose(again.size, one.size)
