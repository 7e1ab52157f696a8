"""Whole piles, taken out of the bin."""

from dataclasses import replace

import pytest

from workbench.app.emptying import empty
from workbench.app.emptying.film import Shot
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import InputError
from workbench.model.part import GraspLibrary, Part
from workbench.model.prediction import PileTask
from workbench.studies.cases import run_cases
from workbench.studies.emptying import piles
from workbench.studies.emptying.piles import check_task, empty_pile

PILE = PileTask("yumi", "", 4, 13)


def without_times(scene):
    return replace(scene, planning=(), stages=(), finding=0.0)


@pytest.fixture(scope="module")
def scene():
    return empty_pile(PILE)


def test_every_part_is_taken_or_told_why_not(scene):
    gone = scene.taken + sum(scene.failed) + scene.knocked_out
    assert gone + len(scene.left) == scene.parts == 4
    assert scene.taken > 0
    assert scene.touches == 0 and sum(scene.failed) == 0
    assert all(left.reason and left.kind for left in scene.left)


def test_the_same_seed_empties_the_same_wherever_it_runs(scene):
    again = run_cases(empty_pile, [PILE, replace(PILE, seed=14)], workers=2)
    assert without_times(again[0]) == without_times(scene)


def test_parts_found_in_scans_are_taken_too():
    scene = empty_pile(replace(PILE, count=2, seen="scan"))
    assert scene.taken + sum(scene.failed) + scene.knocked_out + len(scene.left) == 2
    assert scene.finding > 0


def test_nothing_is_dropped_where_there_is_no_part(monkeypatch):
    monkeypatch.setattr(piles, "read_cell", lambda name: replace(read_cell("yumi"), parts=()))
    with pytest.raises(InputError, match="has no part, so there is nothing to drop"):
        check_task(PILE)


def test_more_parts_than_fit_are_refused():
    with pytest.raises(InputError, match=r"do not fit into the bin; take \d+ or fewer"):
        check_task(replace(PILE, count=500))


def test_a_part_larger_than_the_bin_is_refused(monkeypatch):
    cell = read_cell("yumi")
    small = replace(cell, bin=replace(cell.bin, size=cell.bin.size * 0.1))
    monkeypatch.setattr(piles, "read_cell", lambda name: small)
    with pytest.raises(InputError, match=r"part keyed_cylinder of .* mm is too large for the bin"):
        check_task(PILE)


def with_grasps(part: Part, grasps) -> Part:
    return replace(part, library=GraspLibrary(tuple(grasps)))


def test_a_part_without_grasps_is_refused(monkeypatch):
    cell = read_cell("yumi")
    bare = replace(cell, parts=(with_grasps(cell.parts[0], ()),))
    monkeypatch.setattr(piles, "read_cell", lambda name: bare)
    with pytest.raises(InputError, match="part keyed_cylinder has no grasp"):
        check_task(PILE)


def test_a_tool_that_fits_no_grasp_is_refused_with_the_reason(monkeypatch):
    cell = read_cell("yumi")
    wide = [replace(grasp, opening=0.08) for grasp in cell.parts[0].grasps]
    big = replace(cell, parts=(with_grasps(cell.parts[0], wide),))
    monkeypatch.setattr(piles, "read_cell", lambda name: big)
    with pytest.raises(InputError, match=r"an opening of 80\.0 mm, tool smart_gripper opens 0"):
        check_task(PILE)


def test_parts_that_the_cell_does_not_pick_can_be_piled_up():
    cell = piles.cell_of("yumi", "bracket+bolt")
    assert [part.name for part in cell.parts] == ["bracket", "bolt"]


def test_a_pile_that_failed_picks_have_ended_says_so(monkeypatch):
    def missed(cell, task, plan, lying, tally):
        return Shot(plan, tuple(lying), ()), [arm.detection for arm in plan.arms]

    monkeypatch.setattr(empty, "carry_out_plan", missed)
    monkeypatch.setattr(empty, "left_alone", lambda detections, failed: {})
    scene = empty_pile(PILE)
    assert {left.kind for left in scene.left} >= {"stopped"}
    assert not {left.kind for left in scene.left} & {"not found", "no path"}
