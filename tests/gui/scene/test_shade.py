"""Things that stand on the table darken it where they stand, and nowhere else."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.gui.scene.shade import PIXEL, shade_of


@pytest.fixture(scope="module")
def aside(cell):
    """The cell with one tray only, which stands to one side."""
    fixtures = tuple(f for f in cell.fixtures if f.name in ("table", "tray_left"))
    return replace(cell, fixtures=fixtures)


def darkness(shade, x: float, y: float) -> int:
    """Of the image at a place of the world [m]."""
    column, row = ((np.array([x, y]) - (shade.middle[:2] - shade.size / 2)) / PIXEL).astype(int)
    return int(shade.image[row, column, 3])


def test_the_shade_lies_below_what_stands_there(aside):
    shade = shade_of(aside)
    x, y, _ = next(f for f in aside.fixtures if f.name == "tray_left").T_world_fixture.translation
    assert darkness(shade, x, y) > 30
    assert darkness(shade, x, -y) == 0
    assert shade.middle[2] < aside.bin.T_world_bin.translation[2]


def test_the_same_cell_has_the_same_shade(aside):
    assert np.array_equal(shade_of(aside).image, shade_of(aside).image)


def test_a_bin_in_the_air_and_a_cell_without_a_table_have_none(cell, aside):
    assert shade_of(replace(cell, fixtures=())) is None
    T = pin.SE3(np.eye(3), aside.bin.T_world_bin.translation - np.array([0.0, 0.0, 2.0]))
    assert shade_of(replace(aside, bin=replace(aside.bin, T_world_bin=T))) is None
