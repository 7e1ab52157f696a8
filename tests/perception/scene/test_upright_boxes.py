"""Grid cells become few boxes which hold all of them."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from workbench.perception.scene.upright_boxes import MOST, _heaps, upright_boxes

EDGE = 0.006
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
    boxes = upright_boxes(index, tops, EDGE)
    assert 1 <= len(boxes) <= MOST
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
    boxes = upright_boxes(index, np.full(len(index), 0.1), EDGE)
    assert len(boxes) <= MOST
    points = np.column_stack([(index + 0.5) * EDGE, np.full(len(index), 0.05)])
    inside = np.zeros(len(points), bool)
    for one in boxes:
        T = one.T_world_box.inverse()
        inside |= np.all(np.abs(points @ T.rotation.T + T.translation) <= one.size / 2, axis=1)
    assert inside.all()
