"""Loads by trimesh, by hand, and by bodies that cannot be."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Finger, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Solid, Sphere, pose_from_rpy
from workbench.model.load import (
    Load,
    Loads,
    is_closed,
    loads_of,
    part_load,
    together,
    tool_load,
    uniform_load,
)

T = pose_from_rpy((0.02, -0.03, 0.1), (0.3, -0.7, 1.1))
PARTS = ("bolt", "bracket", "keyed_cylinder", "puck")


def solid(shape, at=None):
    return Solid("one", shape, pin.SE3.Identity() if at is None else at)


@pytest.mark.parametrize("name", PARTS)
def test_a_part_has_the_load_that_trimesh_gives_its_mesh(name):
    part = read_part(name)
    mesh = trimesh.Trimesh(part.mesh.points, part.mesh.triangles)
    assert is_closed(part.mesh) == bool(mesh.is_watertight)
    mesh.density = part.mass / mesh.volume
    load = part_load(part)
    assert load.mass == part.mass
    assert load.centre == pytest.approx(mesh.center_mass, abs=1e-9)
    largest = np.abs(mesh.moment_inertia).max()
    assert load.inertia == pytest.approx(mesh.moment_inertia, abs=1e-6 * largest)


def test_a_cuboid_by_hand():
    # 1 kg, 60 x 80 x 100 mm: 1/12 m (b2 + c2) and so on.
    load = uniform_load([solid(Box(np.array([0.06, 0.08, 0.1])))], 1.0)
    assert load.centre.tolist() == [0, 0, 0]
    wanted = [0.0164 / 12, 0.0136 / 12, 0.01 / 12]
    assert load.inertia == pytest.approx(np.diag(wanted), abs=1e-12)


def test_two_balls_on_a_bar_by_hand():
    # Two balls of 1 kg and 50 mm radius, 400 mm apart along x: 2/5 m r2 each, and m d2 across.
    balls = [solid(Sphere(0.05), pose_from_rpy((x, 0.0, 0.3))) for x in (-0.2, 0.2)]
    load = uniform_load(balls, 2.0)
    own = 2 * 2 / 5 * 0.05**2
    assert load.centre == pytest.approx([0, 0, 0.3])
    assert load.inertia == pytest.approx(np.diag([own, own + 0.08, own + 0.08]), abs=1e-12)


@pytest.mark.parametrize(
    ("shape", "same"),
    [
        (Cylinder(0.03, 0.2), trimesh.creation.cylinder(0.03, 0.2, sections=512)),
        (Capsule(0.03, 0.2), trimesh.creation.capsule(0.2, 0.03, count=[128, 128])),
        (Box(np.array([0.1, 0.02, 0.05])), trimesh.creation.box((0.1, 0.02, 0.05))),
    ],
)
def test_a_shape_is_as_heavy_everywhere_as_its_mesh_turned_and_shifted(shape, same):
    load = uniform_load([solid(shape, T)], 0.5)
    same.apply_translation(-same.center_mass)
    same.apply_transform(T.homogeneous)
    same.density = 0.5 / same.volume
    assert load.centre == pytest.approx(same.center_mass, abs=1e-6)
    largest = np.abs(load.inertia).max()
    assert load.inertia == pytest.approx(same.moment_inertia, abs=2e-3 * largest)
    mesh = Mesh(same.vertices, same.faces)
    again = uniform_load([solid(mesh)], 0.5)
    assert again.inertia == pytest.approx(same.moment_inertia, abs=1e-6 * largest)


def test_an_open_surface_has_the_load_of_the_pieces_of_its_part():
    part = read_part("puck")
    opened = Mesh(part.mesh.points, part.mesh.triangles[1:])
    assert not is_closed(opened)
    assert not is_closed(Mesh(part.mesh.points, part.mesh.triangles[:, ::-1]))
    load = part_load(replace(part, mesh=opened))
    whole = uniform_load(part.pieces, part.mass)
    assert load.inertia.tolist() == whole.inertia.tolist()


def test_a_tool_without_a_mass_has_no_load_and_neither_has_what_it_holds():
    tool = replace(read_cell("yumi").arms[0].tool, mass=None)
    assert tool_load(tool) is None
    assert loads_of(tool, read_part("bolt"), pin.SE3.Identity()) is None


def test_what_a_tool_does_not_state_is_estimated_from_its_solids():
    box = solid(Box(np.array([0.1, 0.1, 0.1])), pose_from_rpy((0.0, 0.0, 0.05)))
    tool = Tool("one", pin.SE3.Identity(), (box,), mass=2.0)
    estimated = tool_load(tool)
    assert estimated.centre == pytest.approx([0, 0, 0.05])
    stated = replace(tool, centre_of_gravity=np.array([0.01, 0, 0.06]))
    assert tool_load(stated).centre.tolist() == [0.01, 0, 0.06]
    assert tool_load(stated).inertia == pytest.approx(estimated.inertia)
    fingers = tuple(
        Finger(solid(box.shape, pose_from_rpy((x, 0, 0.05))), np.array([x / 0.1, 0, 0]))
        for x in (-0.1, 0.1)
    )
    assert tool_load(replace(tool, fingers=fingers)).centre == pytest.approx([0, 0, 0.05])


def test_tool_and_part_are_one_body_wherever_the_part_lies():
    part, tool = read_part("bolt"), replace(read_cell("yumi").arms[0].tool, mass=0.3)
    loads = loads_of(tool, part, T)
    assert loads.carried(False) is loads.tool
    # The same by Pinocchio, which adds inertias of its own.
    one, other = (
        pin.Inertia(load.mass, np.array(load.centre), np.array(load.inertia))
        for load in (loads.tool, part_load(part))
    )
    whole = one + (tool.T_flange_tcp * T).act(other)
    carried = loads.carried(True)
    assert carried.mass == pytest.approx(whole.mass)
    assert carried.centre == pytest.approx(whole.lever)
    assert carried.inertia == pytest.approx(whole.inertia, abs=1e-12)
    assert "with the part" in str(loads.words)


@pytest.mark.parametrize(
    ("mass", "centre", "inertia", "why"),
    [
        (0.0, np.zeros(3), np.eye(3), "mass"),
        (-1.0, np.zeros(3), np.eye(3), "mass"),
        (np.nan, np.zeros(3), np.eye(3), "mass"),
        (1.0, np.array([0, np.inf, 0]), np.eye(3), "centre"),
        (1.0, np.zeros(3), np.full((3, 3), np.nan), "inertia"),
        (1.0, np.zeros(3), np.diag([1.0, 1.0, 2.1]), "sum of the others"),
        (1.0, np.zeros(3), np.diag([-0.1, 1.0, 1.0]), "at least 0"),
        (1.0, np.zeros(3), np.array([[1, 0.1, 0], [0, 1, 0], [0, 0, 1.0]]), "symmetric"),
    ],
)
def test_a_body_that_cannot_be_is_no_load(mass, centre, inertia, why):
    with pytest.raises(InputError, match=why):
        Load(mass, centre, inertia)


def test_a_point_mass_is_a_load():
    point = Load(1.0, np.array([0.0, 0.0, 0.1]), np.zeros((3, 3)))
    two = together([point, point.seen_from(pose_from_rpy((0.0, 0.0, 0.2)))])
    assert two.centre == pytest.approx([0, 0, 0.2])
    assert two.inertia == pytest.approx(np.diag([0.02, 0.02, 0.0]))
    assert Loads(point, point).carried(True).mass == 2.0
