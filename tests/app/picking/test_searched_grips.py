"""Parts whose library leaves it to a search are taken by grips that the search finds."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.core.cell.part_edits import edited_part
from workbench.app.filling.found_grips import make_found_commands
from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.proofs import ProofText
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import GraspLibrary
from workbench.model.scan import Detection
from workbench.proof.claims.prove import prove


def with_library(cell, library):
    return replace(cell, parts=tuple(replace(part, library=library) for part in cell.parts))


@pytest.fixture(scope="module")
def cell():
    return with_library(read_cell("yumi"), GraspLibrary(searches=True))


@pytest.fixture(scope="module")
def pile(cell):
    lying = (((0.0, -0.06, 0.019), 0.3), ((0.02, 0.06, 0.019), 2.0))
    return tuple(
        Detection(
            cell.parts[0].name,
            cell.bin.T_world_bin
            * pose_from_rpy(p, (0, np.pi / 2, 0))
            * pose_from_rpy((0, 0, 0), (turn, 0, 0)),
        )
        for p, turn in lying
    )


@pytest.fixture(scope="module")
def result(cell, pile):
    return plan_pick(cell, pile, "scan", seed=3)


def test_an_empty_library_that_permits_a_search_gives_a_proven_plan_for_two_arms(
    cell, pile, result
):
    plan = result.plan
    assert plan is not None and result.proof is not None and result.proof.holds
    assert len(plan.arms) == 2 and all(arm.found is not None for arm in plan.arms)
    assert [note.text for note in plan.notes].count(PlanNote.FOUND_GRIP) == 1
    assert plan.digest == plan_pick(cell, pile, "scan", seed=3).plan.digest
    working = {each.detection for each in judge(cell, pile, seed=3) if each.verdict.is_ok}
    assert working == {0, 1}


def test_found_grips_that_are_added_to_the_library_are_taken_by_the_next_plan(cell, pile, result):
    (command,) = make_found_commands(cell, result.plan)
    assert {entry.tool for entry in command.now} == {arm.tool.name for arm in cell.arms}
    part = edited_part(cell.parts[0], command)
    assert len(part.library.entries) == 2 and part.library.searches
    known = replace(cell, parts=(part, *cell.parts[1:]))
    again = plan_pick(known, pile, "scan", seed=3)
    assert again.proof is not None and again.proof.holds
    assert not any(arm.found for arm in again.plan.arms)
    assert make_found_commands(known, again.plan) == []


def test_without_the_permission_there_is_no_plan_and_the_proof_refuses_that_one(cell, pile, result):
    strict = with_library(cell, GraspLibrary())
    assert plan_pick(strict, pile, "scan", seed=3).plan is None
    plan = replace(result.plan, cell_digest=strict.digest)
    texts = {violation.problem.text for violation in prove(strict, plan.scene, plan).violations}
    assert ProofText.NO_GRASP in texts


def test_the_usual_grasps_come_first(pile):
    cell = read_cell("yumi")
    searching = with_library(cell, replace(cell.parts[0].library, searches=True))
    plans = [plan_pick(each, pile, "scan", seed=3).plan for each in (cell, searching)]
    taken = [[(arm.arm, arm.grasp, arm.found) for arm in plan.arms] for plan in plans]
    assert taken[0] == taken[1] and all(found is None for _, _, found in taken[0])


def test_a_part_within_another_is_left_and_the_reason_is_that_no_grip_fits(cell, pile):
    inside = replace(pile[0], T_world_part=pile[0].T_world_part * pose_from_rpy((0, 0, 0.004)))
    found = plan_pick(cell, (pile[0], inside), "scan", seed=3)
    assert found.plan is None and found.verdict.note.text is VerdictNote.NO_GRIP


def test_a_plan_with_found_grips_comes_back_from_its_file(result, tmp_path):
    write_plan(tmp_path / "plan.json", result.plan, result.proof)
    plan, stated = read_plan(tmp_path / "plan.json")
    assert plan.digest == stated == result.plan.digest
    assert plan.arms[0].found is not None


def with_grip(plan, number, *, by=0.0, moved=None):
    """The plan with one hand closed otherwise, and all its legs with it; or its grip moved."""
    arm = plan.arms[number]
    found = replace(arm.found, grip=arm.found.grip + by)
    if moved is not None:
        found = replace(found, T_part_tcp=found.T_part_tcp * moved)
    legs = tuple(replace(leg, opening=leg.opening + by) if leg.holding else leg for leg in arm.legs)
    arms = [*plan.arms]
    arms[number] = replace(arm, found=found, legs=legs)
    return replace(plan, arms=tuple(arms))


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("by", [-0.006, -0.004, 0.002, 0.006])
def test_a_found_grip_that_does_not_hold_is_refused(cell, result, number, by):
    bent = with_grip(result.plan, number, by=by)
    texts = {violation.problem.text for violation in prove(cell, bent.scene, bent).violations}
    assert ProofText.NOT_HELD in texts


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("axis", range(3))
@pytest.mark.parametrize("by", [-0.003, 0.003])
def test_a_found_grip_elsewhere_than_the_hand_is_refused(cell, result, number, axis, by):
    shift = pin.SE3(np.eye(3), by * np.eye(3)[axis])
    bent = with_grip(result.plan, number, moved=shift)
    texts = {violation.problem.text for violation in prove(cell, bent.scene, bent).violations}
    assert ProofText.NOT_IN_HAND in texts


def test_a_cup_is_put_where_no_library_says():
    cell = with_library(read_cell("tx2_90"), GraspLibrary(searches=True))
    T = cell.bin.T_world_bin * pose_from_rpy((0.05, 0.1, 0.007))
    result = plan_pick(cell, (Detection("puck", T),), "scan", seed=3)
    assert result.proof is not None and result.proof.holds
    assert result.plan.arms[0].found is not None


def test_without_a_plan_the_candidates_of_all_levels_are_shown(pile):
    cell = read_cell("yumi")
    usual = replace(cell.parts[0].library.grasps[0], name="usual", is_enabled=False)
    spare = replace(usual, name="spare", priority=-1)
    off = with_library(cell, GraspLibrary((usual, spare), searches=False))
    found = plan_pick(off, pile, "scan", seed=3)
    assert found.plan is None
    assert {each.grasp.name.partition("@")[0] for each in found.candidates} == {"usual", "spare"}
