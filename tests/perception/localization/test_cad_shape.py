"""Parts with a surface that stands off their CAD file all around: found, and told."""

from dataclasses import replace

import pytest
from searching import searched

from workbench.formats.parts.reading import read_part
from workbench.model.scan import OffsetCheck
from workbench.perception.localization.floor_contact import agree
from workbench.perception.parts.growing import grow_surface
from workbench.perception.parts.part_surface import prepare
from workbench.perception.parts.sizing import grown, sized
from workbench.perception.simulation.noise_models import NOISE_MODELS
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.studies.localization import compare

NEAR = 0.0003


@pytest.fixture(scope="module")
def bolt():
    return read_part("bolt")


@pytest.fixture(scope="module")
def truth(cell, bolt):
    return drop_parts((bolt,) * 6, cell.bin, seed=9000)


@pytest.fixture(scope="module")
def scan(cell, bolt, truth):
    seen = replace(cell, parts=(bolt,))
    return synthesize(seen, truth, seed=1, noise=NOISE_MODELS["structured_light"])


@pytest.mark.parametrize("off", [-0.002, -0.0005, 0.0005, 0.002])
def test_parts_off_their_cad_file_are_found_and_the_distance_is_told(cell, bolt, truth, scan, off):
    wrong = grown(bolt, off)
    result = searched(scan, wrong, cell, seed=0)
    judged, _ = compare((wrong,), truth, result.detections)
    assert sum(one.is_right for one in judged) >= 5
    (check,) = result.offsets
    assert check.is_off and check.offset == pytest.approx(-off, abs=NEAR)


def test_a_right_cad_file_is_not_called_wrong(cell, bolt, scan):
    result = searched(scan, bolt, cell, seed=0)
    assert result.offsets == () and not any(check.is_off for check in result.scales)


def test_a_part_that_is_smaller_than_its_file_is_not_said_to_lie_off(cell, bolt, truth, scan):
    wrong = sized(bolt, 1.1, about_middle=True)
    result = searched(scan, wrong, cell, seed=0)
    judged, _ = compare((wrong,), truth, result.detections)
    assert sum(one.is_right for one in judged) >= 5
    assert result.offsets == ()
    assert result.scales[0].ratio == pytest.approx(1 / 1.1, abs=0.01)


def test_a_part_is_not_searched_further_off_than_it_says(cell, bolt, truth, scan):
    wrong = replace(grown(bolt, 0.002), tolerance=0.0005)
    assert all(abs(check.offset) <= 0.0006 for check in searched(scan, wrong, cell, seed=0).offsets)


def test_what_most_parts_show_alike_counts():
    shown = agree([0.0020, 0.0021, 0.0050, -0.001, 0.00205], 0.0003, 3)
    assert shown is not None and shown.value == pytest.approx(0.00205) and shown.count == 3
    assert agree([0.002, 0.004, 0.006], 0.0003, 2) is None
    assert agree([0.002], 0.0003, 2) is None


def test_a_grown_surface_is_as_much_larger_on_each_side(bolt):
    surface = prepare(bolt)
    larger = grow_surface(surface, 0.001)
    high = larger.vertices.max(axis=0) - surface.vertices.max(axis=0)
    low = larger.vertices.min(axis=0) - surface.vertices.min(axis=0)
    assert (high[2], low[2]) == pytest.approx((0.001, -0.001), abs=1e-5)
    assert larger.diameter == pytest.approx(surface.diameter + 0.002)


def test_it_is_said_which_way_and_by_how_much():
    inside = OffsetCheck("bolt", -0.00204, 0.0001, 4)
    assert str(inside.words) == "the surface of bolt seems to lie 2.0 mm inside of its CAD file"
    assert "1.0 mm outside" in str(OffsetCheck("bolt", 0.001, 0.0001, 4).words)
    assert OffsetCheck("bolt", 0.0002, 0.00001, 4).words is None
    assert OffsetCheck("bolt", 0.001, 0.0005, 4).words is None
