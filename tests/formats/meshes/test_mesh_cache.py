"""What was read or made once is there at the next start, and only if nothing has changed."""

import os
import subprocess
import sys

import numpy as np
import pytest
import trimesh

from workbench.formats.meshes import reading
from workbench.formats.meshes.mesh_cache import cache_folder, load_or_make
from workbench.formats.meshes.pieces.convex_pieces import hull_of
from workbench.formats.meshes.reading import read_mesh
from workbench.model.errors import FileError


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "cache"))
    cache_folder.cache_clear()
    yield tmp_path / "cache" / "workbench" / "pieces"
    cache_folder.cache_clear()


@pytest.fixture
def file(tmp_path):
    path = tmp_path / "part.stl"
    trimesh.creation.box((0.1, 0.2, 0.3)).export(path)
    return path


def test_a_mesh_is_read_once_for_each_scale(file, monkeypatch):
    first, half = read_mesh(file), read_mesh(file, 0.5)
    loaded = []
    monkeypatch.setattr(reading, "_load_mesh", lambda *given: loaded.append(given))
    again = read_mesh(file)
    assert np.array_equal(again.points, first.points)
    assert np.array_equal(again.triangles, first.triangles)
    assert again.triangles.dtype == first.triangles.dtype and not again.is_convex
    assert np.array_equal(read_mesh(file, (0.5, 0.5, 0.5)).points, half.points)
    assert loaded == []


def test_a_file_that_was_changed_is_read_anew(file):
    assert np.ptp(read_mesh(file).points, axis=0) == pytest.approx((0.1, 0.2, 0.3))
    trimesh.creation.box((0.1, 0.2, 0.4)).export(file)
    assert np.ptp(read_mesh(file).points, axis=0) == pytest.approx((0.1, 0.2, 0.4))


def test_what_is_wrong_is_wrong_again(file, own_cache):
    file.write_text("no mesh")
    for _ in range(2):
        with pytest.raises(FileError, match=r"part\.stl"):
            read_mesh(file)
    assert not own_cache.exists()


def test_a_mesh_is_no_convex_piece_because_it_was_read(tmp_path):
    file = tmp_path / "open.obj"
    two = trimesh.util.concatenate([trimesh.creation.box((0.1,) * 3) for _ in range(2)])
    two.vertices[:8] += 0.2
    two.export(file)
    read_mesh(file)
    with pytest.raises(FileError, match="called convex"):
        read_mesh(file, is_piece=True)


def test_code_and_content_that_are_others_make_something_else(own_cache):
    made = {
        (code, content): load_or_make(code, content, lambda k=k: {"k": np.array(k)})
        for k, (code, content) in enumerate(
            [("one", (b"ab", b"c")), ("one", (b"a", b"bc")), ("other", (b"ab", b"c"))]
        )
    }
    assert [int(one["k"]) for one in made.values()] == [0, 1, 2]
    assert len(list(own_cache.iterdir())) == 3


def test_hulls_of_parts_are_convex_again(file):
    one, other = hull_of(read_mesh(file)), hull_of(read_mesh(file))
    assert one.is_convex and other.is_convex
    assert np.array_equal(one.points, other.points)


@pytest.mark.extensive
def test_a_second_start_imports_no_readers_of_meshes(tmp_path):
    asks = (
        "import sys; from workbench.app.picking.pipeline import plan_pick; "
        "from workbench.formats.cells.reading import read_cell; read_cell('yumi'); "
        "print(sorted({'trimesh', 'scipy.spatial', 'scipy.sparse'} & set(sys.modules)))"
    )
    said = [
        subprocess.run([sys.executable, "-c", asks], env=os.environ, capture_output=True, text=True)
        for _ in range(2)
    ]
    assert [one.stdout.strip() for one in said][1] == "[]", said
    assert "trimesh" in said[0].stdout, "the first one reads them"
