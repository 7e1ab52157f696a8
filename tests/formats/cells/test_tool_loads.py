"""What the file of a cell says of the mass of its tools."""

import re
import shutil

import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.tools import read_tool
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.formats.files.toml_keys import read_toml
from workbench.model.errors import FileError

LOADED = """mass_g = 230
centre_of_gravity_mm = [8.2, 11.7, 52]
inertia_kgm2 = [0.00021, 0.00024, 0.00009, 0.00001, 0, 0]
"""


def with_load(text, lines):
    plain, stroke = (
        re.sub(r"(?m)^(mass_g|centre_of_gravity_mm|inertia_kgm2) = .*\n", "", text),
        "stroke_mm = [0, 50]\n",
    )
    assert stroke in plain
    return plain.replace(stroke, stroke + lines, 1)


def copy_of_yumi(tmp_path):
    shutil.copytree(find("robots", "yumi"), tmp_path / "yumi")
    return tmp_path / "yumi" / "cell.toml"


def test_a_tool_states_its_load_and_keeps_it_when_it_is_written(tmp_path):
    cell_file = copy_of_yumi(tmp_path)
    cell_file.write_text(with_load(cell_file.read_text(), LOADED))
    cell = read_cell(cell_file)
    tool = cell.arms[0].tool
    assert tool.mass == pytest.approx(0.23)
    assert tool.centre_of_gravity == pytest.approx([0.0082, 0.0117, 0.052])
    assert tool.inertia[0].tolist() == [0.00021, 0.00001, 0.0]
    assert tool.inertia[1, 0] == 0.00001
    written = write_cell(tmp_path / "again", cell, {}).read_text()
    assert "mass_g = 230" in written
    assert "centre_of_gravity_mm = [8.2, 11.7, 52]" in written
    assert "inertia_kgm2 = [0.00021, 0.00024, 9e-05, 1e-05, 0, 0]" in written
    cell_file.write_text(with_load(cell_file.read_text(), ""))
    assert read_cell(cell_file).digest != cell.digest


@pytest.mark.parametrize(
    ("lines", "why"),
    [
        ("mass_g = 0\n", "mass_g.*more than 0"),
        ("mass_g = -1\n", "mass_g.*not between"),
        ("mass_g = nan\n", "mass_g.*finite"),
        ("centre_of_gravity_mm = [0, 0, 50]\n", "mass_g.*missing; centre_of_gravity_mm"),
        (
            "mass_g = 230\ncentre_of_gravity_mm = [0, 0, 400]\n",
            "centre_of_gravity_mm.*outside of the tool",
        ),
        ("mass_g = 230\ncentre_of_gravity_mm = [0, 0]\n", "3 numbers"),
        ("mass_g = 230\ninertia_kgm2 = [0.21, 0.24, 0.09]\n", "inertia_kgm2.*another unit"),
        ("mass_g = 230\ninertia_kgm2 = [1e-4, 1e-4, 3e-4]\n", "inertia_kgm2.*sum of the others"),
        ("mass_g = 230\ninertia_kgm2 = [1e-4, -1e-4, 1e-4]\n", "inertia_kgm2.*no body"),
    ],
)
def test_a_load_that_cannot_be_is_refused_by_its_key(tmp_path, lines, why):
    cell_file = copy_of_yumi(tmp_path)
    cell_file.write_text(with_load(cell_file.read_text(), lines))
    with pytest.raises(FileError, match=why):
        read_cell(cell_file)


def test_a_tool_of_a_kind_states_its_load_too(tmp_path):
    text = '[[tool]]\nname = "cup"\nkind = "suction-cup"\nmass_g = 500\n'
    (tmp_path / "tool.toml").write_text(text)
    tool = read_tool(next(iter(read_toml(tmp_path / "tool.toml").tables("tool"))))
    assert (tool.mass, tool.centre_of_gravity) == (0.5, None)
