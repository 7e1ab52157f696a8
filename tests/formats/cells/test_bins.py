"""Several bins of a cell file: read, one chosen, written, and every mistake named."""

import shutil
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.differences import difference
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.model.derived.by_bin import barriers, surfaces, with_bin
from workbench.model.derived.by_recipe import as_chosen
from workbench.model.errors import FileError, InputError
from workbench.model.geometry import pose_from_rpy

SHIPPED = find("robots", "yumi") / "two_bins.toml"

LEFT = '\n[[recipe]]\nnumber = 1\nname = "left"\nbin = "left"\n'


@pytest.fixture
def changed(tmp_path):
    """The shipped cell with other words."""

    def made(*pairs: tuple[str, str], more: str = ""):
        whole = SHIPPED.read_text(encoding="utf-8")
        for old, new in pairs:
            assert old in whole
            whole = whole.replace(old, new, 1)
        shutil.copytree(SHIPPED.parent, tmp_path / "yumi", dirs_exist_ok=True)
        path = tmp_path / "yumi" / "two_bins.toml"
        part = str(find("parts", "keyed_cylinder") / "full_bin")
        whole = whole.replace("../../parts/keyed_cylinder/full_bin", part)
        path.write_text(whole + more, encoding="utf-8")
        return path

    return made


def test_parts_are_taken_from_one_bin_and_the_others_stand_in_the_way():
    right = read_cell(SHIPPED)
    left = with_bin(right, "left")
    assert [box.name for box in right.bins] == [box.name for box in left.bins] == ["right", "left"]
    assert (right.bin.name, left.bin.name) == ("right", "left")
    assert [barriers(one)[-1].name for one in (right, left)] == ["bin left", "bin right"]
    assert right.digest != left.digest
    assert with_bin(left, "right").digest == right.digest == with_bin(right, "").digest
    assert str(difference(right, left)).startswith("parts are taken from bin left")


def test_a_recipe_names_its_bin(changed):
    cell = read_cell(changed(more=LEFT))
    assert as_chosen(cell, 1).bin.name == "left"
    assert as_chosen(cell, 1, "right").bin.name == "right"


def test_a_cell_with_one_bin_says_nothing_of_others():
    cell = read_cell("yumi")
    assert (cell.bin.name, cell.bin.number, cell.other_bins) == ("", 0, ())
    assert barriers(cell) == surfaces(cell) == cell.fixtures
    with pytest.raises(InputError, match="cell yumi has one bin only"):
        with_bin(cell, "left")


def test_several_bins_are_written_and_read_again(tmp_path):
    cell = read_cell(SHIPPED)
    write_cell(tmp_path, cell, {})
    again = tomllib.loads((tmp_path / "cell.toml").read_text(encoding="utf-8"))["bin"]
    assert [box["name"] for box in again] == ["right", "left"]
    for box, table in zip(cell.bins, again, strict=True):
        assert np.allclose(table["position_mm"], box.T_world_bin.translation * 1000)


@pytest.mark.parametrize(
    ("pairs", "more", "problem"),
    [
        ([('name = "left"\nposition_mm = [410', 'name = "right"\nposition_mm = [410')], "",
         r"bin.name.*'right' is there 2 times"),
        ([('name = "left"\nposition_mm = [410', "position_mm = [410")], "",
         r"bin\[2\].name.*each of several bins needs a name"),
        ([("[410, 80, -5]", "[410, 60, -5]")], "", "'right' and 'left' overlap"),
        ([("[410, 80, -5]", "[410, -80, -5]")], "", "'right' and 'left' overlap"),
        ([('name = "table"', 'name = "bin left"')], "", "'bin left' is there 2 times"),
        ([], LEFT.replace('bin = "left"', 'bin = "third"'),
         "recipe 1 left: bin third is not one of the cell's bins: right, left"),
    ],
)  # fmt: skip
def test_what_bins_cannot_be_is_refused_by_name(changed, pairs, more, problem):
    with pytest.raises(FileError, match=problem):
        read_cell(changed(*pairs, more=more))


def test_every_bin_is_moved_in_its_own_table_of_the_file(changed):
    path = changed()
    cell = with_bin(read_cell(path), "left")
    T = pose_from_rpy((0.41, 0.09, -0.005), (0, 0, 0.1))
    box = replace(cell.bin, T_world_bin=T, size=cell.bin.size * (1, 1, 1.1))
    save_cell(path, with_bin(replace(cell, bin=box), "right"))
    again = read_cell(path)
    assert again.bins[1].T_world_bin.isApprox(T, 1e-5)
    assert np.allclose(again.bins[1].size, box.size)
    assert again.bins[0].T_world_bin.isApprox(cell.bins[0].T_world_bin, 1e-9)
    assert "# Low enough for the palm" in path.read_text(encoding="utf-8")


def test_an_unknown_bin_is_refused_with_those_there_are():
    with pytest.raises(InputError, match="cell yumi_two_bins has no bin third; it has right, left"):
        with_bin(read_cell(SHIPPED), "third")
