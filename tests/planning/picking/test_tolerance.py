"""A part that may be larger than its mesh is taken by a hand that arrives farther open."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.core.state import State
from workbench.app.filling.found_grips import make_found_commands
from workbench.app.picking.fixing import make_fix_command
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.formats.parts.reading import read_part
from workbench.model.candidate import Candidate, Reason, Stage, Verdict
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.grasps import FixText
from workbench.model.messages.proofs import ProofText
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import GraspLibrary, widen_grasp
from workbench.model.part_edits import grasp_of
from workbench.model.scan import Detection
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.grasp_suggestions import suggest
from workbench.planning.picking.nearest_fix import Fix

PART = "keyed_cylinder"


@pytest.fixture
def cell_with(tmp_path):
    """Makes the cell whose part states a tolerance [mm]."""

    def make(tolerance, **library):
        text = (find("parts", PART) / "part.toml").read_text()
        for file in find("parts", PART).iterdir():
            if file.is_file():
                (tmp_path / file.name).write_bytes(file.read_bytes())
        stated = f"[mesh]\ntolerance_mm = {tolerance}\n"
        (tmp_path / "part.toml").write_text(text.replace("[mesh]\n", stated))
        part = read_part(tmp_path)
        if library:
            part = replace(part, library=GraspLibrary(**library))
        return replace(read_cell("yumi"), parts=(part,))

    return make


def lying(cell):
    """One part that lies free in the bin."""
    floor = cell.bin.T_world_bin.translation
    T = pose_from_rpy(floor + [0.0, 0.0, 0.0235], (np.pi / 2, 0.0, 0.0))
    return (Detection(PART, T),)


def planned(cell):
    return plan_pick(cell, lying(cell), "scan", seed=0)


def test_a_part_without_a_tolerance_is_taken_as_its_grasps_state(cell_with):
    usual = read_cell("yumi").parts[0]
    assert all(widen_grasp(grasp, 0.0) is grasp for grasp in usual.grasps)
    cell = cell_with(0)
    openings = [[grasp.opening for grasp in part.grasps] for part in (usual, cell.parts[0])]
    assert openings[0] == openings[1]


@pytest.mark.parametrize("tolerance", [1.0, 4.0])
def test_fingers_arrive_open_for_the_largest_part_and_the_plan_is_proven(cell_with, tolerance):
    cell = cell_with(tolerance)
    part, authored = cell.parts[0], read_cell("yumi").parts[0].grasps[0]
    result = planned(cell)
    assert result.plan is not None and result.proof is not None and result.proof.holds
    (arm_plan,) = result.plan.arms
    taken = next(grasp for grasp in part.grasps if grasp.name == arm_plan.grasp)
    for name in ("reach", "approach"):
        assert arm_plan.leg(name).opening == pytest.approx(taken.opening)
    assert taken.opening == pytest.approx(authored.opening + 2 * tolerance / 1000)
    assert arm_plan.leg("extract").opening == pytest.approx(taken.grip)


def test_a_plan_whose_fingers_arrive_as_for_the_mesh_is_not_proven(cell_with):
    cell = cell_with(2.0)
    plan = planned(cell).plan
    (arm_plan,) = plan.arms
    narrow = tuple(
        replace(leg, opening=0.034) if leg.name in ("reach", "approach") else leg
        for leg in arm_plan.legs
    )
    altered = replace(plan, arms=(replace(arm_plan, legs=narrow),))
    proof = prove(cell, altered)
    assert any(violation.problem.mentions(ProofText.OPENING) for violation in proof.violations)


def test_a_hand_that_cannot_open_so_far_is_refused_with_the_figures(cell_with):
    cell = cell_with(6.0)
    candidates = planned(cell).candidates
    refusals = [one.verdict for one in candidates if not one.grasp.is_found]
    # A search finds grips for which the hand is wide enough.
    assert all(one.grasp.opening <= 0.05 for one in candidates if one.grasp.is_found)
    assert {refusal.reason for refusal in refusals} == {Reason.OUT_OF_STROKE}
    assert all(refusal.note.mentions(VerdictNote.STROKE_AND_TOLERANCE) for refusal in refusals)
    assert str(refusals[0].note) == (
        "opening 52 mm, stroke 0 mm to 50 mm; 12.0 mm of the opening for the part's tolerance"
    )


def test_a_grasp_is_checked_as_open_as_planning_has_it(cell_with):
    tool = read_cell("yumi").arms[0].tool
    part = cell_with(3.0).parts[0]
    grasp = part.library.grasps[0]
    check = GraspChecker(part, tool).check(grasp)
    assert check.is_ok and check.clearance == pytest.approx(
        GraspChecker(read_cell("yumi").parts[0], tool).check(grasp).clearance, abs=2e-4
    )
    wide = GraspChecker(cell_with(6.0).parts[0], tool).check(grasp)
    assert "opening 52.0 mm is outside of the stroke" in " ".join(
        str(finding.text) for finding in wide.findings
    )


def test_suggestions_state_the_opening_for_the_mesh_and_leave_room_for_the_rest(cell_with):
    cell = cell_with(4.0)
    part, tool = cell.parts[0], cell.arms[0].tool
    found = suggest(replace(part, library=GraspLibrary()), tool, most=3)
    assert found
    assert all(one.grasp.opening + 0.008 <= tool.stroke[1] + 1e-9 for one in found)


def test_a_grip_that_a_plan_finds_is_as_open_and_goes_without_that_into_the_library(cell_with):
    cell = cell_with(2.0, searches=True)
    result = planned(cell)
    assert result.proof is not None and result.proof.holds
    (arm_plan,) = result.plan.arms
    found = arm_plan.found
    assert arm_plan.leg("approach").opening == pytest.approx(found.opening)
    assert found.opening - found.grip >= 0.004
    (command,) = make_found_commands(cell, result.plan)
    assert command.now[0].opening == pytest.approx(found.opening - 0.004)


def test_a_fix_of_the_opening_changes_the_grasp_as_it_is_authored(cell_with):
    cell = cell_with(2.0)
    detections, grasp = lying(cell), cell.parts[0].grasps[0]
    refused = Verdict(Reason.IN_COLLISION, Stage.GRASP)
    candidate = Candidate(0, grasp, "left", pose_from_rpy((0.0, 0.0, 0.0)), 0.0, refused)
    state = State(cell, detections=detections, candidates=(candidate,))
    wider = replace(grasp, opening=grasp.opening + 0.003)
    command = make_fix_command(state, Fix(candidate, FixText.OPENING(opening=0.047), wider))
    (was,), (now,) = command.was, command.now
    assert grasp_of(now).opening == pytest.approx(grasp_of(was).opening + 0.003)
