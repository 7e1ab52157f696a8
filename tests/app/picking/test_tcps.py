"""Plans of tools with several TCPs: which one takes the part, and that the proof asks for it."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.emptying.taking import carried_out, failure
from workbench.app.picking.glance import glance_at, glance_by_each_tcp
from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import adopt_plan
from workbench.app.picking.stations import put_down
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.model.derived.by_tcp import by_each_tcp, by_plan
from workbench.model.derived.place_of_plan import place_number
from workbench.model.geometry import Cylinder, pose_from_rpy
from workbench.model.messages.proofs import ProofText
from workbench.model.part_edits import with_part
from workbench.model.scan import Detection
from workbench.planning.collision.world import World
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.kinematics.robot import Kinematics
from workbench.proof.claims.prove import prove


@pytest.fixture(scope="module")
def cell():
    return read_cell("robots/tx2_90/two_cups.toml")


def lying(cell, *, tilt=0.0, y=0.0):
    """One puck in the middle of the bin, or tilted at a place along the wall."""
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, y, 0.05), (tilt, 0.0, 0.0))
    return (Detection("puck", T),)


def for_tcp(cell, tcp):
    """The cell whose grasps are for one TCP."""
    library = cell.part("puck").library
    entries = (replace(library.entries[0], tcp=tcp),)
    return with_part(cell, "puck", library=replace(library, entries=entries))


@pytest.fixture(scope="module")
def angled(cell):
    """A cell whose grasps are for the angled cup, and a plan for a puck."""
    only = for_tcp(cell, "angled")
    result = plan_pick(only, lying(only), "scan")
    assert result.proof is not None
    assert result.proof.holds, result.proof.violations
    return only, result


def test_the_first_tcp_is_tried_first(cell):
    result = plan_pick(cell, lying(cell), "scan")
    assert result.plan.arms[0].tcp == "straight"
    assert {candidate.tcp for candidate in result.candidates} == {"straight"}


def test_another_tcp_takes_what_the_first_one_cannot(cell):
    """A long bar under the straight cup keeps it off every part that lies flat."""
    (arm,) = cell.arms
    straight, second = arm.tool.tcps
    aside = replace(straight, T_flange_tcp=pose_from_rpy((0.0, 0.0, 0.2)))
    tool = replace(arm.tool, T_flange_tcp=aside.T_flange_tcp, tcps=(aside, second))
    other = replace(cell, arms=(replace(arm, tool=tool),))
    result = plan_pick(other, lying(other), "scan")
    assert result.proof.holds
    assert result.plan.arms[0].tcp == "angled"
    tried = [candidate.tcp for candidate in result.candidates]
    assert tried == sorted(tried, reverse=True), "the first one's candidates come first"
    assert set(tried) == {"straight", "angled"}
    refused = [c for c in result.candidates if c.tcp == "straight"]
    assert not any(candidate.verdict.is_ok for candidate in refused)


def test_a_grasp_for_a_tcp_is_tried_with_that_one_alone(angled):
    only, result = angled
    assert {candidate.tcp for candidate in result.candidates} == {"angled"}
    assert {candidate.tcp for candidate in judge(only, lying(only))} == {"angled"}
    (arm,) = result.plan.arms
    q = np.asarray(arm.leg("approach").q[-1])
    by = by_plan(only, result.plan)
    T_world_tcp = Kinematics(by).tcp_pose(by.arms[0], q)
    np.testing.assert_allclose(
        (T_world_tcp * arm.T_tcp_part).translation,
        result.plan.detections[0].T_world_part.translation,
        atol=1e-4,
    )
    assert T_world_tcp.rotation[2, 2] < -0.999, "the lip lies flat on the part"
    assert by.digest == only.digest == result.plan.cell_digest


def test_a_plan_file_states_the_tcp(angled, tmp_path):
    _, result = angled
    write_plan(tmp_path / "plan.json", result.plan, result.proof)
    again, stated = read_plan(tmp_path / "plan.json")
    assert (again.arms[0].tcp, again.digest) == ("angled", stated)


@pytest.mark.parametrize("tcp", ["straight", ""])
def test_a_plan_with_its_tcp_exchanged_is_refused(angled, tcp):
    only, result = angled
    plan = result.plan
    assert prove(only, plan.scene, plan).holds
    bent = replace(plan, arms=(replace(plan.arms[0], tcp=tcp),))
    problems = {violation.problem.text for violation in prove(only, plan.scene, bent).violations}
    assert {ProofText.GRASP_FOR_TCP, ProofText.NOT_AT_HAND, ProofText.NOT_IN_HAND} <= problems


def test_a_plan_with_its_tcp_exchanged_is_refused_where_grasps_are_for_any(cell, angled):
    _, result = angled
    plan = replace(result.plan, cell_digest=cell.digest)
    assert prove(cell, plan.scene, plan).holds, "any TCP may take by it"
    bent = replace(plan, arms=(replace(plan.arms[0], tcp="straight"),))
    problems = {violation.problem.text for violation in prove(cell, plan.scene, bent).violations}
    assert ProofText.NOT_IN_HAND in problems
    # Also where the bent plan states the part in the hand as the other TCP has it.
    T = (
        by_each_tcp(cell)[0]
        .arms[0]
        .tool.T_flange_tcp.actInv(by_each_tcp(cell)[1].arms[0].tool.T_flange_tcp)
    )
    arm = replace(plan.arms[0], tcp="straight", T_tcp_part=T * plan.arms[0].T_tcp_part)
    cleverer = prove(cell, plan.scene, replace(plan, arms=(arm,)))
    assert ProofText.NOT_IN_HAND in {violation.problem.text for violation in cleverer.violations}


def test_a_plan_with_a_tcp_that_the_tool_does_not_have_is_refused(angled):
    only, result = angled
    bent = replace(result.plan, arms=(replace(result.plan.arms[0], tcp="third", loads=None),))
    proof = prove(only, bent.scene, bent)
    assert [str(violation.problem) for violation in proof.violations] == [
        "tool two_cups has no TCP third"
    ]
    assert adopt_plan(only, bent).arms[0].loads is None
    single = read_cell("robots/tx2_90/full_bin.toml")
    named = replace(result.plan, cell_digest=single.digest)
    assert not prove(single, named.scene, named).holds


@pytest.mark.parametrize(("touches", "holds"), [("angled_cup", True), ("cup", False)])
def test_only_what_the_tcp_names_may_press_into_the_part(cell, touches, holds):
    """The angled cup is 2 mm longer than its TCP: its lip gives way, another solid does not."""
    (arm,) = for_tcp(cell, "angled").arms
    straight, angled = arm.tool.tcps
    body = tuple(
        replace(solid, shape=Cylinder(solid.shape.radius, solid.shape.length + 0.004))
        if solid.name == "angled_cup"
        else solid
        for solid in arm.tool.body
    )

    def pressing(*touches):
        tool = replace(arm.tool, body=body, tcps=(straight, replace(angled, touches=touches)))
        return replace(for_tcp(cell, "angled"), arms=(replace(arm, tool=tool),))

    plan = plan_pick(pressing("angled_cup"), lying(cell), "scan").plan
    other = pressing(touches)
    bent = replace(plan, cell_digest=other.digest)
    approach = [v for v in prove(other, plan.scene, bent).violations if v.leg == "approach"]
    assert (not approach) is holds, approach
    assert (plan_pick(other, lying(other), "scan").plan is not None) is holds
    checker = GraspChecker(other.part("puck"), by_plan(other, plan).arms[0].tool)
    check = checker.check(other.part("puck").library.grasps[0])
    assert ("cut" not in {finding.kind for finding in check.findings}) is holds


def test_what_follows_from_a_plan_uses_its_tcp(angled):
    only, result = angled
    plan = result.plan
    (arm,) = plan.arms
    assert place_number(only, arm) in (1, 2)
    keeps = replace(only, arms=(replace(only.arms[0], keeps_parts=True),))
    (put,) = put_down(keeps, plan)
    place = only.arms[0].Ts_world_place[0]
    assert np.linalg.norm((put.T_world_part.translation - place.translation)[:2]) < 1e-4
    taking = carried_out(only, plan.detections, arm, plan.detections[0])
    assert failure(taking, plan.detections[0]) == ""
    assert taking.touches == 0


def test_verdicts_while_something_is_dragged_are_of_all_tcps(cell):
    detections = lying(cell)
    whole = glance_by_each_tcp(cell, detections, ())
    each = [glance_at(World(by, detections)) for by in by_each_tcp(cell)]
    assert len(whole.reasons) == sum(len(one.reasons) for one in each)
    assert len(whole.tips) == len(whole.grasps) == len(whole.reasons)
    only = glance_by_each_tcp(for_tcp(cell, "angled"), detections, ())
    assert len(only.reasons) == len(each[1].reasons)
