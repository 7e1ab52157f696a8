"""Tools with several TCPs in cell files, and grasps that are for one of them."""

import shutil

import numpy as np
import pytest

from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.formats.parts.grasp_files import add_grasps
from workbench.formats.parts.reading import read_grasps
from workbench.gui.shared.movable_frames import move_frame, pose_of, things
from workbench.model.digest import digest_of
from workbench.model.errors import FileError


@pytest.fixture
def path(tmp_path):
    shutil.copytree(find("robots", "tx2_90"), tmp_path / "robots" / "tx2_90")
    shutil.copytree(find("parts", "puck"), tmp_path / "parts" / "puck")
    return tmp_path / "robots" / "tx2_90" / "two_cups.toml"


def edit(path, *pairs):
    text = path.read_text()
    for old, new in pairs:
        assert old in text
        text = text.replace(old, new, 1)
    path.write_text(text)


def test_a_tool_has_the_tcps_of_its_file(path):
    (arm,) = read_cell(path).arms
    assert [tcp.name for tcp in arm.tool.tcps] == ["straight", "angled"]
    assert arm.tool.tcp == "straight"
    assert [tcp.touches for tcp in arm.tool.tcps] == [("cup",), ("angled_cup",)]
    assert [tcp.output for tcp in arm.tool.tcps] == [None, None]


@pytest.mark.parametrize(
    ("old", "new", "problem"),
    [
        ('"angled"', '"straight"', "tcp.name: 'straight' is there 2 times"),
        ('name = "angled"\n', "", r"tcp\[2\].name: is missing; each of several TCPs needs a name"),
        ('["angled_cup"]', '["lip"]', "'angled' touches 'lip', the tool has mount, tube, cup,"),
        ("[52, 0, 280]", "[520, 0, 280]", "'angled' lies more than 100 mm outside of the tool"),
        ('["angled_cup"]', '["angled_cup"]\noutput = 8', "tcp.*output.*7"),
        ('["angled_cup"]', '["angled_cup"]\noutput = 3', "link abb-socket cannot switch the outp"),
        ('touches = ["angled_cup"]', 'touch = ["cup"]', "touch: is not known here; did you mean"),
    ],
)
def test_bad_tcps_are_refused_in_one_sentence(path, old, new, problem):
    edit(path, (old, new))
    with pytest.raises(FileError, match=problem):
        read_cell(path)


def test_several_tcps_are_for_tools_without_fingers(path):
    finger = '\n[[tool.finger]]\nname = "f"\nshape = "box"\nsize_mm = [1, 1, 1]\n'
    edit(path, ("[[arm]]", f"{finger}opens_along = [0, 1, 0]\n\n[[arm]]"))
    edit(path, ("press_mm = 3", "stroke_mm = [0, 10]\npress_mm = 3"))
    with pytest.raises(FileError, match="several TCPs are for tools without fingers"):
        read_cell(path)


def test_one_tcp_may_have_a_name(path):
    text = path.with_name("cell.toml").read_text()
    path.write_text(text.replace("[tool.tcp]", '[tool.tcp]\nname = "lip"', 1))
    edit(path.parents[2] / "parts/puck/grasps.toml", ('name = "top"', 'name = "top"\ntcp = "lip"'))
    cell = read_cell(path)
    edit(path, ('parts = ["puck"]', 'parts = ["../../parts/puck"]'))
    assert read_cell(path).part("puck").grasps[0].tcp == "lip"
    assert cell.arms[0].tool.tcp == "lip"
    edit(path, ('name = "lip"', 'touches = ["cup"]'))
    with pytest.raises(
        FileError, match="name: is missing; each of several TCPs needs a name, and one with"
    ):
        read_cell(path)


def test_a_grasp_for_a_tcp_that_no_tool_has_is_refused(path):
    grasps = path.parents[2] / "parts" / "puck" / "full_bin" / "grasps.toml"
    edit(grasps, ('name = "top"', 'name = "top"\ntcp = "angled"'))
    assert {grasp.tcp for grasp in read_cell(path).part("puck").grasps} == {"", "angled"}
    edit(grasps, ('tcp = "angled"', 'tcp = "side"'))
    with pytest.raises(
        FileError, match="grasp 'top' of puck is for TCP 'side'; tools have straight, angled"
    ):
        read_cell(path)
    with pytest.raises(FileError, match="is for TCP 'side'; no tool names its TCP"):
        read_cell(path.with_name("full_bin.toml"))


def test_a_grasp_with_a_tcp_is_written_as_it_is_read(path):
    grasps = path.parents[2] / "parts" / "puck" / "full_bin" / "grasps.toml"
    edit(grasps, ('name = "top"', 'name = "top"\ntcp = "angled"'))
    new = grasps.with_name("copy.toml")
    add_grasps(new, read_grasps(grasps).grasps[:1])
    assert read_grasps(new).grasps[0].tcp == "angled"


def test_a_written_cell_has_the_same_tools(path, tmp_path):
    cell = read_cell(path)
    write_cell(tmp_path / "written", cell, {})
    again = read_cell(tmp_path / "written" / "cell.toml")
    assert digest_of(again.arms[0].tool) == digest_of(cell.arms[0].tool)


def test_the_first_tcp_moves_on_the_page_and_in_the_file(path):
    cell = read_cell(path)
    (thing,) = [thing for thing in things(cell) if "two_cups" in thing]
    T = pose_of(cell, thing)
    T.translation = T.translation + np.array([0.0, 0.0, 0.01])
    moved = move_frame(cell, thing, T)
    save_cell(path, moved)
    tool = read_cell(path).arms[0].tool
    assert np.linalg.norm(tool.T_flange_tcp.translation - [0, 0, 0.3]) == pytest.approx(0.01)
    assert tool.tcps[0].T_flange_tcp.isApprox(tool.T_flange_tcp)
    np.testing.assert_allclose(tool.tcps[1].T_flange_tcp.translation, [0.052, 0, 0.28], atol=1e-9)
