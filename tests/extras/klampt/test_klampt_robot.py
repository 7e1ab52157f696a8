"""Klamp't robots and worlds: read as Klamp't itself reads them."""

import json
import subprocess
import sys
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from workbench.cli.main import main
from workbench.extras.klampt.robot_writer import write_rob
from workbench.extras.klampt.robots import read_rob
from workbench.extras.klampt.urdf_writer import depth_first
from workbench.extras.klampt.world_reader import read_klampt_world
from workbench.extras.klampt.worlds import Snapshot, robot_with_tools
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.xml_elements import read_xml
from workbench.model.errors import FileError
from workbench.model.geometry import Mesh
from workbench.model.robot import Robot

HERE = Path(__file__).parents[1]
LINKS = 6


def klampt_says(path: Path, configurations) -> dict:
    ran = subprocess.run(
        [sys.executable, str(HERE / "klampt_answers.py"), str(path)],
        input=json.dumps([list(map(float, q)) for q in configurations]),
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert ran.returncode == 0, ran.stderr
    return json.loads(ran.stdout)


def poses(robot: Robot, q: dict[str, float]) -> dict[str, pin.SE3]:
    Ts = {robot.root: pin.SE3.Identity()}
    for joint in robot.joints:
        T = Ts[joint.parent] * joint.T_parent_joint
        value = q.get(joint.name, 0.0)
        if joint.kind == "revolute":
            T = T * pin.SE3(pin.exp3(np.asarray(joint.axis) * value), np.zeros(3))
        elif joint.kind == "prismatic":
            T = T * pin.SE3(np.eye(3), np.asarray(joint.axis) * value)
        Ts[joint.child] = T
    return Ts


def listed(values) -> str:
    return " ".join(repr(float(value)) for value in np.ravel(values))


def rob(seed: int, *, by_table: bool = False) -> str:
    """A random tree of `LINKS` links, by transforms or by a Denavit-Hartenberg table."""
    rng = np.random.default_rng(seed)
    parents = [-1, *(int(rng.integers(max(0, k - 2), k)) for k in range(1, LINKS))]
    lines = [
        "links " + " ".join(f'"link {k}"' for k in range(LINKS)),
        "parents " + " ".join(map(str, parents)) + "   # who hangs on whom",
        "JointType " + " ".join(rng.choice(["r", "p"], LINKS)),
        f"translation {listed(rng.uniform(-1, 1, 3))}",
        f"qMinDeg {listed([-100] * LINKS)}",
        f"qMaxDeg {listed([100] * LINKS)}",
        f"velmax {listed([1] * LINKS)}",
        f"mass {listed([1] * LINKS)}",
        f"com {listed(np.zeros(3 * LINKS))}",
        f"inertiadiag {listed(np.ones(3 * LINKS))}",
    ]
    if by_table:
        lines += [
            f"alphadeg {listed(rng.uniform(-180, 180, LINKS))}",
            f"a {listed(rng.uniform(-1, 1, LINKS))}",
            f"d {listed(rng.uniform(-1, 1, LINKS))}",
            f"theta {listed(rng.uniform(-3, 3, LINKS))}",
        ]
    else:
        turns = Rotation.random(LINKS, random_state=seed).as_matrix().reshape(LINKS, 9)
        rows = np.column_stack([turns, rng.uniform(-1, 1, (LINKS, 3))])
        axes = rng.normal(size=(LINKS, 3))
        axes /= np.linalg.norm(axes, axis=1, keepdims=True)
        lines += [
            "TParent " + " \\\n".join(map(listed, rows)),
            f"axis {listed(axes)}",
        ]
    return "\n".join(lines) + "\n"


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("by_table", [False, True], ids=["transforms", "table"])
def test_the_same_configuration_gives_the_same_link_poses_as_klampt(tmp_path, seed, by_table):
    path = tmp_path / "robot.rob"
    path.write_text(rob(seed, by_table=by_table))
    rng = np.random.default_rng(seed)
    configurations = rng.uniform(-1.5, 1.5, (5, LINKS))
    told = klampt_says(path, configurations)
    robot = read_rob(path)
    for q, theirs in zip(configurations, told["poses"], strict=True):
        ours = poses(robot, dict(zip(told["links"], q, strict=True)))
        for name, T in zip(told["links"], theirs, strict=True):
            np.testing.assert_allclose(ours[name].homogeneous[:3], T, atol=1e-9)


def test_a_mounted_robot_stands_where_klampt_has_it(tmp_path):
    (tmp_path / "sub.rob").write_text(rob(7).replace("link ", "sub "))
    turn = Rotation.random(random_state=3).as_matrix()
    mount = f'mount 3 "sub.rob" {listed(turn)} 0.1 0.2 0.3\nrotation {listed(turn)}\n'
    (tmp_path / "robot.rob").write_text(rob(1) + mount)
    configurations = np.random.default_rng(0).uniform(-1, 1, (3, 2 * LINKS))
    told = klampt_says(tmp_path / "robot.rob", configurations)
    robot = read_rob(tmp_path / "robot.rob")
    for q, theirs in zip(configurations, told["poses"], strict=True):
        ours = poses(robot, dict(zip(told["links"], q, strict=True)))
        for name, T in zip(told["links"], theirs, strict=True):
            np.testing.assert_allclose(ours[name].homogeneous[:3], T, atol=1e-9)


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_a_robot_that_is_written_is_the_same_to_klampt_and_to_us(name, tmp_path):
    cell = read_cell(name)
    robot = cell.robot
    write_rob(tmp_path / "robot.rob", robot)
    again = read_rob(tmp_path / "robot.rob")
    rng = np.random.default_rng(0)
    joints = depth_first(robot)
    lower = np.array([0.0, *(joint.lower for joint in joints)])
    upper = np.array([0.0, *(joint.upper for joint in joints)])
    configurations = rng.uniform(lower, upper, (6, len(lower)))
    told = klampt_says(tmp_path / "robot.rob", configurations)
    assert told["links"] == [robot.root, *(joint.child for joint in joints)]
    for q, theirs, met in zip(configurations, told["poses"], told["collisions"], strict=True):
        values = dict(zip([joint.name for joint in joints], q[1:], strict=True))
        ours = poses(robot, values)
        back = poses(again, {joint.child: values[joint.name] for joint in joints})
        for link, T in zip(told["links"], theirs, strict=True):
            np.testing.assert_allclose(ours[link].homogeneous[:3], T, atol=1e-9)
            np.testing.assert_allclose(back[link].homogeneous[:3], T, atol=1e-9)
        assert met == collisions(again, {j.child: values[j.name] for j in joints})


def collisions(robot: Robot, q: dict[str, float]) -> list[list[str]]:
    """Pairs of links whose triangles meet, as far as they are checked."""
    Ts, data = poses(robot, q), pin.GeometryModel()
    names: list[str] = []
    model = pin.Model()
    for link in robot.links:
        for solid in link.collision:
            from workbench.planning.collision.bodies import coal_shape

            T = Ts[link.name] * solid.T_owner_shape
            data.addGeometryObject(
                pin.GeometryObject(f"{len(names)}", 0, T, coal_shape(solid.shape))
            )
            names.append(link.name)
    found: list[list[str]] = []
    for i in range(len(names)):
        for j in range(i):
            pair = sorted((names[i], names[j]))
            if tuple(pair) not in robot.disabled_pairs:
                data.addCollisionPair(pin.CollisionPair(j, i))
    geometry = pin.GeometryData(data)
    pin.updateGeometryPlacements(model, model.createData(), data, geometry, np.zeros(0))
    for k, pair in enumerate(data.collisionPairs):
        if pin.computeCollision(data, geometry, k):
            found.append(sorted((names[pair.first], names[pair.second])))
    return sorted(found)


def test_an_exported_world_comes_back_as_a_cell(tmp_path):
    cell = read_cell("yumi")
    assert main(["export-world", "yumi", "--out", str(tmp_path)]) == 0
    robot = read_rob(tmp_path / "robot.rob")
    assert {"right_tool", "left_tool"} <= {link.name for link in robot.links}
    path = tmp_path / "cell" / "world.xml"
    world = read_klampt_world(path)
    assert {thing.name for thing in world.things} == {"bin", "table", "tray_right", "tray_left"}
    config = [float(value) for value in read_xml(path, "world").one("robot").text("config").split()]
    told = klampt_says(path, [config[1:]])
    assert told["terrains"] == len(world.things)
    values = dict(
        zip(
            [j.name for j in depth_first(robot_with_tools(cell, Snapshot()))],
            config[1:],
            strict=True,
        )
    )
    ours = poses(world.robot, values)
    for link, T in zip(told["links"], told["poses"][0], strict=True):
        np.testing.assert_allclose(ours[link].homogeneous[:3], T, atol=1e-9)
    for thing in world.things:
        assert all(isinstance(solid.shape, Mesh) for solid in thing.solids)


WORLD = """<world>
  <robot name="r" file="robot.rob" config="6 0 0 0 0 0 0" position="0.1 0 0"/>
  <rigidObject name="a box" position="1 2 3" rotateZ="0.5">
    <geometry file="box.stl" scale="2" translate="0 0 1"/><display color="1 0 0"/>
  </rigidObject>
  <terrain file="box.stl" scale="1 1 0.5"/>
</world>"""


def test_things_stand_and_are_scaled_as_the_world_says(tmp_path):
    (tmp_path / "robot.rob").write_text(rob(0))
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "box.stl")
    (tmp_path / "world.xml").write_text(WORLD)
    world = read_klampt_world(tmp_path / "world.xml")
    box, floor = world.things
    assert (box.name, floor.name) == ("a_box", "terrain_1")
    assert np.allclose(box.T_world_fixture.translation, [1, 2, 3])
    assert np.allclose(pin.log3(box.T_world_fixture.rotation), [0, 0, 0.5])
    assert np.allclose(np.ptp(box.solids[0].shape.points, axis=0), 2)
    assert np.allclose(box.solids[0].shape.points.mean(axis=0), [0, 0, 1])
    assert box.solids[0].colour == (1.0, 0.0, 0.0)
    assert np.allclose(np.ptp(floor.solids[0].shape.points, axis=0), [1, 1, 0.5])
    assert np.allclose(world.T_world_robot.translation, [0.1, 0, 0])


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("parents -1", "parents 0", "which is not before"),
        ("parents", "parent", "has no line `parents`"),
        ("parents -1", "parents inf", "which is not before"),
        ("JointType", "JointType r", "letters r or p"),
        ("qMinDeg", "qMinDeg 7", "6 numbers are expected, 7 are given"),
        ("qMinDeg", "qMinDeg x", "numbers are expected"),
        ("TParent", "tilt", "neither a line `tparent` nor"),
        ("velmax", "joint floating 5 0\nvelmax", "moves freely"),
        ("velmax", "noselfcollision 0 99\nvelmax", "not the number of a link"),
        ("velmax", "noselfcollision 0\nvelmax", "half a pair"),
        ("velmax", "noselfcollision 0 ²\nvelmax", "'²' is not the number of a link"),
        ("velmax", f"noselfcollision 0 {'9' * 5000}\nvelmax", "not the number of a link"),
        ("qMinDeg -100", "qMinDeg 200", "'link 0' would go from 3.49.* to 1.7"),
        ("qMaxDeg 100", "qMaxDeg -5000", "'link 0' would go from -1.7.* to -87"),
        ("velmax", 'geometry "no.off" "" "" "" "" ""\nvelmax', "there is no such file"),
        ("velmax", 'mount 0 "robot.rob"\nvelmax', "deep"),
        ('"link 1"', '"link 0"', "6 different names"),
        ("velmax", 'links "\nvelmax', "No closing quotation"),
    ],
)
def test_a_broken_robot_says_what_is_wrong(tmp_path, old, new, expected):
    text = rob(0)
    assert old in text
    path = tmp_path / "robot.rob"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(FileError, match=expected):
        read_rob(path)


def with_box(folder: Path, transform: str) -> Path:
    """A robot whose first link has a box of 1 m from the origin on, moved by a transform."""
    box = trimesh.creation.box((1, 1, 1))
    box.apply_translation((0.5, 0.5, 0.5))
    box.export(folder / "box.stl")
    path = folder / "robot.rob"
    path.write_text(
        rob(0) + f'geometry "box.stl" {"".join(LINKS * [chr(34) * 2 + " "])[3:]}\n'
        f"geomtransform 0 {transform} 0 0 0 1\n"
    )
    return path


def test_a_mesh_that_is_mirrored_keeps_its_outside(tmp_path):
    path = with_box(tmp_path, "-2 0 0 0 0 1 0 0.5 0 0 1 0")
    mesh = read_rob(path).link("link 0").collision[0].shape
    seen = trimesh.Trimesh(mesh.points, mesh.triangles)
    np.testing.assert_allclose(seen.bounds, [[-2, 0.5, 0], [0, 1.5, 1]])
    assert seen.volume == pytest.approx(2.0)


@pytest.mark.parametrize(
    "transform",
    ["inf 0 0 0 0 1 0 0 0 0 1 0", "1 0 0 -inf 0 1 0 0 0 0 1 0", "1 0 0 0 0 1 0 0 0 0 0 0",
     "1 0 0 1e300 0 1 0 0 0 0 1 0"],
)  # fmt: skip
def test_a_transform_that_puts_a_mesh_nowhere_is_refused(tmp_path, transform):
    with pytest.raises(FileError, match=r"geomtransform: .* puts no mesh anywhere"):
        read_rob(with_box(tmp_path, transform))


@pytest.mark.parametrize("item", ["a", "d", "theta"])
def test_a_table_with_a_number_that_is_not_finite_is_refused(tmp_path, item):
    path = tmp_path / "robot.rob"
    lines = [
        f"{item} inf{' 0' * (LINKS - 1)}" if line.startswith(f"{item} ") else line
        for line in rob(0, by_table=True).splitlines()
    ]
    path.write_text("\n".join(lines) + "\n")
    with pytest.raises(FileError, match="alpha, theta, a, d: finite numbers are expected"):
        read_rob(path)


def test_an_axis_that_is_no_unit_vector_is_refused(tmp_path):
    """Klamp't would turn the joint by so much more;."""
    path = tmp_path / "robot.rob"
    for axis in ("0 0 2", "0 0 0", "0 0 inf"):
        path.write_text(rob(0, by_table=True) + f"axis {axis} {'0 0 1 ' * (LINKS - 1)}\n")
        with pytest.raises(FileError, match="axis: must be a unit vector"):
            read_rob(path)


@settings(max_examples=150, deadline=None)
@given(st.data())
def test_no_text_is_too_strange(tmp_path_factory, data):
    """Whatever a file holds: a robot or a clear error."""
    text = rob(data.draw(st.integers(0, 20)))
    for _ in range(data.draw(st.integers(1, 4))):
        start = data.draw(st.integers(0, len(text) - 1))
        end = min(len(text), start + data.draw(st.integers(0, 40)))
        text = text[:start] + data.draw(st.text(max_size=10)) + text[end:]
    path = tmp_path_factory.mktemp("rob") / "robot.rob"
    path.write_bytes(text.encode("utf-8", "surrogatepass"))
    try:
        assert isinstance(read_rob(path), Robot)
    except FileError as error:
        assert "robot.rob" in str(error)


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ("<robot ", "<robat ", "has 0 robots"),
        ('file="robot.rob"', 'file="other.rob"', "the folder of the world has no such file"),
        ('color="1 0 0', 'color="red', "color"),
        ('scale="2"', 'scale="-2"', "must be positive"),
        ("1 2 3", "1 2", "3 numbers are expected"),
    ],
)
def test_a_broken_world_says_what_is_wrong(tmp_path, old, new, expected):
    (tmp_path / "robot.rob").write_text(rob(0))
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "box.stl")
    (tmp_path / "world.xml").write_text(WORLD.replace(old, new, 1))
    with pytest.raises(FileError, match=expected):
        read_klampt_world(tmp_path / "world.xml")


@pytest.mark.parametrize(("scale", "size"), [("2", 2.0), ("1e-3", 1e-3), (".", None), ("-1", None)])
def test_a_rigid_object_is_as_large_as_its_file_says(tmp_path, scale, size):
    trimesh.creation.box((1, 1, 1)).export(tmp_path / "box.stl")
    (tmp_path / "thing.obj").write_text(f"mesh box.stl\ngeomscale {scale}\n")
    (tmp_path / "robot.rob").write_text(rob(0))
    (tmp_path / "world.xml").write_text(
        '<world><robot file="robot.rob"/><rigidObject name="box" file="thing.obj"/></world>'
    )
    if size is None:
        with pytest.raises(FileError, match="is not a positive number"):
            read_klampt_world(tmp_path / "world.xml")
    else:
        (thing,) = read_klampt_world(tmp_path / "world.xml").things
        np.testing.assert_allclose(np.ptp(thing.solids[0].shape.points, axis=0), size)


def test_a_folder_for_meshes_that_cannot_be_made_is_an_error(tmp_path):
    (tmp_path / "robot_meshes").write_text("")
    with pytest.raises(FileError, match="robot_meshes"):
        write_rob(tmp_path / "robot.rob", read_cell("tx2_90").robot)


def test_a_world_becomes_a_cell(tmp_path, capfd):
    assert main(["export-world", "tx2_90", "--out", str(tmp_path / "world")]) == 0
    out = tmp_path / "made"
    words = ["import", "klampt", str(tmp_path / "world" / "cell" / "world.xml")]
    assert main([*words, "--out", str(out), "--bin", "bin", "--tool", "suction"]) == 0
    cell, made = read_cell("tx2_90"), read_cell(out)
    np.testing.assert_allclose(made.bin.size, cell.bin.size, atol=0.006)
    T, U = made.bin.T_world_bin, cell.bin.T_world_bin
    np.testing.assert_allclose(T.homogeneous, U.homogeneous, atol=0.003)
    assert [one.name for one in made.fixtures][:2] == ["floor", "tray"]
    assert len(made.arms[0].joints) == 6
    capfd.readouterr()
    assert main([*words, "--out", str(tmp_path / "x"), "--bin", "bucket"]) == 2
    assert "there is bin, floor, tray" in capfd.readouterr().err
