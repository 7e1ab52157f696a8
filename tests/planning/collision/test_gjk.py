"""The compiled distance test against Coal, shape by shape."""

import coal
import numpy as np
import pinocchio as pin
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Shape, Sphere
from workbench.planning.collision.bodies import coal_shape, extent
from workbench.planning.collision.distances.cores import cores_of
from workbench.planning.collision.distances.gjk import CLEAR, TOUCHES, UNCLEAR, side


def hull(seed: int) -> Mesh:
    points = np.random.default_rng(seed).normal(0, 0.04, (30, 3))
    made = ConvexHull(points)
    corners = points[made.vertices]
    again = ConvexHull(corners)
    faces = [
        face
        if np.dot(np.cross(*(corners[face[1:]] - corners[face[0]])), outward) > 0
        else face[::-1]
        for face, outward in zip(again.simplices, again.equations[:, :3], strict=True)
    ]
    return Mesh(corners, np.array(faces), is_convex=True)


SHAPES: list[Shape] = [
    Box(np.array([0.1, 0.05, 0.02])),
    Sphere(0.03),
    Capsule(0.02, 0.1),
    Cylinder(0.04, 0.06),
    hull(0),
    hull(1),
]


def asked(shapes, poses, low: float, high: float) -> int:
    centres = np.array([extent(shape)[0] for shape in shapes])
    cores = cores_of(list(shapes), centres)
    R = np.array([T.rotation for T in poses])
    c = np.array([T.act(centre) for T, centre in zip(poses, centres, strict=True)])
    return side(0, 1, R, c, cores, low, high, np.empty((15, 3)))


def true_distance(shapes, poses) -> float:
    one, two = (coal_shape(shape) for shape in shapes)
    transforms = [coal.Transform3s(T.rotation, T.translation) for T in poses]
    return coal.distance(
        one, transforms[0], two, transforms[1], coal.DistanceRequest(), coal.DistanceResult()
    )


@settings(max_examples=600, deadline=None)
@given(
    seed=st.integers(0, 2**31),
    first=st.integers(0, len(SHAPES) - 1),
    second=st.integers(0, len(SHAPES) - 1),
    reach=st.sampled_from([0.02, 0.1, 0.3]),
)
def test_the_side_is_that_of_coals_distance(seed, first, second, reach):
    rng = np.random.default_rng(seed)
    shapes = (SHAPES[first], SHAPES[second])
    poses = [
        pin.SE3(pin.Quaternion(*rng.normal(size=4)).normalized().matrix(), rng.normal(0, reach, 3))
        for _ in shapes
    ]
    distance = true_distance(shapes, poses)
    # Coal's own tolerance for round shapes, twice.
    for gap in (1e-4, 1e-3, 0.02):
        if distance - gap > 0:
            assert asked(shapes, poses, 0.0, distance - gap) == CLEAR
            assert asked(shapes, poses, distance - gap, distance - gap) == CLEAR
            assert asked(shapes, poses, distance + gap, distance + 2 * gap) == TOUCHES
            assert asked(shapes, poses, distance - gap, distance + gap) == UNCLEAR
        elif distance < -gap:
            assert asked(shapes, poses, 0.0, gap) == TOUCHES


@pytest.mark.parametrize("first", range(len(SHAPES)))
@pytest.mark.parametrize("second", range(len(SHAPES)))
def test_bodies_in_the_same_place_touch(first, second):
    shapes = (SHAPES[first], SHAPES[second])
    assert asked(shapes, [pin.SE3.Identity()] * 2, 0.0, 0.01) == TOUCHES


def test_boxes_face_to_face_are_told_apart():
    box = Box(np.array([0.1, 0.1, 0.1]))
    for gap in (1e-5, 1e-3, 0.05):
        apart = [pin.SE3.Identity(), pin.SE3(np.eye(3), np.array([0.1 + gap, 0.0, 0.0]))]
        assert asked((box, box), apart, 0.0, gap - 1e-6) == CLEAR
        assert asked((box, box), apart, gap + 1e-6, gap + 2e-6) == TOUCHES
        assert asked((box, box), apart, gap - 1e-6, gap + 1e-6) == UNCLEAR
