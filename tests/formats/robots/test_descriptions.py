"""What makers leave open or do wrong in a URDF, and what is assumed."""

from pathlib import Path

import made_arm
import numpy as np
import pytest
import trimesh

from workbench.formats.files.whole_files import POINTER, PointerError
from workbench.formats.robots.descriptions import Description, read_description
from workbench.formats.robots.urdf import read_urdf
from workbench.model.errors import FileError
from workbench.model.geometry import Box, Mesh

LIMIT = 'lower="-2.97" upper="2.97" velocity="3.5"'
MESHES = """<visual><geometry><mesh filename="{0}"{2}/></geometry></visual>
<collision><geometry><mesh filename="{1}"{3}/></geometry></collision>"""

EMPTY_DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset><up_axis>Z_UP</up_axis></asset><library_geometries/><library_visual_scenes>
<visual_scene id="all"/></library_visual_scenes><scene><instance_visual_scene url="#all"/></scene>
</COLLADA>"""


TRIANGLE_DAE = """<?xml version="1.0"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1">
<asset>{unit}<up_axis>Z_UP</up_axis></asset>
<library_geometries><geometry id="g"><mesh>
<source id="s"><float_array id="f" count="9">0 0 0 10 0 0 0 10 0</float_array><technique_common>
<accessor source="#f" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#s"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles>
</mesh></geometry></library_geometries>
<library_visual_scenes><visual_scene id="all"><node><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#all"/></scene>
</COLLADA>"""


def described(tmp_path: Path, text: str, **options) -> Description:
    return read_description(made_arm.written(tmp_path / "urdf" / "arm.urdf", text), **options)


def with_meshes(visual: str, collision: str, *, drawn: str = "", checked: str = "") -> str:
    body = MESHES.format(visual, collision, drawn, checked)
    return made_arm.arm(
        more=f'<link name="extra">{body}</link>'
        '<joint name="m" type="fixed"><parent link="base"/><child link="extra"/></joint>'
    )


def box_file(path: Path, size: float, kind: str = ".stl") -> Path:
    path.parent.mkdir(parents=True, exist_ok=True)
    trimesh.creation.box(extents=(size, size / 2, size / 4)).export(path.with_suffix(kind))
    return path


def size_of(found: Description, link: str, drawn: bool = True) -> float:
    link = found.robot.link(link)
    (solid,) = link.visual if drawn else link.collision
    assert isinstance(solid.shape, Mesh)
    return float(np.ptp(solid.shape.points, axis=0).max())


def test_meshes_of_another_package_are_found_beside_it(tmp_path):
    made_arm.package(tmp_path / "arm_support", "arm_support")
    other = made_arm.package(tmp_path / "meshes_of_all", "arm_resources")
    box_file(other / "meshes" / "foot.stl", 0.2)
    text = with_meshes(
        "package://arm_resources/meshes/foot.stl", "package://arm_resources/meshes/FOOT.STL"
    )
    found = read_description(made_arm.written(tmp_path / "arm_support" / "urdf" / "a.urdf", text))
    assert size_of(found, "extra") == pytest.approx(0.2)
    assert found.notes == ()


@pytest.mark.parametrize(
    "name",
    [
        "meshes/foot.stl",
        "../meshes/foot.stl",
        r"..\meshes\foot.stl",
        "file://../meshes/foot.stl",
        "package://any/meshes/foot.stl",
        "model://any/meshes/foot.stl",
        "meshes/Foot.STL",
    ],
)
def test_a_mesh_is_found_by_the_names_that_people_write(tmp_path, name):
    made_arm.package(tmp_path / "any", "any")
    box_file(tmp_path / "any" / "meshes" / "foot.stl", 0.2)
    found = described(tmp_path / "any", with_meshes(name, name))
    assert size_of(found, "extra") == pytest.approx(0.2)


def test_a_mesh_that_is_drawn_alone_may_be_missing(tmp_path):
    box_file(tmp_path / "urdf" / "foot.stl", 0.2)
    found = described(tmp_path, with_meshes("gone.stl", "foot.stl"))
    assert size_of(found, "extra") == pytest.approx(0.2)
    assert any("gone.stl" in note and "is not drawn as it is" in note for note in found.notes)
    found = described(tmp_path, with_meshes("foot.stl", "gone.stl"))
    assert found.robot.link("extra").collision == ()
    assert any("what is drawn is checked in its place" in note for note in found.notes)
    with pytest.raises(FileError, match=r"gone\.stl"):
        described(tmp_path, with_meshes("gone.stl", "gone.stl"))


def test_a_flat_mesh_may_be_drawn(tmp_path):
    box_file(tmp_path / "urdf" / "foot.stl", 0.2)
    made_arm.written(tmp_path / "urdf" / "flat.stl", "solid flat\nendsolid flat\n")
    for bad in ('flat.stl"', 'foot.stl" scale="1 0 1"'):
        text = with_meshes("visual.stl", "foot.stl").replace('visual.stl"', bad)
        found = described(tmp_path, text)
        assert size_of(found, "extra") == pytest.approx(0.2)
        assert any("is not drawn as it is" in note for note in found.notes)


def test_a_link_whose_mesh_file_is_whole_and_empty_has_no_shape(tmp_path):
    made_arm.written(tmp_path / "urdf" / "nothing.dae", EMPTY_DAE)
    found = described(tmp_path, with_meshes("nothing.dae", "nothing.dae"))
    assert found.robot.link("extra").collision == found.robot.link("extra").visual == ()
    assert any("nothing.dae holds no triangles: nothing is checked" in one for one in found.notes)
    box_file(tmp_path / "urdf" / "foot.stl", 0.2)
    found = described(tmp_path, with_meshes("foot.stl", "nothing.dae"))
    assert any("what is drawn is checked in its place" in note for note in found.notes)
    with pytest.raises(FileError, match=r"nothing\.dae: holds no triangles"):
        read_urdf(tmp_path / "urdf" / "arm.urdf")


def test_a_pointer_of_git_lfs_is_named_whatever_it_stands_for(tmp_path):
    pointer = tmp_path / "urdf" / "foot.stl"
    made_arm.written(pointer, POINTER.decode() + "v1\noid sha256:0\nsize 99\n")
    for name in ("foot.stl", "foot.dae"):
        pointer = pointer.rename(pointer.with_name(name))
        with pytest.raises(PointerError, match=rf"{name}: is a pointer of git-lfs: fetch the file"):
            described(tmp_path, with_meshes(name, name))
    with pytest.raises(PointerError):
        read_description(pointer.rename(pointer.with_name("arm.urdf")))


def test_meshes_in_mm_are_noticed(tmp_path):
    box_file(tmp_path / "urdf" / "foot.stl", 200)
    found = described(tmp_path, with_meshes("foot.stl", "foot.stl"))
    assert size_of(found, "extra") == pytest.approx(0.2)
    assert any("are taken to be in mm" in note for note in found.notes)
    found = described(tmp_path, with_meshes("foot.stl", "foot.stl"), mesh_unit="mm")
    assert size_of(found, "extra") == pytest.approx(0.2)
    assert found.notes == ()
    with pytest.raises(FileError, match="would be 200 m large"):
        described(tmp_path, with_meshes("foot.stl", "foot.stl"), mesh_unit="m")


def test_a_dae_file_is_read_in_the_unit_that_it_states(tmp_path):
    triangle = TRIANGLE_DAE.format(unit='<unit name="inch" meter="0.0254"/>')
    made_arm.written(tmp_path / "urdf" / "foot.dae", triangle)
    box_file(tmp_path / "urdf" / "foot.stl", 0.254)
    found = described(tmp_path, with_meshes("foot.dae", "foot.stl"))
    assert size_of(found, "extra") == pytest.approx(10 * 0.0254)
    made_arm.written(tmp_path / "urdf" / "foot.dae", TRIANGLE_DAE.format(unit=""))
    found = described(tmp_path, with_meshes("foot.dae", "foot.stl"))
    assert size_of(found, "extra") == pytest.approx(10)


def test_a_unit_is_asked_only_of_files_that_do_not_say_it(tmp_path):
    scale = ' scale="0.001 0.001 0.001"'
    box_file(tmp_path / "urdf" / "foot.stl", 200)
    box_file(tmp_path / "urdf" / "foot.glb", 0.2, ".glb")
    for drawn in ("foot.glb", "foot.stl"):
        text = with_meshes(drawn, "foot.stl", drawn="" if drawn.endswith("glb") else scale)
        for unit in ("mm", None):
            found = described(tmp_path, text, mesh_unit=unit)
            assert size_of(found, "extra") == pytest.approx(0.2)
            assert size_of(found, "extra", drawn=False) == pytest.approx(0.2)
    assert any("scale is given for its visual alone" in note for note in found.notes)


def test_a_link_of_two_units_is_refused(tmp_path):
    box_file(tmp_path / "urdf" / "small.stl", 0.2)
    box_file(tmp_path / "urdf" / "large.stl", 15)
    scale = ' scale="0.01 0.01 0.01"'
    with pytest.raises(
        FileError, match=r"link 'extra'.* differ a thousandfold \(2 mm and 1.5e\+04 mm\)"
    ):
        described(tmp_path, with_meshes("small.stl", "large.stl", drawn=scale))
    with pytest.raises(FileError, match=r"its largest mesh would be 0\.2 mm"):
        described(tmp_path, with_meshes("small.stl", "small.stl"), mesh_unit="mm")


def test_a_plane_without_thickness_is_thin(tmp_path):
    plane = f'<link name="plane">{made_arm.box((5, 5, 0))}</link>'
    mount = '<joint name="p" type="fixed"><parent link="base"/><child link="plane"/></joint>'
    found = described(tmp_path, made_arm.arm(more=plane + mount))
    (solid,) = found.robot.link("plane").collision
    assert isinstance(solid.shape, Box) and list(solid.shape.size) == [5, 5, 0.001]
    assert any("is taken to be 1 mm thick" in note for note in found.notes)
    with pytest.raises(FileError, match="size=5 5 0: must be positive"):
        read_urdf(tmp_path / "urdf" / "arm.urdf")


@pytest.mark.parametrize("speed", ["velocity='0'", "", "velocity='100'", "velocity='1e6'"])
def test_a_speed_that_is_not_given_is_assumed_and_told(tmp_path, speed):
    text = made_arm.arm().replace(LIMIT, f'lower="-2.97" upper="2.97" {speed}')
    found = described(tmp_path, text)
    assert found.robot.joint("a1").velocity == 1.0
    (note,) = found.notes
    assert "joint 'a1'" in note and "1 rad/s is assumed; set velocity in robot.urdf" in note


@pytest.mark.parametrize(
    ("low", "high"), [(-6.98, 6.98), (-7.854, 7.854), (0, 9.42), (-12.5, 12.5)]
)
def test_limits_of_several_turns_are_as_the_maker_says(tmp_path, low, high):
    text = made_arm.arm().replace(LIMIT, f'lower="{low}" upper="{high}" velocity="3"')
    joint = described(tmp_path, text).robot.joint("a1")
    assert (joint.lower, joint.upper) == (low, high)


@pytest.mark.parametrize(
    "limit",
    [
        '<limit lower="-1e16" upper="1e16" velocity="3" effort="1"/>',
        '<limit velocity="3" effort="1"/>',
        "",
    ],
)
def test_a_joint_that_turns_without_end_turns_once_either_way(tmp_path, limit):
    kind = 'type="revolute"' if "1e16" in limit else 'type="continuous"'
    text = made_arm.arm().replace(f'<limit {LIMIT} effort="100"/>', limit, 1)
    text = text.replace('name="a1" type="revolute"', f'name="a1" {kind}')
    joint = described(tmp_path, text).robot.joint("a1")
    assert (joint.lower, joint.upper) == (-2 * np.pi, 2 * np.pi)


def test_a_joint_without_a_range_or_a_motor_stands_still(tmp_path):
    text = made_arm.arm().replace(LIMIT, 'lower="0" upper="0" velocity="3"')
    text = text.replace(
        "</robot>",
        '<link name="world"/><joint name="w" type="floating">'
        '<parent link="world"/><child link="base"/></joint></robot>',
    )
    found = described(tmp_path, text)
    assert found.robot.joint("a1").kind == found.robot.joint("w").kind == "fixed"
    assert len(found.notes) == 1 and "stands still" in found.notes[0]


def test_a_joint_that_follows_another_is_kept_with_what_it_follows(tmp_path):
    more = '<link name="rod"/>' + made_arm.turning(
        "r", "s1", "rod", '<mimic joint="a2" multiplier="-2" offset="0.5"/>'
    )
    found = described(tmp_path, made_arm.arm(more=more))
    (rod,) = found.followers
    assert (rod.joint.name, rod.leader, rod.factor, rod.offset) == ("r", "a2", -2, 0.5)
    angle = np.arctan2(*rod.at(0.3).T_parent_joint.rotation[[1, 0], [0, 0]])
    assert angle == pytest.approx(-0.1)


def test_a_joint_that_follows_one_that_is_not_there_stands_still(tmp_path):
    follows = made_arm.turning("rod", "s1", "extra", '<mimic joint="gone"/>')
    text = made_arm.arm(more=f'<link name="extra"/>{follows}')
    found = described(tmp_path, text)
    assert found.robot.joint("rod").kind == "fixed" and not found.followers
    assert any("there is no joint 'gone' to mimic: it stands still" in one for one in found.notes)
    with pytest.raises(FileError, match="there is no joint 'gone' to mimic"):
        read_urdf(made_arm.written(tmp_path / "arm.urdf", text))


def test_a_closed_chain_is_named_with_what_to_leave_out(tmp_path):
    more = made_arm.turning("rod", "s1", "s3")
    with pytest.raises(FileError, match=r"link 's3' is the child of 2 joints \('a3', 'rod'\)"):
        described(tmp_path, made_arm.arm(more=more))


def test_many_faults_of_a_kind_are_one_sentence(tmp_path):
    text = made_arm.arm().replace('velocity="3.5"', 'velocity="0"')
    (note,) = described(tmp_path, text).notes
    assert "(and 5 more)" in note
