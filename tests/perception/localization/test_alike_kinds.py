"""Two kinds of one shape, one a little larger: the one that lies there is reported."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
import trimesh

from workbench.app.runtime.work import find_parts
from workbench.model.geometry import Box, Mesh, Solid, pose_from_rpy
from workbench.model.part import GraspLibrary, Part
from workbench.model.scan import Detection, Objection
from workbench.model.symmetry import Symmetry, SymmetryAxis
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.progress import never, silent

TILT, DISTANCE = np.deg2rad(40.0), 0.75


def carton(name, *size):
    box = trimesh.creation.box(size)
    piece = Solid("box", Box(np.array(size)), pin.SE3.Identity())
    turns = Symmetry(np.array([0.0, 0, 1]), 2, also=(SymmetryAxis(np.array([1.0, 0, 0]), 2),))
    mesh = Mesh(np.asarray(box.vertices), np.asarray(box.faces))
    return Part(name, mesh, (piece,), 0.3, turns, GraspLibrary())


@pytest.fixture(scope="module")
def table(cell):
    """A table, and a scanner that looks at it obliquely."""
    bin = replace(cell.bin, size=np.array([0.7, 0.7, 0.3]), has_walls=False)
    away = np.array([-np.sin(TILT), 0.0, np.cos(TILT)])
    across = np.array([0.0, -1.0, 0.0])
    rotation = np.stack([across, np.cross(-away, across), -away], axis=1)
    place = bin.T_world_bin.translation + DISTANCE * away
    scanner = replace(
        cell.scanner,
        T_world_scanner=pin.SE3(rotation, place),
        near=0.4,
        far=2.0,
        field_of_view=np.deg2rad(57.0),
        depth_noise=0.0012,
    )
    return replace(cell, bin=bin, scanner=scanner)


SMALL, LARGE = carton("small", 0.211, 0.134, 0.044), carton("large", 0.225, 0.150, 0.064)


def scan_of_small(table, yaw):
    """A scan of the small carton, upright on the table, turned by `yaw` degrees."""
    upright = pose_from_rpy((0, 0, 0.1055), (0, -np.pi / 2, 0))
    turned = pose_from_rpy((0, 0, 0), (0, 0, np.deg2rad(yaw))) * upright
    truth = Detection("small", table.bin.T_world_bin * turned)
    return synthesize(replace(table, parts=(SMALL,)), (truth,), seed=1)


@pytest.mark.parametrize("yaw", [0.0, 20.0, -35.0])
def test_the_smaller_of_two_alike_kinds_is_reported_where_it_stands(table, yaw):
    seen = scan_of_small(table, yaw)
    result = find_parts(
        replace(table, parts=(SMALL, LARGE)), {"scan": seen, "seed": 0}, silent, never
    )
    assert [detection.part for detection in result.detections] == ["small"]


@pytest.mark.extensive
@pytest.mark.parametrize("yaw", [20.0, 40.0])
def test_a_larger_kind_alone_is_not_reported_where_it_would_stand_in_the_table(table, yaw):
    """The close look lays its faces on those of the small carton, and so its foot below."""
    seen = scan_of_small(table, yaw)
    result = find_parts(replace(table, parts=(LARGE,)), {"scan": seen, "seed": 0}, silent, never)
    assert not result.detections
    assert Objection.OUTSIDE in {rejection.reason for rejection in result.rejected}
