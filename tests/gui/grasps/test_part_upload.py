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


def test_the_name_follows_the_file_until_a_person_types_one(visitor):
    upload = PartUpload(visitor)
    for file, typed, name in (
        ("pointer.step", "", "pointer"),
        ("panel.step", "", "panel"),
        ("lid.step", "cover", "cover"),
    ):
        upload._pick.drawing = CadDrawing(file, np.zeros(1, np.uint8), "")
        upload._name.value = typed or upload._name.value
        upload._on_chosen()
        assert upload._name.value == name


def test_no_part_is_made_of_a_file_that_was_refused(bench, visitor):
    upload = PartUpload(visitor)
    upload._pick.drawing = CadDrawing("pointer.step", np.zeros(1, np.uint8), "")
    upload._name.value = "brick"
    upload._pick._read(upload._pick.drawing)
    upload.show(bench.state)
    assert upload._make.disabled and "another file" in upload._make.hint
    upload._pick._look()
    assert not upload._pick.is_refused, "it is read anew, by another unit perhaps"
