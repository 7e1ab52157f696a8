"""Slots of tools in a cell file: read, written, standing in the way, and every mistake named."""

import shutil
from dataclasses import replace

import numpy as np
import pytest

from workbench.formats.cells.differences import difference
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.cells.writer import write_cell
from workbench.formats.files.shipped import find
from workbench.model.candidate import Reason
from workbench.model.derived.by_bin import barriers, surfaces
from workbench.model.errors import FileError, InputError
from workbench.model.robot import ToolSlot
from workbench.model.scan import Detection
from workbench.model.tools.slots import (
    change_problem,
    standing_tools,
    tool_of_arm,
    with_mounted,
)
from workbench.planning.collision.world import World
from workbench.planning.picking.propose import propose

SHIPPED = find("robots", "tx2_90") / "tool_changer.toml"


@pytest.fixture
def changed(tmp_path):
    """The shipped cell with other words."""

    def made(*pairs: tuple[str, str]):
        whole = SHIPPED.read_text(encoding="utf-8")
        for old, new in pairs:
            assert old in whole
            whole = whole.replace(old, new, 1)
        shutil.copytree(SHIPPED.parent, tmp_path / "tx2_90", dirs_exist_ok=True)
        path = tmp_path / "tx2_90" / "tool_changer.toml"
        path.write_text(whole, encoding="utf-8")
        return path

    return made


def test_a_tool_that_the_arm_does_not_carry_stands_in_its_slot():
    cell = read_cell(SHIPPED)
    (arm,) = cell.arms
    first, second = arm.tool_slots
    assert (first.tool, first.fixture, first.distance) == ("suction_cup", "rack", 0.1)
    np.testing.assert_allclose(first.leave, [0, -1, 0])
    (stands,) = standing_tools(cell)
    assert stands.name == "right slot wide_cup"
    for around in (barriers, surfaces):
        assert stands.name in [fixture.name for fixture in around(cell)]
    assert stands.T_world_fixture.isApprox(second.T_world_flange)
    labels = [solid.name for solid in stands.solids]
    assert labels[0] == "wide_cup mount in its slot" and len(labels) == len(arm.tools[1].body)
    (other,) = standing_tools(with_mounted(cell, "right", "wide_cup"))
    assert other.name == "right slot suction_cup"
    assert len(standing_tools(with_mounted(cell, "right", ""))) == 2
    assert not standing_tools(read_cell("tx2_90"))


def test_it_is_in_the_way_of_every_plan():
    cell = read_cell(SHIPPED)
    (arm,) = cell.arms
    there = World(cell, ()).chains["right"]
    slot = arm.tool_slots[1]
    q, residuals = there.solve(slot.T_world_flange * arm.tool.T_flange_tcp, arm.home[None])
    assert np.abs(residuals).max() < 1e-3
    met = World(cell, ()).contacts(World(cell, ()).configuration({"right": q[0]}))
    assert any("wide_cup mount in its slot" in contact.pair for contact in met)


def test_fingers_stand_there_at_every_opening():
    cell = read_cell("yumi")
    arm = cell.arms[0]
    slot = ToolSlot(arm.tool.name, cell.bin.T_world_bin, np.array([0.0, 0.0, 1.0]), 0.1)
    slotted = replace(cell, arms=(replace(arm, tool_slots=(slot,)), *cell.arms[1:]))
    (stands,) = standing_tools(with_mounted(slotted, arm.name, ""))
    finger = arm.tool.fingers[0]
    shifts = [
        (solid.T_owner_shape.translation - finger.solid.T_owner_shape.translation)
        @ finger.direction
        for solid in stands.solids
        if solid.shape is finger.solid.shape and finger.solid.name in solid.name
    ]
    assert min(shifts) == pytest.approx(arm.tool.stroke[0] / 2)
    assert max(shifts) == pytest.approx(arm.tool.stroke[1] / 2)
    assert np.diff(sorted(shifts)).max() <= 0.005 + 1e-9


def test_without_more_words_the_flange_leaves_straight_back(changed):
    cell = read_cell(
        changed(("leave = [0, -1, 0]\nleave_mm = 100\nfixture = ", "# "), ('"rack"', "rack"))
    )
    slot = cell.arms[0].tool_slots[0]
    np.testing.assert_allclose(slot.leave, [0, 0, 1], atol=1e-12)
    assert (slot.distance, slot.fixture) == (0.1, "")
    assert slot.T_world_outside.isApprox(slot.T_world_before)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('[[arm.tool_slot]]\ntool = "suction_cup"', '[[arm.tool_slot]]\ntool = "spoon"',
         "'spoon' is not one of suction_cup, wide_cup, which the arm can carry"),
        ('tools = ["suction_cup", "wide_cup"]', 'tools = ["suction_cup"]',
         "'wide_cup' is not one of suction_cup, which the arm can carry"),
        ('[[arm.tool_slot]]\ntool = "wide_cup"', '[[arm.tool_slot]]\ntool = "suction_cup"',
         "suction_cup"),
        ("leave = [0, -1, 0]", "leave = [0, 0, 0]", "has no length"),
        ("leave_mm = 100", "leave_mm = 0", "leave_mm"),
        ('fixture = "rack"', 'fixture = "shelf"', "'shelf' is not one of floor, tray, rack"),
        ('name = "rack"', 'name = "right slot wide_cup"', "right slot wide_cup"),
    ],
)  # fmt: skip
def test_each_mistake_is_named(changed, old, new, said):
    with pytest.raises(FileError, match=said):
        read_cell(changed((old, new)))


def test_a_change_without_slot_tool_or_link_is_refused_in_a_sentence():
    cell = read_cell(SHIPPED)
    (arm,) = cell.arms
    assert change_problem(cell, "right", "wide_cup") is None
    assert "carries suction_cup already" in str(change_problem(cell, "right", "suction_cup"))
    half = replace(cell, arms=(replace(arm, tool_slots=arm.tool_slots[1:]),))
    assert "suction_cup of the right arm has no slot" in str(
        change_problem(half, "right", "wide_cup")
    )
    motion = replace(cell.controller.motion, takes_tools=False)
    other = replace(cell, controller=replace(cell.controller, motion=motion))
    assert "couples no tools" in str(change_problem(other, "right", "wide_cup"))
    with pytest.raises(InputError, match="it can carry suction_cup, wide_cup"):
        tool_of_arm(arm, "spoon")


def test_a_cell_with_slots_comes_back_and_its_mounted_tool_is_saved(tmp_path, changed):
    cell = read_cell(SHIPPED)
    again = read_cell(write_cell(tmp_path / "written", replace(cell, parts=cell.parts), {}))
    for one, other in zip(cell.arms[0].tool_slots, again.arms[0].tool_slots, strict=True):
        assert one.T_world_flange.isApprox(other.T_world_flange, 1e-6)
        assert (one.tool, one.fixture, one.distance) == (other.tool, other.fixture, other.distance)
        np.testing.assert_allclose(one.leave, other.leave, atol=1e-9)
    path = changed()
    save_cell(path, with_mounted(read_cell(path), "right", "wide_cup"))
    assert read_cell(path).arms[0].tool.name == "wide_cup"
    assert 'tool = "wide_cup"             # on the flange' in path.read_text(encoding="utf-8")


def test_moved_slots_are_a_difference():
    cell = read_cell(SHIPPED)
    (arm,) = cell.arms
    slots = (replace(arm.tool_slots[0], distance=0.2), arm.tool_slots[1])
    other = replace(cell, arms=(replace(arm, tool_slots=slots),))
    assert "other slots of tools" in str(difference(cell, other))


def test_a_grasp_for_a_tool_in_its_slot_says_so():
    cell = read_cell(SHIPPED)
    part = cell.parts[0]
    grasps = tuple(replace(grasp, tool="wide_cup") for grasp in part.library.entries)
    wide = replace(part, library=replace(part.library, entries=grasps))
    found = Detection(part.name, cell.bin.T_world_bin)
    candidates = propose(World(replace(cell, parts=(wide,)), (found,)))
    assert {candidate.verdict.reason for candidate in candidates} == {Reason.ARM_NOT_ALLOWED}
    note = str(candidates[0].verdict.note)
    assert note == "needs tool wide_cup, which stands in its slot; the arm carries suction_cup"
