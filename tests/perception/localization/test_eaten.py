"""Outlines that the background eats, as cheap cameras see them."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import maximum_filter

from workbench.formats.parts.reading import read_part
from workbench.model.scan import ALL_KINDS
from workbench.perception.localization import kinds
from workbench.perception.localization.eaten import eaten_width, without_background
from workbench.perception.localization.kinds import localize_parts
from workbench.perception.matching.maps import DepthMap
from workbench.perception.matching.sightings import Sighting
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.views.camera import Pinhole
from workbench.plugins.progress import never, silent
from workbench.studies.localization import BUILDS, compare

SIDE, COLUMNS = 30, 100
"""[pixels] Of a square picture, and of the map that it is in."""


def seen(through: np.ndarray) -> Sighting:
    """A square picture of which the scan looks through these pixels (SIDE, SIDE)."""
    v, u = np.indices((SIDE, SIDE)) + 10
    pixels = v * COLUMNS + u
    return Sighting(
        explained=pixels[~through],
        off=np.zeros(np.count_nonzero(~through)),
        violated=pixels[through],
        is_rim=np.zeros(np.count_nonzero(through), np.bool_),
        hidden=np.arange(0),
        ahead=np.zeros(0),
    )


def rim(width: int) -> np.ndarray:
    inside = np.zeros((SIDE, SIDE), np.bool_)
    inside[width : SIDE - width, width : SIDE - width] = True
    return ~inside


@pytest.mark.parametrize("width", [0, 1, 3])
def test_the_width_is_that_of_the_rim_that_the_scan_looks_through(width):
    assert eaten_width(seen(rim(width)), COLUMNS) == width


def test_a_part_that_is_looked_through_in_its_middle_says_nothing():
    through = rim(2)
    through[12:18, 12:18] = True
    assert eaten_width(seen(through), COLUMNS) is None


def test_a_pose_that_is_off_to_one_side_shows_about_a_quarter_of_the_width():
    through = np.zeros((SIDE, SIDE), np.bool_)
    through[:2] = True
    width = eaten_width(seen(through), COLUMNS)
    assert width == pytest.approx(0.5, abs=0.05)


def a_step(slope: float = 0.0) -> DepthMap:
    """A plane whose left half is 20 mm nearer, its right half sloped so much a pixel."""
    camera = Pinhole(1000.0, np.array([20.0, 5.0]), (10, 40))
    depth = np.full((10, 40), 1.0)
    depth[:, :20] = 0.98
    depth[:, 20:] += slope * np.arange(20)
    normals = np.tile([0.0, 0.0, -1.0], (10, 40, 1))
    return DepthMap(camera, camera.rays(), depth, normals, depth > 0, 0.001)


def test_background_close_beside_something_nearer_counts_as_not_measured():
    left = without_background(a_step(), 3, 0.005)
    assert (left.depth[:, 20:23] == 0.0).all() and not left.foreground[:, 20:23].any()
    assert (left.depth[:, 23:] > 0.0).all() and (left.depth[:, :20] == 0.98).all()


def test_steps_that_are_too_low_are_no_other_surface():
    step = a_step()
    assert (without_background(step, 3, 0.03).depth == step.depth).all()


def eaten(cell, scan, pixels):
    """The scan of a camera whose far things grow over near ones by so many pixels."""
    camera = Pinhole.of_scanner(cell.scanner)
    depth = np.zeros(camera.shape)
    depth.ravel()[scan.pixels] = scan.points[:, 2]
    has = depth > 0
    grown = np.where(has, maximum_filter(depth, size=2 * pixels + 1), 0.0)
    return replace(scan, points=(camera.rays() * grown[..., None])[has])


def test_brackets_are_found_by_a_camera_that_eats_their_outlines(cell, monkeypatch):
    bracket = read_part("bracket")
    build = BUILDS["structured_light"]
    scanner = replace(cell.scanner, depth_noise=build.deviation)
    cell = replace(cell, parts=(bracket,), scanner=scanner)
    truth = pile_of(cell, ALL_KINDS, 6, seed=7401)
    scan = synthesize(cell, truth, seed=7401, noise=build.noise)
    scan = eaten(cell, scan, 2)

    def found_and_wrong() -> tuple[int, int]:
        result = localize_parts(
            scan, cell, seed=7401, detail=1.0, report=silent, cancelled=never
        ).result
        judged, is_found = compare((bracket,), truth, result.detections)
        return sum(is_found), sum(not one.is_right for one in judged)

    found, wrong = found_and_wrong()
    assert found >= 5 and wrong <= 1
    monkeypatch.setattr(kinds, "allow_eaten_outlines", lambda found, *_: found)
    found, _ = found_and_wrong()
    assert found <= 3
