"""Colours of triangles as CAD and drawing programs write them."""

import numpy as np
import pytest
import trimesh

from workbench.formats.meshes.face_colours import read_face_colours
from workbench.formats.parts.reading import read_part
from workbench.model.errors import FileError

FACES = np.arange(48, dtype=np.uint8).reshape(12, 4) * 5 | 1
FACES[:, 3] = 255


@pytest.fixture
def box():
    made = trimesh.creation.box((40.0, 30.0, 20.0))
    made.visual.face_colors = FACES
    return made


def part_file(folder, mesh_line):
    path = folder / "part.toml"
    path.write_text(
        f'name = "box"\nmass_g = 10\n[mesh]\n{mesh_line}\nuse_colours = true\n', encoding="utf-8"
    )
    return path


def test_colours_of_faces_become_those_of_a_part(tmp_path, box):
    box.export(tmp_path / "box.ply")
    part = read_part(part_file(tmp_path, 'file = "box.ply"'))
    np.testing.assert_array_equal(part.colours, FACES[:, :3])
    plain = tmp_path / "plain"
    plain.mkdir()
    box.export(plain / "box.ply")
    path = part_file(plain, 'file = "box.ply"')
    path.write_text(path.read_text().replace("use_colours = true\n", ""), encoding="utf-8")
    assert read_part(path).colours is None
    assert read_part(path).digest != part.digest


@pytest.mark.parametrize("kind", ["ply", "obj"])
def test_colours_of_corners_are_averaged(tmp_path, box, kind):
    colours = np.tile([200, 100, 0, 255], (len(box.vertices), 1)).astype(np.uint8)
    colours[box.vertices[:, 2] > 0] = [20, 40, 60, 255]
    box.visual = trimesh.visual.ColorVisuals(box, vertex_colors=colours)
    path = tmp_path / f"box.{kind}"
    box.export(path)
    found = read_face_colours(path, 12)
    top, bottom = (box.face_normals[:, 2] * side > 0.9 for side in (1, -1))
    np.testing.assert_array_equal(found[top], np.tile([20, 40, 60], (2, 1)))
    np.testing.assert_array_equal(found[bottom], np.tile([200, 100, 0], (2, 1)))


def test_a_file_without_colours_is_refused(tmp_path):
    bare = trimesh.creation.box((40.0, 30.0, 20.0))
    bare.export(tmp_path / "bare.ply")
    with pytest.raises(FileError, match="has no colours"):
        read_part(part_file(tmp_path, 'file = "bare.ply"'))
    bare.export(tmp_path / "bare.stl")
    with pytest.raises(FileError, match="cannot have colours"):
        read_part(part_file(tmp_path, 'file = "bare.stl"'))


def test_what_is_cut_off_is_refused(tmp_path, box):
    box.export(tmp_path / "box.ply")
    path = tmp_path / "box.ply"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(FileError):
        read_face_colours(path, 12)
