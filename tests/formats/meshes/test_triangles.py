import io
import re

import numpy as np
import pytest
import trimesh
from trimesh.exchange.dae import export_collada

from workbench.formats.meshes.reading import read_mesh
from workbench.formats.meshes.triangles import stl_of, surface_of, triangles_of
from workbench.model.errors import FileError
from workbench.model.geometry import Box, Capsule, Cylinder, Mesh, Solid, Sphere, pose_from_rpy

SIZE = np.array([0.2, 0.4, 0.6])


@pytest.mark.parametrize(
    ("shape", "extents"),
    [
        (Box(SIZE), SIZE),
        (Cylinder(0.1, 0.3), (0.2, 0.2, 0.3)),
        (Capsule(0.1, 0.3), (0.2, 0.2, 0.5)),
        (Sphere(0.1), (0.2, 0.2, 0.2)),
        (Mesh(np.eye(3), np.array([[0, 1, 2]])), (1, 1, 1)),
    ],
)
def test_a_shape_keeps_its_size_and_centre(shape, extents):
    surface = triangles_of(shape)
    np.testing.assert_allclose(surface.extents, extents, rtol=0.01)
    if not isinstance(shape, Mesh):
        np.testing.assert_allclose(surface.bounds.mean(axis=0), 0, atol=1e-3)


def test_solids_of_a_body_become_one_surface_each_in_its_place():
    left = Solid("left", Box(SIZE), pose_from_rpy((1, 0, 0)))
    right = Solid("right", Sphere(0.1), pose_from_rpy((-1, 0, 0.5), (0, 1, 0)))
    surface = surface_of([left, right])
    np.testing.assert_allclose(surface.bounds, [[-1.1, -0.2, -0.3], [1.1, 0.2, 0.6]], atol=1e-3)
    assert surface.volume == pytest.approx(SIZE.prod() + 4 / 3 * np.pi * 0.1**3, rel=0.02)


def test_an_stl_file_holds_the_same_surface():
    surface = triangles_of(Capsule(0.1, 0.3))
    read = trimesh.load_mesh(io.BytesIO(stl_of(surface)), file_type="stl")
    assert len(read.faces) == len(surface.faces)
    np.testing.assert_allclose(read.bounds, surface.bounds, atol=1e-6)


def test_a_dae_file_keeps_bodies_whose_material_is_missing(tmp_path):
    box = trimesh.creation.box((0.1, 0.2, 0.3))
    text = export_collada(box).decode()
    broken = re.sub(r'(<instance_material [^>]*target=")[^"]*', r"\1#gone", text)
    assert broken != text
    for name, content in (("whole", text), ("broken", broken)):
        (tmp_path / f"{name}.dae").write_text(content)
        mesh = read_mesh(tmp_path / f"{name}.dae")
        assert np.ptp(mesh.points, axis=0) == pytest.approx([0.1, 0.2, 0.3])
        assert len(mesh.triangles) == 12
    (tmp_path / "no.dae").write_text("<COLLADA")
    with pytest.raises(FileError, match="is cut off, or no DAE file"):
        read_mesh(tmp_path / "no.dae")
