"""Corners of a surface whose faces move outwards."""

import numpy as np
import pytest

from workbench.model.geometry import outwards

CUBE = np.array([[x, y, z] for x in (0.0, 1.0) for y in (0.0, 1.0) for z in (0.0, 1.0)])
FACES = np.array(
    [[0, 1, 3], [0, 3, 2], [4, 6, 7], [4, 7, 5], [0, 4, 5], [0, 5, 1],
     [2, 3, 7], [2, 7, 6], [0, 2, 6], [0, 6, 4], [1, 5, 7], [1, 7, 3]]
)  # fmt: skip


def test_the_faces_of_a_box_all_move_by_the_same_distance():
    assert outwards(CUBE, FACES) == pytest.approx(2 * CUBE - 1)


def test_a_corner_of_a_face_without_area_stays_with_the_others():
    flat = np.vstack([FACES, [0, 0, 1]])
    assert outwards(CUBE, flat) == pytest.approx(2 * CUBE - 1)


def test_what_no_triangle_holds_stays():
    moves = outwards(np.vstack([CUBE, [5.0, 5.0, 5.0]]), FACES)
    assert not moves[8].any()
