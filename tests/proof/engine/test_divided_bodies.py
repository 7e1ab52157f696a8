"""A body that goes around pieces is as far away as the nearest of these, for whoever asks."""

from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from workbench.model.digest import canonical, digest_of
from workbench.model.geometry import Box, Mesh, Sphere
from workbench.planning.collision.bodies import extent
from workbench.planning.collision.distances import measuring as planned
from workbench.planning.collision.distances.cores import cores_of
from workbench.planning.collision.distances.gjk import CLEAR, TOUCHES, side
from workbench.proof.engine import shapes as proven


def convex(points) -> Mesh:
    hull = ConvexHull(points)
    corners = hull.points[hull.vertices]
    return Mesh(corners, trimesh.convex.convex_hull(corners).faces, is_convex=True)


def wedges() -> Mesh:
    """A ring of 12 wedges, 10 mm high, with a hole of 15 mm radius in a body of 20 mm radius."""
    angles = np.arange(13) * np.pi / 6
    pieces = []
    for one, other in pairwise(angles):
        points = [
            (r * np.cos(a), r * np.sin(a), z)
            for r in (0.015, 0.020)
            for a in (one, other)
            for z in (0.0, 0.01)
        ]
        pieces.append(Mesh(points, trimesh.convex.convex_hull(points).faces, is_convex=True))
    points = np.vstack([piece.points for piece in pieces])
    around = trimesh.convex.convex_hull(points)
    return Mesh(around.vertices, around.faces, True, tuple(pieces))


RING = wedges()
UPRIGHT = pin.SE3.Identity()


def at(*xyz: float) -> pin.SE3:
    return pin.SE3(np.eye(3), np.array(xyz))


def test_a_ball_in_the_hole_of_a_ring_is_as_far_from_it_as_from_its_nearest_wedge():
    ball = Sphere(0.005)
    wanted = 0.015 * np.cos(np.pi / 12) - 0.005
    assert planned.distance(RING, UPRIGHT, ball, at(0, 0, 0.005)) == pytest.approx(wanted, abs=1e-6)
    assert proven.gap_of((RING, UPRIGHT), (ball, at(0, 0, 0.005))) == pytest.approx(
        wanted, abs=1e-6
    )


def test_a_ring_about_a_ring_is_clear_where_their_hulls_are_in_each_other():
    small = tuple(Mesh(p.points * [0.5, 0.5, 1], p.triangles, True) for p in RING.pieces)
    inner = Mesh(RING.points * [0.5, 0.5, 1], RING.triangles, True, small)
    assert planned.distance(RING, UPRIGHT, inner, UPRIGHT) > 0.004
    assert proven.gap_of((RING, UPRIGHT), (inner, UPRIGHT)) > 0.004


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_planning_compiled_code_and_the_proof_agree_on_bodies_with_pieces(seed):
    rng = np.random.default_rng(seed)
    other = Box(np.array([0.006, 0.01, 0.02])) if seed % 2 else RING
    T = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(0, 0.02, 3))
    U = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(0, 0.02, 3))
    far = planned.distance(RING, T, other, U)
    apart = proven.gap_of((RING, T), (other, U))
    assert (far > 0) == (apart > 0)
    if far > 0:
        assert apart == pytest.approx(far, abs=1e-6)
    shapes, poses = [RING, other], [T, U]
    centres = np.array([extent(shape)[0] for shape in shapes])
    cores = cores_of(shapes, centres)
    R = np.array([pose.rotation for pose in poses])
    c = np.array([pose.act(centre) for pose, centre in zip(poses, centres, strict=True)])
    W = np.empty((15, 3))
    if far > 1e-4:
        assert side(0, 1, R, c, cores, far - 1e-5, far - 1e-5, W) == CLEAR
        assert side(0, 1, R, c, cores, far + 1e-5, far + 1e-5, W) == TOUCHES
    elif far < -1e-4:
        assert side(0, 1, R, c, cores, 0.0, 0.0, W) == TOUCHES


def test_the_nearest_of_several_bodies_is_as_far_as_the_smallest_gap():
    rng = np.random.default_rng(7)
    shapes = [RING, Box(np.array([0.006, 0.01, 0.02])), Sphere(0.004)] * 3
    others = [
        (shape, pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(0, 0.03, 3))) for shape in shapes
    ]
    for body in ((Sphere(0.003), UPRIGHT), (RING, at(0.01, 0.05, 0.0))):
        smallest = min(proven.gap_of(body, other) for other in others)
        assert proven.least_gap(body, others) == smallest
        assert proven.least_gap(body, others, smallest + 0.001) == smallest
        assert proven.least_gap(body, others, smallest - 0.001) == smallest - 0.001


def test_pieces_enter_the_digest_and_a_mesh_without_them_keeps_its_own():
    plain = Mesh(RING.points, RING.triangles, True)
    assert digest_of(plain) != digest_of(RING)
    assert "pieces" not in canonical(plain)
