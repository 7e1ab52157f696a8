"""At the slot of a tool: what may touch how deep, that no link may, and how fast points are."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from bending import with_leg
from bent_plans import objections
from tool_changing import change_plan, changer_cell

from workbench.app.empty_hand.tool_change import plan_tool_change
from workbench.model.cell import Cell
from workbench.model.geometry import Box, Solid
from workbench.model.plan import Plan
from workbench.model.tools.slots import change_problem
from workbench.planning.empty_hand.tool_change import slot_problem
from workbench.proof.claims.prove import prove


@pytest.fixture(scope="module")
def cell() -> Cell:
    return changer_cell()


@pytest.fixture(scope="module")
def plan(cell: Cell) -> Plan:
    return change_plan(cell)


def with_block(cell: Cell, plan: Plan, size: list[float], at: list[float]) -> tuple[Cell, Plan]:
    """The cell whose rack has one more block, and the plan as if it were made for that cell."""
    block = Solid("rack_block", Box(np.array(size)), pin.SE3(np.eye(3), np.array(at)))
    fixtures = tuple(
        replace(f, solids=(*f.solids, block)) if f.name == "rack" else f for f in cell.fixtures
    )
    other = replace(cell, fixtures=fixtures)
    return other, replace(plan, cell_digest=other.digest)


def test_a_link_does_not_enter_the_fixture_of_a_slot(cell: Cell, plan: Plan) -> None:
    there, bent = with_block(cell, plan, [0.4, 0.06, 0.1], [0.0, 0.06, 0.48])
    assert "link_4 and rack_block" in objections(there, bent)
    made = plan_tool_change(there, "right", "wide_cup")
    assert made.proof is None or made.proof.holds


def test_a_tool_does_not_enter_the_fixture_of_its_slot(cell: Cell, plan: Plan) -> None:
    there, bent = with_block(cell, plan, [0.08, 0.08, 0.02], [-0.1, 0.0, 0.3])
    said = objections(there, bent)
    assert "in the slot, contacts may be 0.5 mm deep: right tube and rack_block" in said
    assert "leg stow after waypoint 6" in said
    made = plan_tool_change(there, "right", "wide_cup")
    assert made.plan is None
    said = str(made.verdict)
    assert "right tube and rack_block" in said and "0.5 mm deep" in said and "stow" in said
    assert "rack_block" in str(slot_problem(there, "right", "suction_cup"))


@pytest.mark.parametrize(("lower", "holds"), [(0.0, True), (0.0003, True), (0.0008, False)])
def test_a_tool_is_at_most_half_a_millimetre_deep_in_its_slot(
    cell: Cell, lower: float, holds: bool
) -> None:
    (arm,) = cell.arms
    down = pin.SE3(np.eye(3), np.array([0.0, 0.0, -lower]))
    slots = tuple(replace(s, T_world_flange=down * s.T_world_flange) for s in arm.tool_slots)
    low = replace(cell, arms=(replace(arm, tool_slots=slots),))
    assert (slot_problem(low, "right", "suction_cup") is None) is holds
    made = plan_tool_change(low, "right", "wide_cup")
    assert (made.proof is not None and made.proof.holds) is holds


def test_no_point_is_faster_at_a_slot_than_the_policy_says(cell: Cell, plan: Plan) -> None:
    proof = prove(cell, plan.scene, plan)
    fast = {bound.leg: bound.point for bound in proof.speeds}
    assert proof.holds and fast["cross"] > 0.5
    for leg in ("stow", "retract", "dock", "undock"):
        assert 0.03 < fast[leg] <= cell.policy.slot_speed == 0.05
        moved = plan.arms[0].leg(leg)
        quick = with_leg(plan, "right", leg, q=moved.q, t=np.asarray(moved.t) * 0.8)
        assert f"leg {leg} after waypoint" in objections(cell, quick)


def test_a_slower_slot_speed_is_kept(cell: Cell) -> None:
    slow = replace(cell, policy=replace(cell.policy, slot_speed=0.02))
    made = plan_tool_change(slow, "right", "wide_cup")
    assert made.proof is not None and made.proof.holds
    assert max(b.point for b in made.proof.speeds if b.leg in ("stow", "undock")) <= 0.02


def test_an_arm_whose_jerk_is_limited_changes_no_tool(cell: Cell) -> None:
    (arm,) = cell.arms
    jerky = replace(arm, jerk=np.full(6, 100.0))
    problem = change_problem(replace(cell, arms=(jerky,)), "right", "wide_cup")
    assert str(problem) == "arm right has jerk_deg: how fast it is at a slot cannot be proven"


def test_a_link_near_the_rack_is_in_the_clearance_that_is_shown(cell: Cell, plan: Plan) -> None:
    there, bent = with_block(cell, plan, [0.4, 0.01, 0.1], [0.0, 0.1, 0.48])
    shown = {
        leg: np.asarray(bounds) for _, leg, bounds in prove(there, bent.scene, bent).clearances
    }
    before = {
        leg: np.asarray(bounds) for _, leg, bounds in prove(cell, plan.scene, plan).clearances
    }
    assert shown["stow"].min() < before["stow"].min() - 0.005
