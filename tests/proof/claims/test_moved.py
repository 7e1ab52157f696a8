"""After a missed grip: which parts may lie otherwise, and a box that holds each however it lies."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
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


def points(cell, T):
    mesh = cell.parts[0].mesh.points
    return mesh @ T.rotation.T + T.translation


def is_inside(box, points):
    return bool((np.abs(points - box.T_world_box.translation) <= box.size / 2 + 1e-9).all())


def test_the_whole_heap_may_have_moved_and_nothing_else(cell):
    near, far = 0.08 + GAP * 0.9, 0.08 + GAP * 1.1
    parts = (puck(0.0), puck(near), puck(2 * near), puck(-far), puck(0.0, far))
    assert moved_parts(cell, parts, (0,)) == {0, 1, 2}
    assert moved_parts(cell, parts, (3,)) == {3}
    assert moved_parts(cell, parts, (3, 2)) == {0, 1, 2, 3}


def test_where_a_part_may_have_rolled_nobody_knows(cell):
    lying = (np.pi / 2, 0.0, 0.0)
    assert moved_parts(cell, (puck(0.0, rpy=lying),), (0,)) is None
    assert moved_parts(cell, (puck(0.0), puck(0.085, rpy=lying)), (0,)) is None
    assert moved_parts(cell, (puck(0.0), puck(0.5, rpy=lying)), (0,)) == {0}
    assert moved_parts(cell, (puck(0.0, roll_known=False),), (0,)) is None
    other = SymmetryAxis(np.array([1.0, 0.0, 0.0]), 3)
    ball = with_symmetry(cell, Symmetry(fold=0, also=(other,)))
    assert moved_parts(ball, (puck(0.0),), (0,)) is None
    edged = with_symmetry(cell, Symmetry())
    assert moved_parts(edged, (puck(0.0, rpy=lying),), (0,)) == {0}


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
