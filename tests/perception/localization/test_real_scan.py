"""A real recording: a carton taught by a point cloud is found on a table with other things.

Data: PointCloudLibrary/data, tutorials/correspondence_grouping (BSD); a Kinect, some 2 mm of noise.
"""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from scipy.spatial import KDTree
from searching import localize
from stand_ins import TURN, folder_of, make_recording, sources

from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_cloud
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Bin
from workbench.model.scan import Scan

PART = """
name = "carton"
mass_g = 500
[mesh]
file = "{}"
unit = "m"
"""


@pytest.fixture(scope="module", params=sources("real_scan"))
def data(request, tmp_path_factory):
    """The folder with the recording and the cloud by which its part is taught."""
    made = tmp_path_factory.mktemp("recording")
    return folder_of(request.param, "real_scan", make_recording, made)


@pytest.fixture(scope="module")
def part(data, tmp_path_factory):
    folder = tmp_path_factory.mktemp("carton")
    (folder / "part.toml").write_text(PART.format(data / "milk.pcd"))
    return read_part(folder)


@pytest.fixture(scope="module")
def scene(data) -> Scan:
    found = read_cloud(data / "scene_milk_carton_clorox.pcd", pin.SE3.Identity())
    # The recording looks along -z; a scanner here looks along z.
    points = found.points @ TURN.T
    return Scan(points, pin.SE3.Identity(), found.source, found.pixels, found.resolution)


def test_a_taught_part_is_the_hull_of_its_points(part):
    assert len(part.pieces) == 1 and part.pieces[0].shape.is_convex
    assert np.ptp(part.mesh.points, axis=0).min() > 0.1
    assert np.abs(part.mesh.points).max() < 0.2


@pytest.mark.parametrize(("seed", "floor"), [(0, 1.1), (1, 1.1), (0, 1.2)])
def test_the_carton_is_found_where_it_stands(data, part, scene, seed, floor):
    """With the noise that cells have when nobody says one: the scan tells its own."""
    cell = read_cell("yumi")
    bin = Bin(pose_from_rpy((0, 0, floor), (np.pi, 0, 0)), np.array([2.4, 2.4, 0.7]))
    mount = replace(cell.scanner, T_world_scanner=pin.SE3.Identity(), near=0.3, far=3.0)
    cell = replace(cell, parts=(part,), bin=bin, scanner=mount)
    best = localize(scene, part, cell, seed=seed)[0]
    taught = read_cloud(data / "milk.pcd", pin.SE3.Identity()).points
    points = taught - taught.mean(axis=0)
    there = points @ best.T_world_part.rotation.T + best.T_world_part.translation
    distances = KDTree(scene.points).query(there)[0]
    assert np.mean(distances < 0.010) > 0.95
    assert np.median(distances) < 0.004
    assert best.residual < 0.003
