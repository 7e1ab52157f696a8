"""All that a grasp stands for, grip after grip, and grasps put at an offset from others."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.core.cell.changes import ChangeCell, UndoCell
from workbench.app.core.people import Role
from workbench.gui.grasps.editing import Editing
from workbench.gui.grasps.offset import NONE, GraspOffset
from workbench.gui.grasps.panel import GraspsPanel
from workbench.gui.grasps.stepping import CopySteps, copies_of, judgement_of, way_to
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary, GraspPattern
from workbench.model.symmetry import Symmetry

PART = "keyed_cylinder"
HAND = Grasp("side", pose_from_rpy((0.0, -0.03, 0.02), (-np.pi / 2, 0, 0)), 0.04, 0.03)
Z = np.array([0.0, 0.0, 1.0])


@pytest.fixture
def put(bench, cell):
    """Puts grasps on the part, which may be given a symmetry."""

    def put(*entries, symmetry=None):
        part = replace(cell.part(PART), library=GraspLibrary(entries))
        if symmetry is not None:
            part = replace(part, symmetry=symmetry)
        changed = replace(bench.state.cell, parts=(part,))
        bench.do(ChangeCell(changed, "other grasps"), "Ada", Role.ENGINEER)
        return part

    return put


@pytest.fixture
def one_finger(cell):
    """A tool whose fingers cannot change places: each grip is there once."""
    tool = cell.arms[0].tool
    return replace(tool, fingers=tool.fingers[:1])


def ways(part, entry, tool):
    return [str(way_to(copy, entry, part)) for copy in copies_of(part, entry, tool)]


def test_copies_of_a_pattern_say_how_far_they_are_turned_and_moved(put, one_finger):
    angles = tuple(np.deg2rad((0.0, 60.0, 180.0, 300.0)).tolist())
    pattern = GraspPattern(HAND, Z, angles=angles, offsets=(0.0, 0.013))
    part = put(pattern)
    assert ways(part, pattern, one_finger) == [
        *("at its own pose", "turned 60.0 deg", "turned 180.0 deg", "turned 300.0 deg"),
        *("moved 13.0 mm", "turned 60.0 deg, moved 13.0 mm"),
        *("turned 180.0 deg, moved 13.0 mm", "turned 300.0 deg, moved 13.0 mm"),
    ]


def test_copies_of_a_symmetry_and_of_what_is_left_free_are_among_them(put, one_finger, cell):
    symmetric = put(HAND, symmetry=Symmetry(Z, 3))
    assert ways(symmetric, HAND, one_finger) == [
        "at its own pose", "turned 120.0 deg", "turned 240.0 deg",
    ]  # fmt: skip
    free = replace(HAND, free_rotation=np.deg2rad(30.0))
    part = put(free, symmetry=Symmetry(Z, 1))
    turns = ways(part, free, one_finger)
    assert sorted(turns) == ["at its own pose", "turned 30.0 deg", "turned 330.0 deg"]
    two = cell.arms[0].tool
    assert len(copies_of(part, free, two)) == 6 and "turned 180.0 deg" in ways(part, free, two)


def test_only_the_copies_of_the_entry_are_its_copies(put, one_finger):
    other = replace(HAND, name="side-2", T_part_tcp=pose_from_rpy((0, 0.03, 0), (np.pi / 2, 0, 0)))
    part = put(HAND, other)
    assert [copy.name for copy in copies_of(part, HAND, one_finger)] == ["side"]


def test_what_became_of_a_copy_in_the_bin_is_said(states, cell):
    part, planned = cell.part(PART), states.planned
    name = planned.candidates[0].grasp.name
    same = [one for one in planned.candidates if one.grasp.name == name]
    said = str(judgement_of(planned.candidates[0].grasp, part, planned))
    assert said.startswith("In the bin: ")
    assert sum(int(word.rstrip(",")) for word in said.split() if word[0].isdigit()) == len(same)
    assert judgement_of(planned.candidates[0].grasp, part, states.localized) is None
    assert judgement_of(planned.candidates[0].grasp, replace(part, name="other"), planned) is None


def test_steps_go_around_and_begin_anew_with_another_grasp(put, visitor, bench):
    pattern = GraspPattern(HAND, Z, angles=(0.0, 1.0, 2.0))
    other = replace(HAND, name="other")
    part = put(pattern, other)
    editing, stepped = Editing(visitor), []
    steps = CopySteps(visitor, editing, lambda: stepped.append(1), lambda: True)
    assert steps.show(bench.state, part, pattern) is None
    count = len(copies_of(part, pattern, editing.tool))
    assert count == 6 and steps._forth.visible
    seen = []
    for step in (1, 1, -1, -1, 1):
        steps._go(step)
        steps.show(bench.state, part, pattern)
        seen.append(int(steps._line.content.split("Copy ")[1].split(" of 6")[0]))
    assert seen == [1, 2, 1, 6, 1] and len(stepped) == 5
    assert steps.show(bench.state, part, other) is None and steps._line.content == ""


def test_the_hand_is_shown_at_the_copy_until_the_grasp_is_moved(put, visitor, monkeypatch):
    put(GraspPattern(HAND, Z, angles=(0.0, np.pi)))
    panel = GraspsPanel(visitor)
    shown = []
    monkeypatch.setattr(panel, "_preview", shown.append)
    monkeypatch.setattr(panel, "_turn", panel._draw)
    panel._draw()
    panel._steps._go(1)
    panel._steps._go(1)
    assert {grasp.name for grasp in shown} == {"side-1-1"}
    entry = panel._editing.entry
    panel._editing.move(entry, pose_from_rpy((0, -0.03, 0), (-np.pi / 2, 0, 0)), "moved")
    panel._draw()
    before = len(shown)
    panel._draw()
    assert len(shown) == before and panel._steps._line.content == ""


def test_a_grasp_is_put_at_an_offset_in_the_frame_of_another_one_and_undone(put, visitor, bench):
    reference = replace(
        HAND, name="reference", T_part_tcp=pose_from_rpy((0.01, 0.02, 0), (0, 0, 1))
    )
    part = put(HAND, reference)
    offset = GraspOffset(visitor, Editing(visitor))
    offset.show(part, HAND, problem="")
    assert offset._from.options == ("reference",)
    shift = np.array(offset._shift.value) / 1000
    there = reference.T_part_tcp.act(shift)
    assert there == pytest.approx(HAND.T_part_tcp.translation, abs=1e-5)
    offset._shift.value, offset._turn.value = (10.0, 0.0, -5.0), (0.0, 0.0, 90.0)
    offset._take()
    now = bench.state.cell.part(PART).library.entries[0]
    wanted = reference.T_part_tcp * pose_from_rpy((0.01, 0.0, -0.005), (0, 0, np.pi / 2))
    assert now.name == "side" and now.T_part_tcp.isApprox(wanted, 1e-6)
    assert visitor.client.told == []
    bench.do(UndoCell(), "Ada", Role.ENGINEER)
    undone = bench.state.cell.part(PART).library.entries[0]
    assert undone.T_part_tcp.isApprox(HAND.T_part_tcp, 1e-9)


def test_without_another_grasp_there_is_no_offset(put, visitor):
    offset = GraspOffset(visitor, Editing(visitor))
    offset.show(put(HAND), HAND, problem="")
    assert offset._from.options == (NONE,) and offset._put.disabled
    offset._take()
    assert visitor.client.told == []
