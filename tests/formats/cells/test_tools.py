"""Several tools for an arm, and grasps that are for one of them."""

import shutil

import pytest

from workbench.app.picking.judging import judge
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.model.errors import FileError
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.scan import Detection
from workbench.model.tools.slots import with_mounted

SECOND = """
[[tool]]
name = "cup"
[tool.tcp]
position_mm = [0, 0, 120]
[[tool.body]]
name = "tube"
shape = "cylinder"
radius_mm = 10
length_mm = 118
position_mm = [0, 0, 59]

[[arm]]
name = "right"
tools = ["smart_gripper", "cup"]
"""


def test_a_tool_has_a_body_or_fingers(path):
    text = path.read_text()
    begin, end = text.index('[[tool.body]]\nname = "tube"'), text.index('[[arm]]\nname = "right"')
    path.write_text(text[:begin] + text[end:])
    with pytest.raises(FileError, match=r"body: is missing; \[\[tool.body\]\] or \[\[tool.finger"):
        read_cell(path)


@pytest.fixture
def path(tmp_path):
    shutil.copytree(find("robots", "yumi"), tmp_path / "yumi")
    shutil.copytree(find("parts", "keyed_cylinder"), tmp_path / "yumi" / "keyed_cylinder")
    path = tmp_path / "yumi" / "cell.toml"
    text = path.read_text()
    path.write_text(text.replace('[[arm]]\nname = "right"\n', SECOND, 1))
    grasps = tmp_path / "yumi" / "keyed_cylinder" / "grasps.toml"
    grasps.write_text(
        grasps.read_text().replace("opening_mm = 40", 'tool = "cup"\nopening_mm = 40')
    )
    return path


def test_no_solid_is_called_as_what_a_hand_drops_back(path):
    path.write_text(path.read_text().replace('name = "tube"', 'name = "held_body_2"'))
    with pytest.raises(FileError, match="no solid may be called held_body"):
        read_cell(path)


def test_an_arm_knows_all_its_tools_and_the_one_it_carries(path):
    right, left = read_cell(path).arms
    assert [tool.name for tool in right.tools] == ["smart_gripper", "cup"]
    assert right.tool.name == "smart_gripper"
    assert [tool.name for tool in left.tools] == ["smart_gripper"]


def test_a_grasp_for_another_tool_is_refused_with_the_reason(path):
    cell = read_cell(path)
    T = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.02), (0, 1.5708, 0))
    notes = {(one.arm, one.verdict.note) for one in judge(cell, (Detection("keyed_cylinder", T),))}
    assert ("right", VerdictNote.CHANGE_TOOL(tool="cup", carried="smart_gripper")) in notes
    assert ("left", VerdictNote.OTHER_TOOL(tool="cup", carried="smart_gripper")) in notes
    mounted = with_mounted(cell, "right", "cup")
    found = judge(mounted, (Detection("keyed_cylinder", T),))
    assert not any("needs tool cup" in str(one.verdict.note) for one in found if one.arm == "right")


def test_a_changed_tool_is_saved(path):
    cell = read_cell(path)
    save_cell(path, with_mounted(cell, "right", "cup"))
    assert read_cell(path).arms[0].tool.name == "cup"
    assert read_cell(path).digest == with_mounted(cell, "right", "cup").digest


@pytest.mark.parametrize(
    ("old", "new", "expected"),
    [
        ('"smart_gripper", "cup"]', '"smart_gripper", "claw"]', "'claw' is not one of"),
        ('"smart_gripper", "cup"]', '"cup"]', "which the arm carries"),
        ('"smart_gripper", "cup"]', '"smart_gripper", "smart_gripper"]', "each once"),
    ],
)
def test_a_wrong_list_says_which(path, old, new, expected):
    path.write_text(path.read_text().replace(old, new))
    with pytest.raises(FileError, match=expected):
        read_cell(path)


def test_the_force_of_a_tool_is_read_written_and_changes_the_digest_only_where_it_is_stated(
    tmp_path,
):
    shutil.copytree(find("robots", "yumi"), tmp_path / "yumi")
    path = tmp_path / "yumi" / "cell.toml"
    plain, text = read_cell(path), path.read_text()
    assert plain.arms[0].tool.force is None
    stated = text.replace("stroke_mm = [0, 50]\n", "stroke_mm = [0, 50]\nforce_n = 20\n", 1)
    path.write_text(stated)
    cell = read_cell(path)
    assert cell.arms[0].tool.force == 20.0 and cell.digest != plain.digest
    written = write_cell(tmp_path / "again", cell, {}).read_text()
    assert written.count("force_n = 20") == 1
    path.write_text(stated.replace("force_n = 20", "force_n = -1"))
    with pytest.raises(FileError, match="force_n"):
        read_cell(path)
