"""Colours of triangles as CAD and drawing programs write them."""

import numpy as np
import pytest
import trimesh
from PIL import Image

from workbench.formats.meshes.face_colours import read_face_colours
from workbench.formats.meshes.reading import read_mesh
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


def textured(box):
    """The box as a picture paints it along y: its left half green, the right red below blue."""
    picture = np.zeros((64, 64, 3), np.uint8)
    picture[:, :32] = (0, 160, 0)
    picture[:32, 32:] = (30, 30, 200)
    picture[32:, 32:] = (200, 30, 30)
    made = trimesh.Trimesh(box.vertices[box.faces].reshape(-1, 3), np.arange(36).reshape(12, 3))
    # Seen along y: x goes to the right in the picture and z upwards.
    uv = made.vertices[:, [0, 2]] / (40.0, 20.0) + 0.5
    material = trimesh.visual.material.PBRMaterial(baseColorTexture=Image.fromarray(picture))
    made.visual = trimesh.visual.TextureVisuals(uv=uv, material=material)
    return made


def test_a_texture_is_averaged_over_each_triangle(tmp_path, box):
    made = textured(box)
    made.apply_scale(0.001)  # a GLB file is in metres
    made.export(tmp_path / "box.glb")
    part = read_part(part_file(tmp_path, 'file = "box.glb"\nunit = "m"'))
    # Its triangles are those of the mesh: colours go with the faces that look there.
    mesh = trimesh.Trimesh(part.mesh.points, part.mesh.triangles, process=False)
    left, right, top, bottom = (
        np.flatnonzero(mesh.face_normals @ direction > 0.9)
        for direction in ((-1, 0, 0), (1, 0, 0), (0, 0, 1), (0, 0, -1))
    )
    np.testing.assert_array_equal(part.colours[left], np.tile([0, 160, 0], (2, 1)))
    # The right end is half red and half blue: one of its triangles lies more in the one half.
    red, _, blue = part.colours[right].astype(int).T
    assert min(red) > 60 and min(blue) > 60
    assert (red[0] - blue[0]) * (red[1] - blue[1]) < 0
    # Above half green, half blue; below half green, half red: no corner's colour alone.
    assert np.all(part.colours[top][:, 2] > 60) and np.all(part.colours[top][:, 1] > 60)
    assert np.all(part.colours[bottom][:, 0] > 60) and np.all(part.colours[bottom][:, 1] > 60)
    assert np.all(part.colours[top][:, 0] < 40) and np.all(part.colours[bottom][:, 2] < 40)


def test_bodies_with_materials_keep_their_order(tmp_path, box):
    scene = trimesh.Scene()
    for number, factor in enumerate(([1.0, 0.0, 0.0, 1.0], [0.0, 0.2159, 1.0, 1.0])):
        body = box.copy()
        body.visual = trimesh.visual.TextureVisuals(
            uv=np.zeros((len(body.vertices), 2)),
            material=trimesh.visual.material.PBRMaterial(baseColorFactor=factor),
        )
        body.apply_translation((0, 0, 100 * number))
        scene.add_geometry(body)
    scene.export(tmp_path / "two.glb")
    mesh = read_mesh(tmp_path / "two.glb", 0.001)
    colours = read_face_colours(tmp_path / "two.glb", len(mesh.triangles))
    above = mesh.points[mesh.triangles].mean(axis=1)[:, 2] > 0.05
    assert np.count_nonzero(above) == 12
    np.testing.assert_array_equal(colours[~above], np.tile([255, 0, 0], (12, 1)))
    # 0.2159 of the light is 128 in sRGB, by which files of glTF do not tell it.
    np.testing.assert_allclose(colours[above], np.tile([0, 128, 255], (12, 1)), atol=1)


def test_colours_of_corners_in_a_glb_file_are_linear(tmp_path, box):
    colours = np.tile([0, 55, 255, 255], (len(box.vertices), 1)).astype(np.uint8)
    box.visual = trimesh.visual.ColorVisuals(box, vertex_colors=colours)
    box.export(tmp_path / "box.glb")
    found = read_face_colours(tmp_path / "box.glb", 12)
    np.testing.assert_allclose(found, np.tile([0, 128, 255], (12, 1)), atol=1)


def test_a_file_without_colours_is_refused(tmp_path):
    bare = trimesh.creation.box((40.0, 30.0, 20.0))
    bare.export(tmp_path / "bare.ply")
    with pytest.raises(FileError, match="has no colours"):
        read_part(part_file(tmp_path, 'file = "bare.ply"'))
    bare.export(tmp_path / "bare.glb")
    with pytest.raises(FileError, match="has no colours"):
        read_part(part_file(tmp_path, 'file = "bare.glb"\nunit = "mm"'))
    bare.export(tmp_path / "bare.stl")
    with pytest.raises(FileError, match="its colours cannot be used"):
        read_part(part_file(tmp_path, 'file = "bare.stl"'))


def test_what_is_cut_off_is_refused(tmp_path, box):
    box.export(tmp_path / "box.ply")
    path = tmp_path / "box.ply"
    path.write_bytes(path.read_bytes()[:-40])
    with pytest.raises(FileError):
        read_face_colours(path, 12)
