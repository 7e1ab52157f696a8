"""The size of a bin of which nothing is known."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import ALL_KINDS
from workbench.perception.bins.bin_measure import measure_bin
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
@pytest.mark.parametrize("count", [0, 10])
def test_a_bin_is_measured_whatever_lies_in_it(name, count):
    cell = read_cell(name)
    pile = pile_of(cell, ALL_KINDS, count, seed=3) if count else []
    measured = measure_bin(synthesize(cell, pile, seed=3).points)
    assert measured is not None
    outer = np.sort(cell.bin.size[:2] + 2 * cell.bin.wall)[::-1]
    assert measured.outside == pytest.approx(outer, abs=0.003)
    assert measured.height == pytest.approx(cell.bin.size[2], abs=0.005)


def test_a_table_has_no_rim():
    cell = read_cell("yumi")
    table = replace(cell, bin=replace(cell.bin, has_walls=False))
    pile = pile_of(table, ALL_KINDS, 6, seed=4)
    assert measure_bin(synthesize(table, pile, seed=4).points) is None


def test_points_of_one_wall_are_no_bin():
    rng = np.random.default_rng(0)
    wall = rng.uniform(size=(5000, 3)) * (0.3, 0.002, 0.1)
    T = pose_from_rpy((0, 0, 0.6), (np.pi, 0, 0))
    assert measure_bin(wall @ T.rotation.T + T.translation) is None
    assert measure_bin(np.zeros((0, 3))) is None
