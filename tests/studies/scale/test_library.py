"""A library of many kinds, written from the shipped parts."""

import numpy as np

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.studies.scale.library import LARGER_BY, SHAPES, SMALLEST, write_library


def test_every_kind_has_a_name_and_a_size_of_its_own(tmp_path):
    count = 2 * len(SHAPES) + 1
    cell = read_cell(write_library(tmp_path, "yumi", count))
    assert len({part.name for part in cell.parts}) == len({p.digest for p in cell.parts}) == count
    shipped = np.ptp(read_part(SHAPES[0]).mesh.points, axis=0)
    for k, part in enumerate(cell.parts[:: len(SHAPES)]):
        size = SMALLEST * LARGER_BY**k
        np.testing.assert_allclose(np.ptp(part.mesh.points, axis=0), size * shipped, rtol=1e-4)
        assert part.grasps
