"""The farthest of points from triangles, against trimesh's search without a tree."""

import numpy as np
import pytest
import trimesh

from workbench.formats.meshes.pieces.surfaces import Surface

SHAPES = {
    "ring": lambda: trimesh.creation.annulus(0.01, 0.02, 0.015, sections=40),
    "long box": lambda: trimesh.creation.box((0.2, 0.01, 0.003)),
    "ball": lambda: trimesh.creation.icosphere(2, 0.02),
}


def outside_of(shape, points):
    """How far points lie outside [m], by trimesh."""
    away = trimesh.proximity.closest_point_naive(shape, points)[1]
    return np.where(is_inside(shape, points), 0.0, away)


def is_inside(shape, points):
    """By the angles in which points see the triangles (Van Oosterom and Strackee, 1983)."""
    a, b, c = np.moveaxis(np.asarray(shape.triangles)[None] - points[:, None, None], 2, 0)
    p, q, r = (np.linalg.norm(corner, axis=2) for corner in (a, b, c))
    above = np.einsum("nki,nki->nk", a, np.cross(b, c))
    ab, bc, ca = (np.einsum("nki,nki->nk", *pair) for pair in ((a, b), (b, c), (c, a)))
    angles = np.arctan2(above, p * q * r + ab * r + bc * p + ca * q)
    return np.abs(angles.sum(axis=1)) > np.pi


@pytest.mark.parametrize("name", SHAPES)
@pytest.mark.parametrize("seed", range(3))
def test_the_farthest_point_is_that_of_a_search_without_a_tree(name, seed):
    shape = SHAPES[name]()
    rng = np.random.default_rng(seed)
    points = shape.bounds.mean(axis=0) + rng.uniform(-0.5, 0.5, (200, 3)) * shape.extents
    surface = Surface(np.asarray(shape.triangles), spacing=0.001)
    away = outside_of(shape, points)
    far, at = surface.farthest(points)
    assert far == pytest.approx(away.max(), abs=1e-9)
    assert away[at] >= 0.95 * away.max()
    for k in range(20):
        assert surface.farthest(points[k : k + 1])[0] == pytest.approx(away[k], abs=1e-9)


def test_what_is_near_enough_or_too_far_is_not_looked_at_closer():
    shape = SHAPES["ring"]()
    points = (
        shape.bounds.mean(axis=0)
        + np.random.default_rng(9).uniform(-0.5, 0.5, (200, 3)) * shape.extents
    )
    surface = Surface(np.asarray(shape.triangles), spacing=0.001)
    largest = outside_of(shape, points).max()
    assert largest <= surface.farthest(points, enough=2 * largest)[0] <= 2 * largest
    assert largest / 2 < surface.farthest(points, too_far=largest / 2)[0] <= largest + 1e-9
