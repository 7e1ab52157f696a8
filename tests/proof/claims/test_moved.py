"""After a missed grip: which parts may lie otherwise, and a box that holds each however it lies."""

from dataclasses import replace
from itertools import product

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Mesh, Solid, pose_from_rpy
from workbench.model.scan import Detection
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.proof.claims.moved import moved_parts, room_of_moved

GAP = 0.01
ANGLES = st.tuples(*[st.floats(-np.pi, np.pi)] * 3)


@pytest.fixture(scope="module")
def cell():
    """A cell of pucks, 80 mm wide and 14 mm high."""
    found = read_cell("tx2_90")
    return replace(found, policy=replace(found.policy, pair_gap=GAP))


def puck(x, y=0.0, rpy=(0.0, 0.0, 0.0), **about):
    return Detection("puck", pose_from_rpy((x, y, 0.5), rpy), **about)


def with_symmetry(cell, symmetry):
    return replace(cell, parts=(replace(cell.parts[0], symmetry=symmetry),))


def box_points(*size):
    return np.array(list(product(*((-side / 2, side / 2) for side in size))))


def with_points(cell, points):
    """The cell with a part of that shape alone."""
    mesh = Mesh(points, ConvexHull(points).simplices, is_convex=True)
    piece = Solid("piece", mesh, pin.SE3.Identity())
    part = replace(cell.parts[0], mesh=mesh, pieces=(piece,), symmetry=Symmetry())
    return replace(cell, parts=(part,))


def points(cell, T):
    mesh = cell.parts[0].mesh.points
    return mesh @ T.rotation.T + T.translation


def is_inside(box, points):
    return bool((np.abs(points - box.T_world_box.translation) <= box.size / 2 + 1e-9).all())


def rooms_reach(cell):
    """How far [m] from its middle a puck that may lie otherwise reaches."""
    return float(room_of_moved(cell, puck(0.0)).size[0]) / 2


def test_what_a_moved_part_may_fall_onto_may_have_moved_and_nothing_else(cell):
    touches = rooms_reach(cell) + 0.04 + GAP
    near, far = touches - 0.002, touches + 0.002
    parts = (puck(0.0), puck(near), puck(2 * near), puck(-far), puck(0.0, far))
    assert moved_parts(cell, parts, (0,)) == {0, 1, 2}
    assert moved_parts(cell, parts, (3,)) == {3}
    assert moved_parts(cell, parts, (3, 2)) == {0, 1, 2, 3}


def test_a_part_that_stands_high_may_have_fallen_onto_one_that_is_no_neighbour(cell):
    block = with_points(cell, box_points(0.02, 0.03, 0.1))
    stands = Detection("puck", pose_from_rpy((0.0, 0.0, 0.05)))
    lies = Detection("puck", pose_from_rpy((0.09, 0.0, 0.01), (0.0, np.pi / 2, 0.0)))
    assert moved_parts(block, (stands, lies), (0,)) == {0, 1}


def test_near_a_part_that_an_earlier_grip_may_have_moved_nobody_knows(cell):
    far = 2 * rooms_reach(cell) + GAP + 0.002
    assert moved_parts(cell, (puck(0.0),), (0,), (puck(far),)) == {0}
    assert moved_parts(cell, (puck(0.0),), (0,), (puck(far - 0.005),)) is None


def test_where_a_part_may_have_rolled_nobody_knows(cell):
    lying = (np.pi / 2, 0.0, 0.0)
    assert moved_parts(cell, (puck(0.0, rpy=lying),), (0,)) is None
    assert moved_parts(cell, (puck(0.0), puck(0.085, rpy=lying)), (0,)) is None
    assert moved_parts(cell, (puck(0.0), puck(0.5, rpy=lying)), (0,)) == {0}
    assert moved_parts(cell, (puck(0.0, roll_known=False),), (0,)) is None
    other = SymmetryAxis(np.array([1.0, 0.0, 0.0]), 3)
    ball = with_symmetry(cell, Symmetry(fold=0, also=(other,)))
    assert moved_parts(ball, (puck(0.0, rpy=lying),), (0,)) is None


def test_whether_a_part_rolls_its_shape_says_and_no_statement(cell):
    unstated = with_symmetry(cell, Symmetry())
    lying = (np.pi / 2, 0.0, 0.0)
    assert moved_parts(unstated, (puck(0.0, rpy=lying),), (0,)) is None
    assert moved_parts(unstated, (puck(0.0),), (0,)) == {0}


@pytest.mark.parametrize("sides", [6, 24])
def test_a_pin_rolls_however_it_stands_or_lies(cell, sides):
    turns = np.linspace(0.0, 2 * np.pi, sides, endpoint=False)
    ring = 0.005 * np.column_stack([np.cos(turns), np.sin(turns)])
    ends = [np.column_stack([ring, np.full(sides, z)]) for z in (-0.03, 0.03)]
    pin_cell = with_points(cell, np.vstack(ends))
    for rpy in ((0.0, 0.0, 0.0), (np.pi / 2, 0.0, 0.3)):
        assert moved_parts(pin_cell, (puck(0.0, rpy=rpy),), (0,)) is None


def test_a_block_and_a_bracket_do_not_roll(cell):
    block = with_points(cell, box_points(0.02, 0.03, 0.1))
    for rpy in ((0.0, 0.0, 0.2), (np.pi / 2, 0.0, 0.0), (0.0, np.pi / 2, 0.0)):
        assert moved_parts(block, (puck(0.0, rpy=rpy),), (0,)) == {0}
    yumi = read_cell("robots/yumi/kits.toml")
    yumi = replace(yumi, policy=replace(yumi.policy, pair_gap=GAP))
    bracket = Detection("bracket", pose_from_rpy((0.4, 0.0, 0.1), (0.0, 0.5, 0.0)))
    assert moved_parts(yumi, (bracket,), (0,)) == {0}


@given(was=ANGLES, turned=ANGLES, shift=ANGLES)
def test_the_box_holds_a_part_that_was_turned_and_pushed(cell, was, turned, shift):
    found = puck(0.1, rpy=was)
    box = room_of_moved(cell, found)
    R = pose_from_rpy((0, 0, 0), turned).rotation
    push = np.array(shift) / max(np.linalg.norm(shift), 1e-9) * GAP
    mesh = cell.parts[0].mesh.points
    middle = found.T_world_part.act((mesh.min(axis=0) + mesh.max(axis=0)) / 2)
    around = pin.SE3(R, middle + push - R @ middle)
    assert is_inside(box, points(cell, around * found.T_world_part))


@pytest.mark.parametrize("angle", np.linspace(0.0, np.pi / 2, 10))
@pytest.mark.parametrize("about", np.linspace(0.0, 2 * np.pi, 17))
def test_the_box_holds_a_part_that_falls_over_or_is_set_upright(cell, angle, about):
    for rpy in ((np.pi / 2, 0.0, 0.3), (0.0, 0.0, 0.3)):
        found = puck(0.1, rpy=rpy)
        lies = points(cell, found.T_world_part)
        box = room_of_moved(cell, found)
        direction = np.array([np.cos(about), np.sin(about), 0.0])
        lowest = lies[lies[:, 2] <= lies[:, 2].min() + 1e-6]
        pivot = lowest[np.argmax(lowest @ direction)]
        turn = pin.exp3(np.cross([0.0, 0.0, 1.0], direction) * angle)
        assert is_inside(box, (lies - pivot) @ turn.T + pivot)
