"""Convex pieces may be too large, never too small."""

import numpy as np
import pytest
import trimesh
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from workbench.formats.files.shipped import find
from workbench.formats.meshes.kept import cache_folder
from workbench.formats.meshes.pieces.convex_pieces import pieces_of
from workbench.formats.meshes.pieces.cutting import MOST_CORNERS
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

    monkeypatch.setattr("workbench.formats.meshes.pieces.cutting._by_coacd", never)
    again = pieces_of(bracket(), tolerance=0.01)
    closer = pieces_of(bracket(), tolerance=0.009)
    for one, other, third in zip(first.pieces, again.pieces, closer.pieces, strict=True):
        assert np.array_equal(one.points, other.points)
        assert np.array_equal(one.points, third.points)
    assert again.excess == first.excess
    assert len(kept) < len(set(own_cache.iterdir())) == 3, "what was cut, and what two made of it"


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
    assert len(found.pieces[0].points) < 130
    assert uncovered(ball, found.pieces) < 2e-5
    assert found.excess < 0.01


def test_the_shipped_part_is_covered():
    surface = trimesh.load_mesh(find("parts", "keyed_cylinder") / "keyed_cylinder.stl")
    mesh = Mesh(surface.vertices / 1000, surface.faces)
    found = pieces_of(mesh, tolerance=0.001)
    assert uncovered(mesh, found.pieces) < 1e-4
