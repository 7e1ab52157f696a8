"""Parts whose faces look alike at every turn, and whose outline does not: the corners of a nut."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.perception.matching.pose_error import pose_error
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import find_parts


def cell_of(kind: str):
    cell = read_cell(find("robots", "yumi") / "assembly.toml")
    part = cell.part(kind)
    return replace(cell, parts=(part,))


def found(cell, truth: Detection, like: str):
    scanner = replace(cell.scanner, options={**cell.scanner.options, "like": like})
    cell = replace(cell, scanner=scanner)
    (detection,) = find_parts(synthesize(cell, (truth,), seed=5), cell, seed=5).detections
    return detection


@pytest.mark.parametrize("like", ["fine", "structured_light"])
def test_a_spacer_on_its_end_shows_its_roll_by_its_six_corners(like):
    cell = cell_of("spacer")
    known = 0
    for yaw in (0.1, 0.3, 0.5, 0.7, 0.9, 1.1):
        T = pose_from_rpy((0.02, -0.06, 0.0105), (0.0, 0.0, yaw))
        truth = Detection("spacer", cell.bin.T_world_bin * T)
        detection = found(cell, truth, like)
        _, turn = pose_error(cell.part("spacer"), truth.T_world_part, detection.T_world_part)
        known += detection.roll_known
        assert turn < np.deg2rad(3.0) or not detection.roll_known
    assert known >= {"fine": 4, "structured_light": 2}[like]


def test_a_spacer_whose_corners_are_all_hidden_shows_none():
    """Only the middle of its end is measured, a ring about the bore."""
    cell = cell_of("spacer")
    T = cell.bin.T_world_bin * pose_from_rpy((0.02, -0.06, 0.0105))
    scan = synthesize(cell, (Detection("spacer", T),), seed=5)
    away = np.linalg.norm((scan.points_world - T.translation)[:, :2], axis=1)
    near = (away < 0.0145) | (away > 0.05)
    hidden = replace(
        scan,
        points=scan.points[near],
        pixels=None if scan.pixels is None else scan.pixels[near],
    )
    for detection in find_parts(hidden, cell, seed=5).detections:
        assert not detection.roll_known
