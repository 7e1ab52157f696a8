"""A model that is a cloud, in place of a CAD file."""

import numpy as np
import pytest
import trimesh

from workbench.formats.meshes.cad_files import read_cad
from workbench.formats.meshes.cloud_surface import surface_through
from workbench.formats.meshes.repair import examine_surface
from workbench.model.errors import FileError


def normals(mesh):
    a, b, c = mesh.points[mesh.triangles.T]
    return np.cross(b - a, c - a), (a + b + c) / 3


def dome(count=4000):
    """A cap of 60 x 10 mm of a ball on a sheet, as a scanner 0.5 m before it sees it [mm]."""
    x, y = np.random.default_rng(0).uniform(-50, 50, (2, count))
    bulge = np.sqrt(np.maximum(50.0**2 - x**2 - y**2, 40.0**2)) - 40.0
    return np.column_stack([x, y, 500 - bulge])


def test_what_a_scanner_saw_gets_one_layer_that_looks_at_it():
    points = dome()
    mesh = surface_through(points)
    assert mesh is not None
    across, middles = normals(mesh)
    assert ((across * middles).sum(axis=1) < 0).mean() > 0.99
    area = np.linalg.norm(across, axis=1).sum() / 2
    assert area == pytest.approx(100 * 100 - np.pi * 30**2 + 2 * np.pi * 50 * 10, rel=0.03)


def test_one_side_in_the_frame_of_the_part_looks_to_where_it_bulges():
    points = dome()
    mesh = surface_through(points - points.mean(axis=0))
    assert mesh is not None
    across, _ = normals(mesh)
    assert (across[:, 2] < 0).mean() > 0.95


def test_a_cloud_of_all_sides_is_closed():
    solid = trimesh.creation.box((60, 40, 20))
    points, _ = trimesh.sample.sample_surface_even(solid, 3000, seed=0)
    mesh = surface_through(np.asarray(points))
    assert mesh is not None
    report = examine_surface(mesh)
    assert report.is_watertight and report.volume == pytest.approx(solid.volume, rel=0.1)


def test_points_in_a_row_have_no_surface():
    assert surface_through(np.outer(np.arange(50.0), [1, 2, 3])) is None
    assert surface_through(np.zeros((50, 3))) is None


@pytest.mark.parametrize("kind", ["ply", "pcd"])
def test_a_cloud_is_read_as_a_part(tmp_path, kind):
    points, path = dome(), tmp_path / f"dome.{kind}"
    rows = "\n".join(" ".join(f"{value:.4f}" for value in row) for row in points)
    if kind == "ply":
        names = "\n".join(f"property float {name}" for name in "xyz")
        head = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n{names}\nend_header\n"
    else:
        head = (
            "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\n"
            f"WIDTH {len(points)}\nHEIGHT 1\nPOINTS {len(points)}\nDATA ascii\n"
        )
    path.write_text(head + rows + "\n")
    cad = read_cad(path, "mm")
    assert np.ptp(cad.mesh.points, axis=0) == pytest.approx([0.1, 0.1, 0.01], abs=0.003)
    assert not examine_surface(cad.mesh).is_watertight
    path.write_text(head.replace(str(len(points)), "3") + "0 0 1\n1 0 1\n2 0 1\n")
    with pytest.raises(FileError, match="no surface joins"):
        read_cad(path, "mm")
