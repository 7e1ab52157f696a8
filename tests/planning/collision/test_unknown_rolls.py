"""The room of a part at every turn about its axis, and how a part comes off what it lies on."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial import ConvexHull

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import (
    Box,
    Capsule,
    Cylinder,
    Mesh,
    Solid,
    Sphere,
    pose_from_rpy,
)
from workbench.model.part import GraspLibrary, Part
from workbench.model.scan import Detection, Obstacle
from workbench.model.symmetry import Symmetry, make_turn
from workbench.planning.collision.unknown_rolls import TURN_SPACING, place_pieces, room_of
from workbench.planning.collision.world import World
from workbench.planning.grasps.pads import outline
from workbench.proof.claims.scene import room_of as room_of_proof

NOWHERE = pin.SE3.Identity()
UP = np.array([0.0, 0.0, 0.1])


def hull_of(rng) -> Mesh:
    points = rng.normal(size=(12, 3)) * 0.02
    hull = ConvexHull(points)
    return Mesh(points, hull.simplices, is_convex=True)


@pytest.mark.parametrize("seed", range(5))
def test_the_room_holds_every_piece_at_every_turn_and_touches_it(seed):
    rng = np.random.default_rng(seed)
    shapes = (Box(rng.uniform(0.01, 0.05, 3)), Sphere(0.01), Capsule(0.01, 0.03),
              Cylinder(0.012, 0.04), hull_of(rng))  # fmt: skip
    pieces = tuple(
        Solid("piece", shape, pose_from_rpy(rng.uniform(-0.03, 0.03, 3), rng.uniform(-3, 3, 3)))
        for shape in shapes
    )
    part = Part("thing", hull_of(rng), pieces, 0.1, Symmetry(), GraspLibrary())
    direction = rng.normal(size=3)
    axis = np.array([rng.uniform(-0.01, 0.01, 3), direction / np.linalg.norm(direction)])
    found = Detection("thing", NOWHERE, roll_known=False, roll_axis=axis)
    for piece, room in zip(pieces, room_of(part, found), strict=True):
        inverse, shape = room.T_owner_shape.inverse(), room.shape
        assert isinstance(shape, Cylinder)
        for angle in rng.uniform(-np.pi, np.pi, 20):
            T = inverse * make_turn(axis[1], float(angle), axis[0]) * piece.T_owner_shape
            points = outline(piece.shape) @ T.rotation.T + T.translation
            assert np.linalg.norm(points[:, :2], axis=1).max() <= shape.radius + 1e-9
            assert np.abs(points[:, 2]).max() <= shape.length / 2 + 1e-9
        if isinstance(piece.shape, Box | Mesh):
            T = inverse * piece.T_owner_shape
            points = outline(piece.shape) @ T.rotation.T + T.translation
            assert np.linalg.norm(points[:, :2], axis=1).max() == pytest.approx(shape.radius)
        other, T_part_room = room_of_proof(piece, axis)
        assert (other.radius, other.length) == pytest.approx((shape.radius, shape.length))
        assert np.allclose(T_part_room.translation, room.T_owner_shape.translation)


def test_a_known_roll_needs_no_more_room_than_the_part(cell, detections):
    part, found = cell.parts[0], detections[0]
    assert room_of(part, found) is part.pieces
    rolled = replace(found, roll_known=False)
    radii = [room.shape.radius for room in room_of(part, rolled)]
    assert radii == pytest.approx([0.015, 0.019, np.hypot(0.019, 0.004)])
    assert room_of(part, rolled) is room_of(part, replace(rolled, score=0.5))
    # The axis that the scan was found by counts before the one that the part states.
    aside = replace(rolled, roll_axis=np.array([[0.001, 0.0, 0.0], [0.0, 0.0, 1.0]]))
    assert room_of(part, aside)[0].shape.radius == pytest.approx(0.016)
    turns = int(np.ceil(np.pi * radii[-1] / TURN_SPACING))
    assert [len(piece) for piece in place_pieces(part, rolled)] == [1, 1, turns]


def lying(cell, y: float) -> Detection:
    T = cell.bin.T_world_bin * pose_from_rpy((0, y, 0.0195), (0, np.pi / 2, 0))
    return Detection("keyed_cylinder", T, roll_known=False)


def post(cell, height: float) -> Obstacle:
    """Beside the smooth part of a lying cylinder, where its key may be: 2 mm from the body."""
    at = cell.bin.T_world_bin * pose_from_rpy((0.018, 0.018, 0.0195 + height + 0.01))
    return Obstacle(at, np.array([0.012, 0.002, 0.02]))


def test_a_key_that_may_be_below_a_neighbour_holds_the_part_back():
    cell = read_cell("yumi")
    one = lying(cell, 0.0)
    assert World(cell, (one,)).part_ways.find_snag(0, UP) is None
    above = World(cell, (one,), (post(cell, 0.003),)).part_ways
    caught = above.find_snag(0, UP)
    assert caught is not None and not caught.is_sunk
    assert (caught.part, caught.bed) == ("part-1", "seen-1") and caught.distance < 0.002
    # Over it nothing is: at no turn can the key be there, and all others get past.
    low = World(cell, (one,), (post(cell, -0.0295),)).part_ways
    assert low.find_snag(0, UP) is None
    known = World(cell, (replace(one, roll_known=True),), (post(cell, 0.003),)).part_ways
    assert known.find_snag(0, UP) is None


def test_a_part_that_is_too_deep_at_every_turn_has_a_wrong_pose():
    cell = read_cell("yumi")
    one = lying(cell, 0.0)
    down = pose_from_rpy((0, 0, -0.005)) * one.T_world_part
    caught = World(cell, (replace(one, T_world_part=down),)).part_ways.find_snag(0, UP)
    assert caught is not None and caught.is_sunk and caught.bed == "bin_floor"


def test_parts_whose_roll_is_unknown_are_nearer_to_their_neighbours():
    cell = read_cell("yumi")
    known = [replace(lying(cell, y), roll_known=True) for y in (0.0, 0.045)]
    rolled = [lying(cell, y) for y in (0.0, 0.045)]
    apart, near = (World(cell, tuple(two)).part_ways.gap(0, 1) for two in (known, rolled))
    assert near < apart and near == pytest.approx(0.045 - 2 * np.hypot(0.019, 0.004), abs=1e-6)
