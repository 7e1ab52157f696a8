"""The shipped part: what its files say of it fits together."""

from collections.abc import Callable

import numpy as np
import pytest
import trimesh

from parts import make_mesh
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Tool
from workbench.model.digest import digest_of
from workbench.model.geometry import Box, Cylinder, Floats, Solid
from workbench.model.part import Grasp, GraspPattern, Part


@pytest.fixture(scope="module")
def part() -> Part:
    return read_part("keyed_cylinder")


@pytest.fixture(scope="module")
def tool() -> Tool:
    return read_cell("yumi").arms[0].tool


@pytest.fixture(scope="module")
def surface(part: Part) -> trimesh.Trimesh:
    return trimesh.Trimesh(part.mesh.points, part.mesh.triangles)


def depth(solids: tuple[Solid, ...], points: Floats) -> Floats:
    """How deep each point (n, 3) lies in the union of boxes and cylinders; below 0: outside."""
    depths: list[Floats] = []
    for solid in solids:
        local = (points - solid.T_owner_shape.translation) @ solid.T_owner_shape.rotation
        match solid.shape:
            case Box(size):
                depths.append((size / 2 - np.abs(local)).min(axis=1))
            case Cylinder(radius, length):
                around = radius - np.hypot(local[:, 0], local[:, 1])
                depths.append(np.minimum(around, length / 2 - np.abs(local[:, 2])))
            case other:
                raise TypeError(f"{other} is not among the part's shapes")
    return np.max(depths, axis=0)


def winding(surface: trimesh.Trimesh, points: Floats) -> Floats:
    """1 inside of a closed surface, 0 outside: the solid angles of its triangles summed up.

    Source: van Oosterom and Strackee, "The Solid Angle of a Plane Triangle", 1983.
    """
    a, b, c = np.moveaxis(surface.triangles[None] - points[:, None, None], 2, 0)
    la, lb, lc = (np.linalg.norm(v, axis=2) for v in (a, b, c))
    above = np.einsum("nmk,nmk->nm", a, np.cross(b, c))
    below = (
        la * lb * lc
        + np.einsum("nmk,nmk->nm", a, b) * lc
        + np.einsum("nmk,nmk->nm", b, c) * la
        + np.einsum("nmk,nmk->nm", c, a) * lb
    )
    return np.arctan2(above, below).sum(axis=1) / (2 * np.pi)


def finger_points(tool: Tool, opening: float) -> Floats:
    """Points all over both fingers at an opening, in the TCP frame."""
    grid = np.stack(np.meshgrid(*[np.linspace(-0.5, 0.5, 13)] * 3), axis=-1).reshape(-1, 3)
    blocks: list[Floats] = []
    for finger in tool.fingers:
        shape = finger.solid.shape
        assert isinstance(shape, Box), "this test knows fingers made of a box each"
        T = tool.T_flange_tcp.inverse() * finger.solid.T_owner_shape
        shift = tool.T_flange_tcp.rotation.T @ finger.direction * opening / 2
        blocks.append(grid * shape.size @ T.rotation.T + T.translation + shift)
    return np.concatenate(blocks)


def in_part(grasp: Grasp, points: Floats, back: float = 0.0) -> Floats:
    """Points of the TCP frame in the part frame, the tool `back` m before the end of its way."""
    T = grasp.T_part_tcp
    return (points - back * grasp.approach) @ T.rotation.T + T.translation


def test_the_surface_is_closed_and_small(surface: trimesh.Trimesh) -> None:
    assert surface.is_watertight and surface.is_winding_consistent
    assert surface.volume > 0
    assert len(surface.faces) < 5000
    np.testing.assert_allclose(surface.bounds[1] - surface.bounds[0], [0.038, 0.038, 0.08])


def test_surface_and_pieces_are_the_same_body(part: Part, surface: trimesh.Trimesh) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (4000, 3)) * [0.022, 0.022, 0.044]
    deep = depth(part.pieces, points)
    facets = 5e-5  # between a circle and its facets
    clear = np.abs(deep) > facets
    inside = winding(surface, points) > 0.5
    assert np.array_equal(inside[clear], deep[clear] > 0)
    assert 500 < inside.sum() < 3500
    assert np.abs(depth(part.pieces, surface.vertices)).max() < facets


@pytest.mark.parametrize(
    "turn", [lambda p: p * [1, 1, -1], lambda p: p * [1, -1, -1], lambda p: p * [-1, -1, 1]]
)
def test_no_turn_leaves_the_part_as_it_is(part: Part, turn: Callable[[Floats], Floats]) -> None:
    points = np.random.default_rng(0).uniform(-1, 1, (20_000, 3)) * [0.022, 0.022, 0.044]
    deep, turned = depth(part.pieces, points), depth(part.pieces, turn(points))
    assert np.sum((deep > 0.001) & (turned < -0.001)) > 10


def test_the_mesh_is_what_its_script_makes(surface: trimesh.Trimesh) -> None:
    made = make_mesh.mesh("keyed_cylinder")
    assert made.volume * 1e-9 == pytest.approx(surface.volume, rel=1e-6)
    np.testing.assert_allclose(made.bounds / 1000, surface.bounds, atol=1e-7)


def test_the_mesh_has_the_same_digest_everywhere(part: Part) -> None:
    expected = "e7bc6dbd3e8bc8785fe6eb2dc5276d8b198b3b10cd4a87c6945f735d9261243c"
    assert digest_of(part.mesh) == expected


def test_one_pattern_is_the_fifteen_grasps(part: Part) -> None:
    (entry,) = part.library.entries
    assert isinstance(entry, GraspPattern)
    assert (len(entry.angles), len(entry.offsets), len(entry.grasps)) == (5, 3, 15)


def test_the_tool_points_at_the_axis_and_closes_across_it(part: Part) -> None:
    for grasp in part.library.grasps:
        x, y, z = grasp.T_part_tcp.rotation.T
        np.testing.assert_allclose([x[2] ** 2, y[2], z[2]], [1, 0, 0], atol=1e-12)
        start = grasp.T_part_tcp.translation - 0.06 * z
        assert start @ z < 0, "z must point into the part"
        assert abs(start @ y) < 1e-12, "the tool's z axis must meet the part's axis"


def test_however_the_part_is_rolled_a_grasp_comes_from_above(part: Part) -> None:
    directions = np.array([grasp.T_part_tcp.rotation[:2, 2] for grasp in part.library.grasps])
    for roll in np.linspace(0, 2 * np.pi, 360):
        down = np.array([np.cos(roll), np.sin(roll)])
        assert np.degrees(np.arccos((directions @ down).max())) < 36.1


def test_open_fingers_touch_nothing_on_their_way(part: Part, tool: Tool) -> None:
    for grasp in part.library.grasps:
        for back in np.linspace(0, grasp.approach_length, 31):
            points = in_part(grasp, finger_points(tool, grasp.opening), back)
            air = -depth(part.pieces, points).max()
            assert air > 0.002, f"{grasp.name} {back * 1000:.0f} mm before the grasp"


def test_closed_fingers_meet_the_body_and_nothing_else(part: Part, tool: Tool) -> None:
    body, *others = part.pieces
    for grasp in part.library.grasps:
        points = in_part(grasp, finger_points(tool, grasp.grip))
        assert -1e-4 < depth((body,), points).max() < 1e-9, grasp.name
        assert depth(tuple(others), points).max() < -0.002, grasp.name
