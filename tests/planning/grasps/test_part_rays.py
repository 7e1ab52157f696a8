"""Rays and nearest points against answers that can be worked out by hand, or another way."""

import numpy as np
import pytest
import trimesh

from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh
from workbench.planning.grasps.part_rays import (
    NO_TRIANGLE,
    RayGrid,
    first_hits,
    nearest_points,
    normals_of,
    samples_of,
    tops,
)


def mesh_of(surface: trimesh.Trimesh) -> Mesh:
    return Mesh(surface.vertices, surface.faces)


@pytest.fixture(scope="module")
def box() -> Mesh:
    return mesh_of(trimesh.creation.box((0.02, 0.04, 0.06)))


def test_normals_look_outward_and_areas_add_up(box):
    normals, areas = normals_of(box)
    middles = box.points[box.triangles].mean(axis=1)
    assert (np.einsum("ij,ij->i", normals, middles) > 0).all()
    assert areas.sum() == pytest.approx(2 * (0.02 * 0.04 + 0.04 * 0.06 + 0.02 * 0.06))


def test_rays_meet_the_nearest_face_and_miss_what_is_behind_them(box):
    origins = np.array([[0.05, 0.001, 0.002], [0.0, 0.0, 0.0], [0.05, 0.0, 0.0], [0.0, 0.0, 0.0]])
    directions = np.array([[-1.0, 0, 0], [0, 0, 1.0], [1.0, 0, 0], [0, -1.0, 0]])
    distances, met = first_hits(box, origins, directions)
    assert distances[[0, 1, 3]] == pytest.approx([0.04, 0.03, 0.02])
    assert np.isinf(distances[2]) and met[2] == NO_TRIANGLE
    assert normals_of(box)[0][met[0]] == pytest.approx([1, 0, 0])


def test_no_ray_slips_through_an_edge_or_a_corner(box):
    # Through the middle of a face runs the diagonal that parts its two triangles.
    grid = np.linspace(-0.009, 0.009, 7)
    origins = np.array([[x, 2 * x, 0.1] for x in grid])
    distances, _ = first_hits(box, origins, np.tile([0.0, 0.0, -1.0], (7, 1)))
    assert distances == pytest.approx(np.full(7, 0.07))


def test_nearest_points_are_those_of_a_dense_sampling():
    mesh = read_part("keyed_cylinder").mesh
    rng = np.random.default_rng(3)
    points = rng.uniform(-0.06, 0.06, (60, 3))
    found, distances, triangles = nearest_points(mesh, points)
    dense, _ = samples_of(mesh, 60_000, rng)
    sampled = np.linalg.norm(points[:, None] - dense[None], axis=2).min(axis=1)
    assert (distances <= sampled + 1e-12).all()
    assert np.abs(distances - sampled).max() < 5e-4
    assert np.linalg.norm(found - points, axis=1) == pytest.approx(distances)
    # They lie in the planes of the triangles named.
    normals, _ = normals_of(mesh)
    off = np.einsum(
        "ij,ij->i", found - mesh.points[mesh.triangles[triangles][:, 0]], normals[triangles]
    )
    assert np.abs(off).max() < 1e-12


def test_of_many_triangles_none_nearer_is_passed_over():
    ball = trimesh.creation.icosphere(4, radius=0.03)
    mesh = Mesh(ball.vertices * [1.0, 0.5, 0.2], ball.faces)
    points = np.random.default_rng(4).uniform(-0.05, 0.05, (40, 3))
    found, distances, triangles = nearest_points(mesh, points)
    every = [
        nearest_points(Mesh(mesh.points, triangle[None]), points) for triangle in mesh.triangles
    ]
    assert distances == pytest.approx(np.min([one[1] for one in every], axis=0), abs=1e-15)
    for point, (place, triangle) in enumerate(zip(found, triangles, strict=True)):
        assert every[triangle][0][point] == pytest.approx(place, abs=1e-15)


def test_of_equally_near_triangles_the_first_one_counts():
    box = trimesh.creation.box((0.02, 0.02, 0.02)).subdivide().subdivide()
    mesh = Mesh(box.vertices, box.faces)
    corners = mesh.points[np.unique(mesh.triangles)]
    _, distances, triangles = nearest_points(
        mesh, 1.5 * corners[np.abs(corners).min(axis=1) > 0.009]
    )
    assert len(triangles) == 8 and (distances > 0.008).all()
    for number, corner in zip(triangles, corners[np.abs(corners).min(axis=1) > 0.009], strict=True):
        touching = (mesh.points[mesh.triangles] == corner).all(axis=2).any(axis=1)
        assert number == np.flatnonzero(touching)[0]


def test_samples_are_spread_by_area_and_the_same_for_the_same_seed(box):
    points, triangles = samples_of(box, 5000, np.random.default_rng(1))
    again, _ = samples_of(box, 5000, np.random.default_rng(1))
    assert np.array_equal(points, again)
    _, areas = normals_of(box)
    shares = np.bincount(triangles, minlength=12) / 5000
    assert np.abs(shares - areas / areas.sum()).max() < 0.002
    assert nearest_points(box, points)[1].max() < 1e-12


def test_what_comes_down_a_ray_meets_the_first_face_below_its_limit():
    slabs = trimesh.util.concatenate(
        [
            trimesh.creation.box((1, 1, 0.2), trimesh.transformations.translation_matrix([0, 0, z]))
            for z in (0.0, 1.0)
        ]
    )
    grid = RayGrid(-0.25, -0.25, 0.25, (3, 3))
    points, triangles = np.asarray(slabs.vertices), np.asarray(slabs.faces)

    def height(limit: float, sense: float) -> float:
        heights, met = tops(points, triangles, grid, np.full((3, 3), limit), sense)
        assert (met >= 0).all() and np.ptp(heights) < 1e-12
        return float(heights[0, 0])

    assert height(5.0, 1.0) == pytest.approx(1.1)
    assert height(0.5, 1.0) == pytest.approx(0.1)
    assert height(1.0, 1.0) == pytest.approx(1.1), "starts inside, so it is where the ray leaves"
    assert height(5.0, -1.0) == pytest.approx(0.1), "from below the lower side of the lower slab"
    nothing, met = tops(points, triangles, grid, np.full((3, 3), -3.0), 1.0)
    assert np.isnan(nothing).all() and (met == NO_TRIANGLE).all()
    nowhere, _ = tops(points, triangles, grid, np.full((3, 3), np.nan), 1.0)
    assert np.isnan(nowhere).all()
