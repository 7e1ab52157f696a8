"""Grid cells become few boxes which hold all of them."""

import coal
import numpy as np
import open3d as o3d
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.model.geometry import pose_from_rpy
from workbench.perception.scene.roofs import roofs_over
from workbench.perception.scene.upright_boxes import MOST_BOXES, Grid, _heaps, upright_boxes
from workbench.perception.views.surfaces import add_surface

EDGE = 0.006
FINE = Grid(0.002, 3)
BEAM = (0.2, 0.04, 0.02)
"""[m]"""

places = st.tuples(st.integers(-120, 120), st.integers(-120, 120))


def test_two_heaps_are_two_boxes_and_a_corner_joins_cells():
    cells = np.array([[0, 0], [1, 1], [1, 2], [4, 0], [5, 1], [1000, 3]])
    assert _heaps(cells).tolist() == [0, 0, 0, 1, 1, 2]
    assert _heaps(cells[:0]).tolist() == []


@settings(max_examples=60)
@given(cells=st.lists(places, min_size=1, max_size=300, unique=True), data=st.data())
def test_few_boxes_hold_all_cells_up_to_their_tops_and_down_to_the_floor(cells, data):
    index = np.array(cells)
    tops = np.array(
        data.draw(st.lists(st.floats(-0.02, 0.3), min_size=len(index), max_size=len(index)))
    )
    boxes = upright_boxes(index, tops, Grid(EDGE))
    assert 1 <= len(boxes) <= MOST_BOXES
    corners = np.array([(x, y) for x in (0.01, 0.99) for y in (0.01, 0.99)])
    for place, top in zip(index, tops, strict=True):
        lowest = min(0.0, top)
        points = np.array([(*xy, z) for xy in (place + corners) * EDGE for z in (lowest, top)])
        inside = np.zeros(len(points), bool)
        for one in boxes:
            T = one.T_world_box.inverse()
            away = np.abs(points @ T.rotation.T + T.translation) - one.size / 2
            inside |= np.all(away <= 1e-9, axis=1)
        assert inside.all()


def test_more_things_than_boxes_are_all_held():
    x, y = np.meshgrid(np.arange(0, 300, 10), np.arange(0, 300, 10))
    index = np.stack([x.ravel(), y.ravel()], axis=1)
    boxes = upright_boxes(index, np.full(len(index), 0.1), Grid(EDGE))
    assert len(boxes) <= MOST_BOXES
    points = np.column_stack([(index + 0.5) * EDGE, np.full(len(index), 0.05)])
    inside = np.zeros(len(points), bool)
    for one in boxes:
        T = one.T_world_box.inverse()
        inside |= np.all(np.abs(points @ T.rotation.T + T.translation) <= one.size / 2, axis=1)
    assert inside.all()


def corner_beside_a_beam():
    """Cells (n, 2) of a triangle, tops (n,), and a beam along its longest side, 40 mm up."""
    x, y = np.meshgrid(np.arange(20), np.arange(20))
    cells = np.stack([x.ravel(), y.ravel()], axis=1)
    # The beam's near edge lies two cells beyond the last of the triangle.
    middle = np.full(2, 0.5 * 22 * FINE.edge + BEAM[1] / 2 / np.sqrt(2))
    T = pose_from_rpy((*middle, 0.04), (0.0, 0.0, -np.pi / 4))
    return cells[cells.sum(axis=1) < 20], T


def roofs_under(T, cells, tops):
    scene = o3d.t.geometry.RaycastingScene()
    add_surface(scene, trimesh.creation.box(BEAM), T)
    return roofs_over(cells, tops, FINE.edge, scene)


def in_the_way(boxes, T):
    """Whether a box meets the beam, by another library."""
    return any(
        coal.collide(
            coal.Box(*one.size),
            coal.Transform3s(one.T_world_box.rotation, one.T_world_box.translation),
            coal.Box(*BEAM),
            coal.Transform3s(T.rotation, T.translation),
            coal.CollisionRequest(),
            coal.CollisionResult(),
        )
        for one in boxes
    )


@pytest.mark.parametrize("top", [0.035, 0.08])
def test_boxes_stay_clear_of_a_part_that_none_of_their_cells_reaches_into(top):
    cells, T = corner_beside_a_beam()
    tops = np.full(len(cells), top)
    assert in_the_way(upright_boxes(cells, tops, FINE), T)
    boxes = upright_boxes(cells, tops, FINE, roofs_under(T, cells, tops))
    assert 1 < len(boxes) <= 12
    assert not in_the_way(boxes, T)


@pytest.mark.parametrize(("top", "along"), [(0.02, 0), (0.2, 6)])
def test_what_lies_under_a_part_or_leans_over_it_is_not_split_for_it(top, along):
    cells, T = corner_beside_a_beam()
    cells, tops = cells + along, np.full(len(cells), top)
    roofs = roofs_under(T, cells, tops)
    assert len(upright_boxes(cells, tops, FINE, roofs)) == len(upright_boxes(cells, tops, FINE))
