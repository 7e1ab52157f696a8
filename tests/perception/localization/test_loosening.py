"""Parts that are not as their CAD file has them, and scans worse than their noise says."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.ndimage import maximum_filter

from workbench.formats.parts.reading import read_part
from workbench.perception.localization import kinds
from workbench.perception.localization.certainty import loose_probability_of
from workbench.perception.localization.kinds import localize_parts
from workbench.perception.parts.sizing import sized
from workbench.perception.simulation.noise_models import NOISE_MODELS
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.perception.views.camera import Pinhole
from workbench.plugins.progress import never, silent

SMALLER = 0.93
"""A CAD file over the part that lies there."""


@pytest.fixture(scope="module")
def bracket():
    return read_part("bracket")


@pytest.fixture(scope="module")
def lying(cell, bracket):
    return drop_parts((bracket,) * 6, cell.bin, seed=9000)


def found(cell, part, scan):
    return localize_parts(
        scan, replace(cell, parts=(part,)), seed=0, detail=1.0, report=silent, cancelled=never
    ).result


def right(result, truth, part):
    """How many true parts have a detection within 6 % of the diameter."""
    middle = part.mesh.points.mean(axis=0)
    far = 0.06 * np.linalg.norm(np.ptp(part.mesh.points, axis=0))
    places = [one.T_world_part.act(middle) for one in result.detections]
    true = [one.T_world_part.act(middle) for one in truth]
    return sum(any(np.linalg.norm(p - t) < far for p in places) for t in true)


@pytest.mark.parametrize("noise", ["structured_light", "stereo"])
def test_parts_larger_than_their_cad_file_are_found(cell, part, noise, monkeypatch):
    truth = drop_parts((part,) * 6, cell.bin, seed=9000)
    scan = synthesize(cell, truth, seed=1, noise=NOISE_MODELS[noise])
    small = sized(part, SMALLER)
    # What the floor shows of their size is another matter.
    monkeypatch.setattr(kinds, "allow_changes", lambda found, _: found)
    result = found(cell, small, scan)
    monkeypatch.setattr(kinds, "relax_tolerance", lambda found, _: found)
    strict = found(cell, small, scan)
    assert right(result, truth, part) >= 4
    assert right(strict, truth, part) <= 2


def test_a_pile_that_is_explained_is_not_searched_with_more_tolerance(cell, bracket, lying):
    seen = replace(cell, parts=(bracket,))
    scan = synthesize(seen, lying, seed=1)
    result = found(cell, bracket, scan)
    assert right(result, lying, bracket) >= 4
    assert max(one.residual for one in result.detections) < 0.0005


def test_other_parts_are_not_found_with_more_tolerance(cell, bracket, part):
    truth = drop_parts((part,) * 5, cell.bin, seed=9000)
    scan = synthesize(cell, truth, seed=1, noise=NOISE_MODELS["structured_light"])
    result = found(cell, bracket, scan)
    assert all((one.probability or 0.0) < 0.5 for one in result.detections)


@pytest.mark.parametrize(
    ("noise", "deviation", "seed"),
    [("structured_light", 0.0004, 300057), ("time_of_flight", 0.0025, 300093)],
)
def test_bolts_are_not_found_on_thicker_cylinders(cell, part, noise, deviation, seed):
    bolt = read_part("bolt")
    seen = replace(cell, scanner=replace(cell.scanner, depth_noise=deviation), parts=(part,))
    truth = drop_parts((part,) * 8, cell.bin, seed=seed)
    scan = synthesize(seen, truth, seed=seed, noise=NOISE_MODELS[noise])
    assert all((one.probability or 0.0) <= 0.5 for one in found(seen, bolt, scan).detections)


def eaten(cell, scan, pixels):
    """The scan of a camera whose far things grow over near ones by so many pixels."""
    camera = Pinhole.of_scanner(cell.scanner)
    depth = np.zeros(camera.shape)
    depth.ravel()[scan.pixels] = scan.points[:, 2]
    has = depth > 0
    grown = np.where(has, maximum_filter(depth, size=2 * pixels + 1), 0.0)
    points = (camera.rays() * grown[..., None])[has]
    return replace(scan, points=points)


@pytest.mark.parametrize(("name", "pixels", "fewest"), [("bolt", 2, 5), ("keyed_cylinder", 3, 4)])
def test_parts_are_found_by_a_camera_that_eats_their_outlines(cell, name, pixels, fewest):
    one = read_part(name)
    truth = drop_parts((one,) * 6, cell.bin, seed=9000)
    seen = replace(cell, parts=(one,))
    scan = synthesize(seen, truth, seed=1, noise=NOISE_MODELS["structured_light"])
    result = found(cell, one, eaten(cell, scan, pixels))
    assert right(result, truth, one) >= fewest


def test_what_is_hidden_says_nothing_where_more_is_tolerated():
    assert loose_probability_of(0.7, 0.9) > 0.9
    assert loose_probability_of(0.7, 0.4) < 0.5
    assert loose_probability_of(0.1, 1.0) < 0.2
