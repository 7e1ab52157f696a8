"""Colours of points: those that other programs write are read, and ours come back."""

from pathlib import Path

import numpy as np
import open3d as o3d
import pinocchio as pin
import pytest

from workbench.formats.clouds.colours import of_channels
from workbench.formats.clouds.scans import CLOUD_AXES, parse_cloud, read_cloud, write_cloud
from workbench.model.errors import InputError
from workbench.model.scan import Scan

HERE = pin.SE3.Identity()
GENERATOR = np.random.default_rng(4)
POINTS = GENERATOR.uniform(0.2, 0.8, (40, 3)).astype(np.float32).astype(float)
COLOURS = GENERATOR.integers(0, 256, (40, 3), dtype=np.uint8)


@pytest.fixture
def cloud():
    made = o3d.geometry.PointCloud(o3d.utility.Vector3dVector(POINTS))
    made.colors = o3d.utility.Vector3dVector(COLOURS / 255.0)
    return made


@pytest.mark.parametrize("kind", [".ply", ".pcd"])
@pytest.mark.parametrize(
    "how", [{"write_ascii": True}, {"write_ascii": False}, {"compressed": True}]
)
def test_colours_written_by_open3d_are_read(tmp_path, cloud, kind, how):
    path = tmp_path / f"foreign{kind}"
    assert o3d.io.write_point_cloud(str(path), cloud, **how)
    scan = read_cloud(path, HERE)
    np.testing.assert_allclose(scan.points, POINTS, atol=1e-6)
    np.testing.assert_array_equal(scan.colours, COLOURS)


def test_points_that_are_dropped_take_their_colours_along(tmp_path, cloud):
    points = POINTS.copy()
    points[[0, 7]] = 0.0
    cloud.points = o3d.utility.Vector3dVector(points)
    path = tmp_path / "holes.ply"
    assert o3d.io.write_point_cloud(str(path), cloud)
    np.testing.assert_array_equal(
        read_cloud(path, HERE).colours, np.delete(COLOURS, [0, 7], axis=0)
    )


def test_a_scan_with_colours_comes_back_as_the_same(tmp_path):
    scan = Scan(POINTS, HERE, "x", np.arange(40), (8, 5), colours=COLOURS)
    write_cloud(tmp_path / "x.ply", scan)
    back = read_cloud(tmp_path / "x.ply", HERE)
    assert back.digest == scan.digest
    assert back.colours.dtype == np.uint8
    write_cloud(tmp_path / "turned.ply", scan, unit="mm", axes="z_back")
    turned = read_cloud(tmp_path / "turned.ply", HERE, unit="mm")
    np.testing.assert_allclose(turned.points @ np.array(CLOUD_AXES["z_back"]).T, POINTS, atol=1e-9)
    np.testing.assert_array_equal(turned.colours, COLOURS)


def test_colours_are_part_of_the_digest_and_none_leave_it_as_it_was():
    bare = Scan(POINTS, HERE, "x")
    one = Scan(POINTS, HERE, "x", colours=COLOURS)
    assert (
        len({bare.digest, one.digest, Scan(POINTS, HERE, "x", colours=255 - COLOURS).digest}) == 3
    )
    assert Scan(POINTS, HERE, "x", colours=None).digest == bare.digest


def test_colours_of_other_points_are_refused():
    with pytest.raises(InputError, match="40 points but colours of shape"):
        Scan(POINTS, HERE, "x", colours=COLOURS[:39])


@pytest.mark.parametrize("kind, full", [("u1", 255), ("u2", 65535), ("f4", 1.0)])
def test_channels_of_every_width_are_shares_of_the_brightest(kind, full):
    shares = np.array([[0.0, 0.2, 1.0]])
    np.testing.assert_array_equal(of_channels(shares * full, kind), [[0, 51, 255]])


def test_a_field_that_nobody_filled_is_no_colour():
    rows = "\n".join("{} {} {} 0 0 0".format(*point) for point in POINTS)
    header = (
        "ply\nformat ascii 1.0\nelement vertex 40\nproperty float x\nproperty float y\n"
        "property float z\nproperty uchar red\nproperty uchar green\nproperty uchar blue\n"
        "end_header\n"
    )
    assert parse_cloud(Path("zero.ply"), (header + rows).encode(), HERE).colours is None
