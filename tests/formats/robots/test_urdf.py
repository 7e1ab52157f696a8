"""Robot descriptions, good and broken."""

import re
from pathlib import Path

import numpy as np
import pytest
import trimesh
from hypothesis import HealthCheck, given, settings
from mutations import mutated, only_file_errors

from workbench.formats.meshes.reading import MOST_NEIGHBOURS, most_neighbours
from workbench.formats.meshes.triangles import stl_of, triangles_of
from workbench.formats.robots.urdf import read_srdf, read_urdf
from workbench.model.errors import FileError
from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Sphere

ARM = """<robot name="arm">
  <material name="red"><color rgba="1 0 0 1"/></material>
  <link name="base">
    <visual><geometry><box size="0.1 0.2 0.3"/></geometry><material name="red"/></visual>
    <collision>
      <origin xyz="0 0 0.5" rpy="0 0 1"/><geometry><box size="0.1 0.2 0.3"/></geometry>
    </collision>
    <collision><geometry><sphere radius="0.05"/></geometry></collision>
  </link>
  <link name="upper">
    <collision><geometry><cylinder radius="0.1" length="0.4"/></geometry></collision>
  </link>
  <link name="lower">
    <collision><geometry><capsule radius="0.1" length="0.4"/></geometry></collision>
  </link>
  <link name="hand"/>
  <joint name="slide" type="prismatic">
    <parent link="upper"/><child link="lower"/><axis xyz="0 0 2"/>
    <limit lower="0" upper="0.3" velocity="0.5" effort="1"/>
  </joint>
  <joint name="turn" type="revolute">
    <parent link="base"/><child link="upper"/>
    <origin xyz="0 0 1" rpy="0.1 0.2 0.3"/><axis xyz="0 1 0"/>
    <limit lower="-1" upper="2" velocity="3" effort="1"/>
  </joint>
  <joint name="mount" type="fixed"><parent link="lower"/><child link="hand"/></joint>
</robot>
"""


def written(tmp_path: Path, text: str) -> Path:
    path = tmp_path / "arm.urdf"
    path.write_text(text, encoding="utf-8")
    return path


def with_mesh(tmp_path: Path, attributes: str) -> Path:
    return written(tmp_path, ARM.replace('<box size="0.1 0.2 0.3"/>', f"<mesh {attributes}/>", 1))


def test_links_joints_and_shapes_are_read(tmp_path: Path) -> None:
    robot = read_urdf(written(tmp_path, ARM))
    assert robot.root == "base"
    assert [joint.name for joint in robot.chain("hand")] == ["turn", "slide", "mount"]
    base = robot.link("base")
    assert isinstance(base.collision[0].shape, Box)
    assert base.collision[0].shape.size.tolist() == [0.1, 0.2, 0.3]
    assert base.collision[0].T_owner_shape.translation.tolist() == [0, 0, 0.5]
    assert base.collision[1].shape.kind == "sphere"
    assert base.visual[0].colour == (1, 0, 0)
    assert isinstance(robot.link("upper").collision[0].shape, Cylinder)
    assert isinstance(robot.link("lower").collision[0].shape, Capsule)
    assert robot.joint("slide").axis.tolist() == [0, 0, 1]
    assert (robot.joint("turn").lower, robot.joint("turn").upper) == (-1, 2)


def test_a_continuous_joint_turns_two_times(tmp_path: Path) -> None:
    text = ARM.replace('type="revolute"', 'type="continuous"').replace('lower="-1" upper="2" ', "")
    joint = read_urdf(written(tmp_path, text)).joint("turn")
    assert (joint.kind, joint.lower, joint.upper) == ("revolute", -2 * np.pi, 2 * np.pi)


def test_a_wheel_without_a_limit_stands_still(tmp_path: Path) -> None:
    text = re.sub(r'(<joint name="turn".*?)<limit [^>]*/>', r"\1", ARM, flags=re.DOTALL)
    assert text != ARM
    with pytest.raises(FileError, match="has no <limit> with lower, upper and velocity"):
        read_urdf(written(tmp_path, text))
    wheel = text.replace('type="revolute"', 'type="continuous"')
    assert read_urdf(written(tmp_path, wheel)).joint("turn").kind == "fixed"


def test_a_joint_that_mimics_another_is_none_of_its_own(tmp_path: Path) -> None:
    text = ARM.replace('<axis xyz="0 0 2"/>', '<axis xyz="0 0 2"/><mimic joint="turn"/>')
    robot = read_urdf(written(tmp_path, text))
    assert [joint.kind for joint in robot.joints] == ["revolute", "fixed", "fixed"]


def test_a_mesh_is_scaled_and_made_convex_when_asked(tmp_path: Path) -> None:
    (tmp_path / "ball.stl").write_bytes(stl_of(triangles_of(Sphere(100.0))))
    path = with_mesh(tmp_path, 'filename="ball.stl" scale="0.001 0.001 0.001"')
    mesh = read_urdf(path).link("base").visual[0].shape
    assert isinstance(mesh, Mesh)
    assert np.ptp(mesh.points, axis=0) == pytest.approx([0.2, 0.2, 0.2])
    text = path.read_text(encoding="utf-8").replace("visual", "collision")
    hull = read_urdf(written(tmp_path, text), collision="hull").link("base").collision[0].shape
    assert isinstance(hull, Mesh)
    assert hull.is_convex
    kept = read_urdf(written(tmp_path, text), collision="hull", hull_except=("base",))
    assert not getattr(kept.link("base").collision[0].shape, "is_convex", True)


@pytest.mark.parametrize("scale", [(1, -1, 1), (-1, -1, -1), (1, -1, -1), (-0.5, 2, 0.001)])
def test_a_mirrored_mesh_has_its_outside_outside(tmp_path: Path, scale) -> None:
    # Longer to one side of each axis, so that a mirrored one is another.
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], float) * 0.1
    solid = trimesh.Trimesh(points, [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], process=False)
    assert solid.volume > 0
    (tmp_path / "tip.stl").write_bytes(stl_of(solid))
    solid.export(tmp_path / "tip.convex.obj")
    written_so = " ".join(map(str, scale))
    for file in ("tip.stl", "tip.convex.obj"):
        robot = read_urdf(with_mesh(tmp_path, f'filename="{file}" scale="{written_so}"'))
        mesh = robot.link("base").visual[0].shape
        assert isinstance(mesh, Mesh)
        seen = trimesh.Trimesh(mesh.points, mesh.triangles)
        assert seen.volume == pytest.approx(solid.volume * abs(np.prod(scale)), rel=1e-4)
        ends = np.array(scale) * [0.1, 0.2, 0.3]
        assert seen.bounds == pytest.approx(np.sort([[0, 0, 0], ends], axis=0), abs=1e-6)


def test_a_mesh_without_a_height_is_refused(tmp_path: Path) -> None:
    (tmp_path / "ball.stl").write_bytes(stl_of(triangles_of(Sphere(0.1))))
    with pytest.raises(FileError, match=r"scale=1 0 1: would make it flat"):
        read_urdf(with_mesh(tmp_path, 'filename="ball.stl" scale="1 0 1"'))


def test_half_a_mesh_is_said_to_be_cut_off(tmp_path: Path) -> None:
    whole = stl_of(triangles_of(Sphere(0.1)))
    (tmp_path / "ball.stl").write_bytes(whole[: len(whole) // 2])
    with pytest.raises(FileError, match=r"is cut off: of 1280 triangles that it has, 639 are"):
        read_urdf(with_mesh(tmp_path, 'filename="ball.stl"'))


def test_a_package_is_a_folder_here_or_above(tmp_path: Path) -> None:
    inner = tmp_path / "my_robot" / "urdf"
    inner.mkdir(parents=True)
    meshes = tmp_path / "my_robot" / "meshes"
    meshes.mkdir()
    (meshes / "ball.stl").write_bytes(stl_of(triangles_of(Sphere(0.1))))
    path = with_mesh(inner, 'filename="package://my_robot/meshes/ball.stl"')
    assert isinstance(read_urdf(path).link("base").visual[0].shape, Mesh)


def test_a_mesh_that_another_machine_named_is_found_in_its_package(tmp_path: Path) -> None:
    meshes = tmp_path / "my_robot" / "meshes"
    meshes.mkdir(parents=True)
    (tmp_path / "my_robot" / "package.xml").write_text("<package><name>my_robot</name></package>")
    (meshes / "ball.stl").write_bytes(stl_of(triangles_of(Sphere(0.1))))
    inner = tmp_path / "urdf"
    inner.mkdir()
    place = "/home/other/install/my_robot/share/my_robot/meshes/ball.stl"
    for named in (f"file://{place}", place):
        robot = read_urdf(with_mesh(inner, f'filename="{named}"'))
        assert isinstance(robot.link("base").visual[0].shape, Mesh)


def test_a_hull_with_a_corner_of_many_edges_can_be_checked(tmp_path: Path) -> None:
    trimesh.creation.cone(0.1, 0.2, sections=300).export(tmp_path / "cone.stl")
    path = with_mesh(tmp_path, 'filename="cone.stl"')
    path.write_text(path.read_text(encoding="utf-8").replace("visual", "collision"))
    hull = read_urdf(path, collision="hull").link("base").collision[0].shape
    assert isinstance(hull, Mesh)
    assert most_neighbours(hull) <= MOST_NEIGHBOURS


def test_a_piece_that_is_not_convex_is_refused(tmp_path: Path) -> None:
    two = triangles_of(Sphere(0.1)) + triangles_of(Sphere(0.1)).apply_translation([1, 0, 0])
    two.export(tmp_path / "two.convex.obj")
    with pytest.raises(FileError, match=r"two\.convex\.obj: is called convex, but a corner lies"):
        read_urdf(with_mesh(tmp_path, 'filename="two.convex.obj"'))


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ("<robot", "<machine", "is not valid XML"),
        ('velocity="3"', "", "<limit>: has no velocity"),
        ('velocity="3"', 'velocity="180"', "rad/s are expected"),
        ('lower="-1" upper="2"', 'lower="-170" upper="170"', "radians are expected"),
        ('lower="0" upper="0.3"', 'lower="0" upper="300"', "metres are expected"),
        ('lower="-1" upper="2"', 'lower="2" upper="-1"', "is not less than"),
        ('lower="-1"', 'lower="nan"', "one number is expected"),
        ('xyz="0 1 0"', 'xyz="0 0 0"', "has no direction"),
        ('xyz="0 1 0"', 'xyz="0 1"', "3 numbers are expected"),
        ('<child link="hand"/>', '<child link="foot"/>', "there is no link 'foot'"),
        ('<parent link="base"/>', '<parent link="hand"/>', "root"),
        ('name="slide"', 'name="turn"', "joint 'turn' is there 2 times"),
        ('<link name="hand"/>', '<link name="hand"/><link name="hand"/>', "is there twice"),
        ('<sphere radius="0.05"/>', '<cone radius="0.05"/>', "is no known geometry"),
        ('<sphere radius="0.05"/>', '<sphere radius="-1"/>', "must be positive"),
        ('<sphere radius="0.05"/>', '<sphere radius="50"/>', "these look like millimetres"),
        ('<sphere radius="0.05"/>', '<mesh filename="gone.stl"/>', "there is no such file"),
        ('rpy="0.1 0.2 0.3"', 'rpy="90 0 0"', "these look like degrees"),
        ('type="revolute"', 'type="floating"', "floating"),
        ("<robot ", '<!DOCTYPE robot [<!ENTITY a "b">]><robot ', "document type"),
    ],
)
def test_what_is_wrong_is_named(tmp_path: Path, old: str, new: str, problem: str) -> None:
    assert old in ARM
    with pytest.raises(FileError, match=r"arm\.urdf") as caught:
        read_urdf(written(tmp_path, ARM.replace(old, new, 1)))
    assert problem in str(caught.value)


@given(content=mutated(ARM.encode()))
@settings(
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.function_scoped_fixture],
    max_examples=150,
)
def test_no_file_is_worse_than_an_error(tmp_path: Path, content: bytes) -> None:
    only_file_errors(tmp_path / "arm.urdf", content, read_urdf)


def test_disabled_pairs_are_read_in_one_order(tmp_path: Path) -> None:
    path = tmp_path / "arm.srdf"
    path.write_text('<robot name="a"><disable_collisions link1="b" link2="a"/></robot>')
    assert read_srdf(path) == {("a", "b")}
    path.write_text('<robot name="a"><disable_collisions link1="b"/></robot>')
    with pytest.raises(FileError, match="has no link2"):
        read_srdf(path)
