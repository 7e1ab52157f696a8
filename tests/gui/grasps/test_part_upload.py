"""The controls that make a part from a CAD file, without a browser."""

import numpy as np

from workbench.formats.cells.drawn_tools import CadDrawing
from workbench.gui.grasps.part_upload import PartUpload


def test_a_part_that_the_cell_has_is_not_made_again_until_it_has_another_name(bench, visitor):
    upload = PartUpload(visitor)
    upload._pick.drawing = CadDrawing("brick.stl", np.zeros(1, np.uint8), "")
    upload._name.value = "brick"
    upload.show(bench.state)
    assert not upload._make.disabled

    upload._name.value = bench.state.cell.parts[0].name
    upload.show(bench.state)
    assert upload._make.disabled
    assert "choose another name" in upload._make.hint

    upload._name.value = "brick"
    upload.show(bench.state)
    assert not upload._make.disabled
