"""A scan as a picture, with parts drawn over it."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.perception.views.overlay import overlay
from workbench.perception.views.surfaces import triangles_of


@pytest.fixture(scope="module")
def drawn(scan, pile, part):
    mesh = triangles_of(part.mesh)
    poses = [scan.T_world_scanner.actInv(one.T_world_part).homogeneous for one in pile]
    return overlay(scan, [(mesh, pose) for pose in poses])


def test_each_part_is_drawn_in_its_colour_where_it_lies(drawn, pile):
    assert len(drawn.places) == len(pile) and np.isfinite(drawn.places).all()
    for (column, row), colour in zip(drawn.places, drawn.colours, strict=True):
        around = drawn.picture[
            int(row) - 60 : int(row) + 60, int(column) - 60 : int(column) + 60
        ].reshape(-1, 3)
        assert (around == colour).all(axis=1).any()
        assert not (colour == 0).all()


def test_a_part_outside_of_the_picture_has_no_place(scan, part):
    far = np.eye(4)
    far[:3, 3] = 5.0, 5.0, 0.5
    alone = overlay(scan, [(triangles_of(part.mesh), far)])
    assert np.isnan(alone.places).all()
    assert np.array_equal(alone.picture, overlay(scan, []).picture)


def test_a_scan_with_colours_is_shown_in_them(scan):
    red = np.tile(np.array([200, 10, 10], np.uint8), (len(scan.points), 1))
    picture = overlay(replace(scan, colours=red), []).picture.reshape(-1, 3)
    seen = picture[picture.any(axis=1)]
    assert (seen == (200, 10, 10)).all() and len(seen) > 0.5 * len(picture)
