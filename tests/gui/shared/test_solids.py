"""Solids as triangles."""

import numpy as np

from workbench.formats.meshes.triangles import triangles_of
from workbench.gui.shared.solids import by_colour, rgb, with_hard_edges
from workbench.model.geometry import Box, Solid, Sphere, pose_from_rpy

HERE = pose_from_rpy((0, 0, 0))
SIZE = np.array([0.2, 0.4, 0.6])


def test_a_box_gets_a_point_for_each_side_of_each_corner():
    points, triangles = with_hard_edges(triangles_of(Box(SIZE)))
    assert len(points) == 24
    assert len(triangles) == 12


def test_a_ball_stays_smooth():
    surface = triangles_of(Sphere(0.1))
    assert len(with_hard_edges(surface)[0]) == len(surface.vertices)


def test_solids_of_one_colour_become_one_mesh_where_they_stand():
    red, blue = (1.0, 0.0, 0.0), (0.0, 0.0, 1.0)
    solids = (
        Solid("a", Box(SIZE), pose_from_rpy((1, 0, 0)), red),
        Solid("b", Box(SIZE), pose_from_rpy((-1, 0, 0)), red),
        Solid("c", Box(SIZE), HERE, blue),
    )
    (first, points, triangles), (second, *_) = by_colour(solids, pose_from_rpy((0, 0, 2)))
    assert (first, second) == ((255, 0, 0), (0, 0, 255))
    assert len(triangles) == 24
    np.testing.assert_allclose(points.min(axis=0), [-1.1, -0.2, 1.7])
    np.testing.assert_allclose(points.max(axis=0), [1.1, 0.2, 2.3])


def test_colours_out_of_range_are_clipped():
    assert rgb((2.0, -1.0, 0.5)) == (255, 0, 128)
