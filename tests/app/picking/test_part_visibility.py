"""Whether a scanner sees enough of a part: more pixels, and the verdict with them."""

from dataclasses import replace

import pytest
import trimesh

from workbench.app.picking.part_visibility import visibility
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.geometry import Mesh


@pytest.fixture
def cell():
    return read_cell("yumi")


@pytest.fixture
def washer():
    ring = trimesh.creation.annulus(0.0032, 0.00625, 0.0016)
    return replace(read_part("puck"), name="washer", mesh=Mesh(ring.vertices, ring.faces))


@pytest.mark.extensive
def test_a_part_that_is_found_is_large_enough(cell):
    seen = visibility(cell, read_part("bracket"))
    assert seen.is_enough and seen.pixels > 5000
    assert seen.height == pytest.approx(0.045, abs=1e-3)


def test_a_small_washer_is_not_until_the_scanner_has_more_pixels(cell, washer):
    seen = visibility(cell, washer)
    assert not seen.is_enough and 100 < seen.pixels < 400
    assert seen.height == pytest.approx(0.0016, abs=1e-5)
    wide, high = cell.scanner.resolution
    finer = replace(cell, scanner=replace(cell.scanner, resolution=(2 * wide, 2 * high)))
    again = visibility(finer, washer)
    assert again.is_enough and again.pixels == pytest.approx(4 * seen.pixels, rel=0.1)
