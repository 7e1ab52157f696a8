"""Convex pieces may be too large, never too small."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from workbench.formats.files.shipped import find
from workbench.formats.meshes.mesh_cache import cache_folder
from workbench.formats.meshes.pieces.convex_pieces import groups_of, pieces_of
from workbench.formats.meshes.pieces.hulls import MOST_CORNERS
from workbench.formats.meshes.reading import as_convex
from workbench.model.geometry import Mesh


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    cache_folder.cache_clear()
    yield tmp_path / "workbench" / "pieces"
    cache_folder.cache_clear()


def meshed(surface: trimesh.Trimesh) -> Mesh:
    return Mesh(surface.vertices, surface.faces)


def bracket() -> Mesh:
    """An L of 200 x 200 x 40 mm with legs 40 mm wide: its hull is far from it."""
    outline = [(0, 0), (0.2, 0), (0.2, 0.04), (0.04, 0.04), (0.04, 0.2), (0, 0.2)]
    top, bottom = ([(x, y, z) for x, y in outline] for z in (0.02, -0.02))
    caps = [(0, 1, 2), (0, 2, 3), (0, 3, 5), (3, 4, 5)]
    faces = [*caps, *((6 + a, 6 + c, 6 + b) for a, b, c in caps)]
    for i in range(6):
        j = (i + 1) % 6
        faces += [(i, 6 + i, 6 + j), (i, 6 + j, j)]
    return Mesh(np.array([*top, *bottom]), np.array(faces))


def uncovered(mesh: Mesh, pieces: tuple[Mesh, ...]) -> float:
    """How far samples of the surface lie outside of every piece at most [m]."""
    surface = trimesh.Trimesh(mesh.points, mesh.triangles, process=False)
    points = np.vstack([trimesh.sample.sample_surface(surface, 3000, seed=1)[0], mesh.points])
    outside = [
        (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
        for hull in (ConvexHull(piece.points) for piece in pieces)
    ]
    return float(np.min(outside, axis=0).max())


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 9999), st.integers(6, 400))
def test_one_piece_covers_any_cloud_of_triangles(seed, count):
    rng = np.random.default_rng(seed)
    mesh = Mesh(rng.normal(0, 0.1, (count, 3)), rng.integers(0, count, (count, 3)))
    found = pieces_of(mesh, tolerance=1.0)
    assert len(found.pieces) == 1
    assert len(found.pieces[0].points) <= MOST_CORNERS + 40
    assert uncovered(mesh, found.pieces) < 1e-4


def test_a_bracket_is_divided_and_covered_and_little_is_added():
    found = pieces_of(bracket(), tolerance=0.01)
    assert len(found.pieces) > 1
    assert uncovered(bracket(), found.pieces) < 1e-4
    assert found.excess < 0.01
    alone = pieces_of(bracket(), tolerance=0.01, most=1)
    assert len(alone.pieces) == 1 and alone.excess > 0.03


def test_pieces_are_convex_to_whoever_reads_them_again(tmp_path):
    for piece in pieces_of(bracket(), tolerance=0.01).pieces:
        assert as_convex(tmp_path, Mesh(np.round(piece.points, 7), piece.triangles)).is_convex


def test_what_was_divided_once_is_not_divided_again(own_cache, monkeypatch):
    first = pieces_of(bracket(), tolerance=0.01)
    kept = set(own_cache.iterdir())

    def never(*_):
        raise AssertionError("divided again")

    monkeypatch.setattr("workbench.formats.meshes.pieces.splitting.split", never)
    again = pieces_of(bracket(), tolerance=0.01)
    for one, other in zip(first.pieces, again.pieces, strict=True):
        assert np.array_equal(one.points, other.points)
    assert again.excess == first.excess
    assert set(own_cache.iterdir()) == kept


@pytest.mark.parametrize(
    "content", [b"", b"no archive", b"PK\x03\x04 cut off", b"PK\x05\x06" + bytes(18)]
)
def test_a_spoiled_cache_is_made_anew(own_cache, content):
    first = pieces_of(bracket(), tolerance=0.01)
    for kept in own_cache.iterdir():
        kept.write_bytes(content)
    again = pieces_of(bracket(), tolerance=0.01)
    assert len(again.pieces) == len(first.pieces)


def test_where_nothing_can_be_kept_pieces_are_made_all_the_same(own_cache):
    own_cache.parent.mkdir(parents=True, exist_ok=True)
    own_cache.write_text("no folder")
    assert len(pieces_of(bracket(), tolerance=0.01).pieces) > 1


def test_a_flat_mesh_has_none():
    flat = Mesh(np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]]), np.array([[0, 1, 2]]))
    assert pieces_of(flat, tolerance=0.01) is None


def test_a_round_body_keeps_few_corners():
    ball = meshed(trimesh.creation.icosphere(4, 0.1))
    found = pieces_of(ball, tolerance=0.01)
    assert len(found.pieces) == 1
    assert len(found.pieces[0].points) <= MOST_CORNERS + 40
    assert uncovered(ball, found.pieces) < 2e-5
    assert found.excess < 0.01


def test_the_shipped_part_is_covered():
    surface = trimesh.load_mesh(find("parts", "keyed_cylinder") / "keyed_cylinder.stl")
    mesh = Mesh(surface.vertices / 1000, surface.faces)
    found = pieces_of(mesh, tolerance=0.001)
    assert uncovered(mesh, found.pieces) < 1e-4


def tube() -> trimesh.Trimesh:
    return trimesh.creation.annulus(0.014, 0.0165, 0.078)


def angle() -> trimesh.Trimesh:
    return trimesh.util.concatenate(
        [box((0.07, 0.04, 0.006), (0.035, 0, 0.003)), box((0.006, 0.04, 0.045), (0.003, 0, 0.0225))]
    )


def gear() -> trimesh.Trimesh:
    turns = np.arange(96) * 2 * np.pi / 96
    radius = np.where(np.arange(96) // 3 % 2, 0.016, 0.0135)
    outline = np.column_stack([radius * np.cos(turns), radius * np.sin(turns)])
    return trimesh.creation.extrude_triangulation(
        outline, np.array([(0, k, k + 1) for k in range(1, 95)]), 0.012
    )


def cup() -> trimesh.Trimesh:
    profile = np.array([(0, 0), (20, 0), (20, 30), (17, 30), (17, 3), (0, 3)]) / 1000
    return trimesh.creation.revolve(profile, sections=48)


def spring() -> trimesh.Trimesh:
    turns = np.linspace(0, 3 * 2 * np.pi, 90)
    way = np.column_stack([0.01 * np.cos(turns), 0.01 * np.sin(turns), 0.002 * turns / np.pi])
    circle = 0.0015 * np.column_stack([np.cos(a := np.arange(10) * np.pi / 5), np.sin(a)])
    out = np.column_stack([np.cos(turns), np.sin(turns), np.zeros(90)])
    rings = way[:, None] + circle[:, :1] * out[:, None] + circle[:, 1:] * np.array([0, 0, 1.0])
    k, i = np.meshgrid(np.arange(89), np.arange(10), indexing="ij")
    one, other = (k * 10 + i).ravel(), (k * 10 + (i + 1) % 10).ravel()
    faces = np.vstack(
        [np.column_stack([one, one + 10, other]), np.column_stack([other, one + 10, other + 10])]
    )
    ends = [(0, m, m + 1) for m in range(1, 9)], [(890, 890 + m + 1, 890 + m) for m in range(1, 9)]
    surface = trimesh.Trimesh(rings.reshape(-1, 3), np.vstack([faces, *ends]))
    surface.fix_normals()
    return surface


def box(size: tuple[float, ...], at: tuple[float, ...]) -> trimesh.Trimesh:
    return trimesh.creation.box(size, trimesh.transformations.translation_matrix(at))


SHAPES = (tube, angle, gear, cup, spring)


@pytest.mark.parametrize("shape", SHAPES)
def test_pieces_of_a_part_follow_it_within_half_a_millimetre_and_are_nowhere_smaller(shape):
    mesh = meshed(shape())
    found = pieces_of(mesh, tolerance=0.0005, most=256)
    assert found.excess <= 0.00055
    assert uncovered(mesh, found.pieces) < 5e-6


@pytest.mark.parametrize("tolerance", [0.0005, 0.002])
def test_the_figure_of_an_excess_is_what_geometry_says_of_a_tube(tolerance):
    found = pieces_of(meshed(tube()), tolerance=tolerance, most=64)
    points = np.vstack(
        [trimesh.Trimesh(one.points, one.triangles).sample(400, seed=2) for one in found.pieces]
    )
    radius = np.linalg.norm(points[:, :2], axis=1)
    hollow = float((0.014 - radius).max())
    facets = 0.0165 * (1 - np.cos(np.pi / 32))
    assert found.excess - 2 * facets - 1e-4 <= hollow <= found.excess + facets


@pytest.mark.parametrize("shape", SHAPES)
def test_groups_go_around_their_pieces_and_leave_none_out(shape):
    mesh = meshed(shape())
    found = pieces_of(mesh, tolerance=0.0005, most=256)
    groups = groups_of(mesh, found, tolerance=0.005, most=4)
    inside = [piece for group in groups for piece in group.pieces or (group,)]
    assert len(inside) == len(found.pieces)
    assert len(groups) <= 4 or len(found.pieces) <= 4
    for group in groups:
        for piece in group.pieces:
            assert uncovered(piece, (group,)) < 5e-6


def test_a_body_within_a_body_makes_no_hollow():
    hollow = trimesh.util.concatenate([box((0.04,) * 3, (0, 0, 0)), box((0.02,) * 3, (0, 0, 0))])
    found = pieces_of(meshed(hollow), tolerance=0.0005)
    assert len(found.pieces) == 1 and found.excess < 1e-4
