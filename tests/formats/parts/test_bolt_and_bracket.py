"""The other shipped parts: closed meshes that their script makes, and grasps that hold them."""

import numpy as np
import open3d as o3d
import pytest
import trimesh

from parts import make_mesh
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Box, pose_from_rpy
from workbench.perception.views.surfaces import add_surface

NAMES = ("bolt", "bracket")
TOOL = read_cell("yumi").arms[0].tool


def surface_of(part) -> trimesh.Trimesh:
    return trimesh.Trimesh(np.array(part.mesh.points), np.array(part.mesh.triangles))


def finger_points(opening: float) -> np.ndarray:
    """Points all over both fingers at an opening, in the TCP frame."""
    grid = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 13)] * 3), axis=-1).reshape(-1, 3)
    blocks = []
    for finger in TOOL.fingers:
        shape = finger.solid.shape
        assert isinstance(shape, Box)
        T = TOOL.T_flange_tcp.inverse() * finger.solid.T_owner_shape
        shift = TOOL.T_flange_tcp.rotation.T @ finger.direction * opening / 2
        blocks.append(grid * shape.size @ T.rotation.T + T.translation + shift)
    return np.concatenate(blocks)


def air(part, points) -> np.ndarray:
    """Distance of points to the part's pieces, which fill its holes; negative inside."""
    found = np.full(len(points), np.inf)
    for piece in part.pieces:
        local = (points - piece.T_owner_shape.translation) @ piece.T_owner_shape.rotation
        if isinstance(piece.shape, Box):
            away = (np.abs(local) - piece.shape.size / 2).max(axis=1)
        else:
            across = np.hypot(local[:, 0], local[:, 1]) - piece.shape.radius
            away = np.maximum(across, np.abs(local[:, 2]) - piece.shape.length / 2)
        found = np.minimum(found, away)
    return found


@pytest.mark.parametrize(("name", "size"), [("bolt", (24, 27.7, 70)), ("bracket", (75, 40, 45))])
def test_the_mesh_is_closed_and_what_its_script_makes(name, size):
    surface, made = surface_of(read_part(name)), make_mesh.mesh(name)
    assert surface.is_watertight and surface.is_winding_consistent and surface.volume > 0
    assert made.is_watertight
    assert made.volume * 1e-9 == pytest.approx(surface.volume, rel=1e-5)
    np.testing.assert_allclose(made.extents, size, atol=0.02)


@pytest.mark.parametrize(("name", "low", "high"), [("bolt", 7700, 8000), ("bracket", 2600, 2850)])
def test_the_mass_is_that_of_steel_and_of_aluminium(name, low, high):
    part = read_part(name)
    assert low < part.mass / surface_of(part).volume < high


def test_a_sixth_of_a_turn_brings_the_bolt_onto_itself_and_no_other_does():
    part = read_part("bolt")
    assert part.symmetry.fold == 6
    points = np.array(part.mesh.points)
    corners = points[np.linalg.norm(points[:, :2], axis=1) > 0.009]  # of the head
    for degrees, is_same in ((60, True), (30, False)):
        turned = corners @ pose_from_rpy((0, 0, 0), (0, 0, np.deg2rad(degrees))).rotation.T
        off = np.linalg.norm(turned[:, None] - corners, axis=2).min(axis=1).max()
        assert bool(off < 1e-5) is is_same


def test_the_bracket_is_empty_where_its_holes_are():
    scene = o3d.t.geometry.RaycastingScene()
    add_surface(scene, surface_of(read_part("bracket")))
    places = [(0.055, 0, 0.003), (0.025, 0.01, 0.003), (0.003, 0, 0.028)]
    places += [(0.04, 0, 0.003), (0.003, 0.013, 0.028)]
    inside = scene.compute_occupancy(o3d.core.Tensor(np.array(places, dtype=np.float32)))
    assert inside.numpy().tolist() == [0, 0, 0, 1, 1]


@pytest.mark.parametrize("name", NAMES)
def test_open_fingers_touch_nothing_on_their_way_and_closed_ones_the_part(name):
    part = read_part(name)
    for grasp in part.library.grasps:
        T = grasp.T_part_tcp
        for back in np.linspace(0, grasp.approach_length, 13):
            points = finger_points(grasp.opening) - back * grasp.approach
            clear = air(part, points @ T.rotation.T + T.translation).min()
            assert clear > 0.002, f"{grasp.name}, {back * 1000:.0f} mm before the grasp"
        closed = air(part, finger_points(grasp.grip) @ T.rotation.T + T.translation)
        assert -5e-5 < closed.min() < 3e-4, grasp.name  # between points of a grid
