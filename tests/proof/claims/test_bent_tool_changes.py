"""Plans that change a tool, bent: none is proven that a judge refuses, who asks Coal alone."""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from itertools import pairwise, product

import coal
import numpy as np
import pinocchio as pin
import pytest
from bending import with_leg
from bent_plans import TOO_NEAR, Bent, between, judge_plans, objections
from tool_changing import change_plan, changer_cell

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.geometry import Box, Floats, Solid
from workbench.model.motion import TOOL_LEGS
from workbench.model.plan import Leg, Plan
from workbench.model.robot import ToolSlot
from workbench.model.scan import Scene
from workbench.planning.collision.bodies import coal_shape
from workbench.proof.claims.prove import prove

SLACK = 0.0005

STEP = np.deg2rad(2.0)

CARRIES = {"reach": "old", "stow": "old", "undock": "new", "home": "new"}

Case = tuple[Cell, Plan]
Bend = Callable[[Cell, Plan, np.random.Generator], Case]


@pytest.fixture(scope="module")
def cell() -> Cell:
    return changer_cell()


@pytest.fixture(scope="module")
def plan(cell: Cell) -> Plan:
    return change_plan(cell)


def leg_with(plan: Plan, name: str, q: Floats, *, slower: float = 5.0) -> Plan:
    arm, q = plan.arms[0], np.deg2rad(np.round(np.rad2deg(q), 2))
    t = np.concatenate([[0.0], np.cumsum(np.full(len(q) - 1, slower))])
    return with_leg(plan, arm.arm, name, q=q, t=t)


def renamed(plan: Plan, tool: str) -> Plan:
    return replace(plan, arms=(replace(plan.arms[0], tool=tool),))


def with_slots(cell: Cell, plan: Plan, change: Callable[[ToolSlot], ToolSlot]) -> Case:
    """The cell with other slots, and the plan as if it were made for that cell."""
    (arm,) = cell.arms
    other = replace(cell, arms=(replace(arm, tool_slots=tuple(map(change, arm.tool_slots))),))
    return other, replace(plan, cell_digest=other.digest)


def test_a_change_holds_and_its_stretches_are_stated(cell: Cell, plan: Plan) -> None:
    proof = prove(cell, plan.scene, plan)
    assert proof.holds and tuple(leg for _, leg, _ in proof.clearances) == TOOL_LEGS
    assert proof.clearance >= cell.policy.margin
    again = prove(cell, plan.scene, plan, stated=proof)
    assert again.holds and again.clearance == proof.clearance


@pytest.mark.parametrize(
    ("tool", "said"),
    [("suction_cup", "carries tool suction_cup already"), ("spoon", "cannot carry tool spoon")],
)
def test_a_plan_that_names_another_tool_is_refused(
    cell: Cell, plan: Plan, tool: str, said: str
) -> None:
    assert said in objections(cell, renamed(plan, tool))


def test_a_tool_without_slot_and_a_stir_that_names_a_tool_are_refused(
    cell: Cell, plan: Plan
) -> None:
    (arm,) = cell.arms
    bare = replace(cell, arms=(replace(arm, tool_slots=arm.tool_slots[:1]),))
    assert "wide_cup of the arm has no slot" in objections(
        bare, replace(plan, cell_digest=bare.digest)
    )
    legs = {leg.name: leg for leg in plan.arms[0].legs}
    stir = (legs["reach"], replace(legs["cross"], name="stir"), legs["home"])
    assert "the legs are not" in objections(
        cell, replace(plan, arms=(replace(plan.arms[0], legs=stir),))
    )


def test_a_grasp_and_a_bin_that_is_left_out_are_refused(cell: Cell, plan: Plan) -> None:
    grasp = replace(plan, arms=(replace(plan.arms[0], grasp="top"),))
    assert "something else, too" in objections(cell, grasp)
    assert "the whole bin" in objections(cell, replace(plan, obstacles=()))


def test_other_loads_than_those_of_both_tools_are_refused(cell: Cell, plan: Plan) -> None:
    loads = plan.arms[0].loads
    assert loads is not None and loads.new_tool is not None
    for other in (None, replace(loads, new_tool=None), replace(loads, new_tool=loads.tool)):
        bent = replace(plan, arms=(replace(plan.arms[0], loads=other),))
        assert "load" in objections(cell, bent)


def test_a_slot_that_was_moved_by_two_millimetres_is_not_met(cell: Cell, plan: Plan) -> None:
    off = pin.SE3(np.eye(3), np.array([0.0, 0.002, 0.0]))
    moved = with_slots(
        cell, plan, lambda slot: replace(slot, T_world_flange=off * slot.T_world_flange)
    )
    said = objections(*moved)
    assert "leg stow" in said and "leg dock" in said and "from the slot of wide_cup" in said


def test_a_tool_may_touch_nothing_but_what_its_slot_names(cell: Cell, plan: Plan) -> None:
    closed = with_slots(cell, plan, lambda slot: replace(slot, fixture=""))
    assert "right mount and rack_suction_cup_left" in objections(*closed)


def test_another_direction_than_that_of_the_slot_is_refused(cell: Cell, plan: Plan) -> None:
    for leave in ([0.0, 0.0, 1.0], [0.3, -1.0, 0.0]):
        way = np.array(leave) / np.linalg.norm(leave)
        said = objections(*with_slots(cell, plan, lambda slot, way=way: replace(slot, leave=way)))
        assert "leg stow: does not go as the slot" in said and "leg undock" in said


# -- bent at random, and judged by Coal --------------------------------------------------------


def shaken(cell: Cell, plan: Plan, draw: np.random.Generator) -> Case:
    """One joint at one waypoint of a leg is elsewhere."""
    leg = plan.arms[0].legs[draw.integers(7)]
    q = np.array(leg.q)
    q[draw.integers(1, len(q)) if len(q) > 2 else 1, draw.integers(q.shape[1])] += (
        draw.normal() * 10 ** draw.uniform(-3.0, 0.3)
    )
    return cell, leg_with(plan, leg.name, q)


def beside_a_slot(cell: Cell, plan: Plan, draw: np.random.Generator) -> Case:
    """All of a visit to a slot is turned a little about the robot's foot."""
    off = np.zeros(6)
    off[0] = draw.normal() * 10 ** draw.uniform(-4.0, -1.0)
    names = (("stow", "retract"), ("dock", "undock"))[draw.integers(2)]
    before, after = (("reach", "cross"), ("cross", "home"))[names[0] == "dock"]
    for name in names:
        plan = leg_with(plan, name, np.asarray(plan.arms[0].leg(name).q) + off)
    first, last = (plan.arms[0].leg(name).q for name in names)
    there, back = (np.array(plan.arms[0].leg(name).q) for name in (before, after))
    there[-1], back[0] = first[0], last[-1]
    return cell, leg_with(leg_with(plan, before, there), after, back)


def cut_short(cell: Cell, plan: Plan, draw: np.random.Generator) -> Case:
    """A leg goes straight from its first waypoint to its last."""
    leg = plan.arms[0].legs[draw.integers(7)]
    return cell, leg_with(plan, leg.name, np.asarray(leg.q)[[0, -1]], slower=20.0)


def turned_round(cell: Cell, plan: Plan, draw: np.random.Generator) -> Case:
    """The arm comes with a tool from where it leaves without one, or the other way round."""
    arm = plan.arms[0]
    names, free = (
        (("stow", "retract"), ("reach", "cross")),
        (("dock", "undock"), ("cross", "home")),
    )[draw.integers(2)]
    first, last = (np.asarray(arm.leg(name).q) for name in names)
    there, back = (np.array(arm.leg(name).q) for name in free)
    there[-1], back[0] = last[-1], first[0]
    for name, q in (
        (names[0], last[::-1]),
        (names[1], first[::-1]),
        (free[0], there),
        (free[1], back),
    ):
        plan = leg_with(plan, name, q)
    return cell, plan


def slot_elsewhere(cell: Cell, plan: Plan, draw: np.random.Generator) -> Case:
    """A slot is a little elsewhere, or its tool leaves otherwise."""
    shift, chosen = draw.normal(size=3) * 10 ** draw.uniform(-4.5, -1.5), draw.integers(2)
    way = draw.normal(size=3) * 10 ** draw.uniform(-3.0, 0.0)

    def change(slot: ToolSlot) -> ToolSlot:
        if slot is not cell.arms[0].tool_slots[chosen]:
            return slot
        T, leave = slot.T_world_flange, slot.leave + way
        T = pin.SE3(T.rotation, T.translation + shift)
        return replace(slot, T_world_flange=T, leave=leave / np.linalg.norm(leave))

    return with_slots(cell, plan, change)


def another_tool_stands_there(cell: Cell, plan: Plan, draw: np.random.Generator) -> Case:
    """A third tool stands somewhere along the path of the flange."""
    (arm,) = cell.arms
    leg = plan.arms[0].legs[draw.integers(7)]
    q = np.asarray(leg.q)[draw.integers(len(leg.q))]
    at = flange_pose(cell, arm, q).translation + draw.normal(size=3) * 10 ** draw.uniform(-2, -0.5)
    third = replace(arm.tools[1], name="third_cup")
    T = pin.SE3(arm.tool_slots[0].T_world_flange.rotation, at)
    slot = ToolSlot("third_cup", T, np.array([0.0, 0.0, 1.0]), 0.1)
    more = replace(arm, tools=(*arm.tools, third), tool_slots=(*arm.tool_slots, slot))
    other = replace(cell, arms=(more,))
    return other, replace(plan, cell_digest=other.digest)


def other_tool(cell: Cell, plan: Plan, draw: np.random.Generator) -> Case:
    """The plan names another tool, or the arm carries the new one already."""
    if draw.integers(2):
        return cell, renamed(plan, "suction_cup")
    (arm,) = cell.arms
    carrying = replace(cell, arms=(replace(arm, tool=arm.tools[1]),))
    named = renamed(plan, "suction_cup")
    return carrying, replace(named, cell_digest=carrying.digest)


BENDS: tuple[Bend, ...] = (
    shaken,
    beside_a_slot,
    cut_short,
    turned_round,
    slot_elsewhere,
    another_tool_stands_there,
    other_tool,
)


def link_poses(cell: Cell, arm: Arm, q: Floats) -> dict[str, pin.SE3]:
    values = dict(zip(arm.joints, q, strict=True))
    found = {cell.robot.root: cell.T_world_robot}
    for joint in cell.robot.joints:
        fixed = joint.at(values.get(joint.name, 0.0))
        found[joint.child] = found[joint.parent] * fixed.T_parent_joint
    return found


def flange_pose(cell: Cell, arm: Arm, q: Floats) -> pin.SE3:
    return link_poses(cell, arm, q)[arm.flange]


Placed = tuple[str, Solid, pin.SE3]
"""What it belongs to, and where that is in the world."""


def away(placed: Placed, other: Placed) -> float:
    """How far [m] two solids are from each other."""
    (_, one, T), (_, two, U) = placed, other
    T, U = T * one.T_owner_shape, U * two.T_owner_shape
    a, b = (coal.Transform3s(X.rotation, X.translation) for X in (T, U))
    shapes = coal_shape(one.shape), coal_shape(two.shape)
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    return float(coal.distance(shapes[0], a, shapes[1], b, request, result))


def standing(cell: Cell, plan: Plan, carried: Tool | None) -> list[Placed]:
    (arm,) = cell.arms
    solids = [(f.name, solid, f.T_world_fixture) for f in cell.fixtures for solid in f.solids]
    solids += [("bin", solid, cell.bin.T_world_bin) for solid in cell.bin.solids]
    tools = {tool.name: tool for tool in arm.tools}
    for slot in arm.tool_slots:
        if carried is None or slot.tool != carried.name:
            body = tools[slot.tool].body
            solids += [(slot.tool, solid, slot.T_world_flange) for solid in body]
    return solids


def carried_at(cell: Cell, arm: Arm, tool: Tool | None, q: Floats) -> Iterator[Placed]:
    """Links that move, and the tool; the foot touches the floor."""
    poses = link_poses(cell, arm, q)
    for link in cell.robot.links:
        if link.name not in (cell.robot.root, cell.robot.joints[0].child, "base_link"):
            for solid in link.collision:
                is_flange = link.name == arm.flange
                yield "flange" if is_flange else "arm", solid, poses[link.name]
    for solid in () if tool is None else tool.body:
        yield "tool", solid, poses[arm.flange]


def refusals(cell: Cell, scene: Scene, plan: Plan) -> Iterator[str]:
    """What speaks against a change, looked at densely, with nothing of planner or proof."""
    del scene  # no change of these bends what lies there
    (arm,), legs = cell.arms, plan.arms[0].legs
    slots = {slot.tool: slot for slot in arm.tool_slots}
    tools: Mapping[str, Tool] = {tool.name: tool for tool in arm.tools}
    new, old = plan.arms[0].tool, arm.tool.name
    if new == old or new not in slots or new not in tools:
        yield "no such change"
        return
    if tuple(leg.name for leg in legs) != TOOL_LEGS:
        yield "other legs"
        return
    for leg, after in pairwise(legs):
        if np.abs(leg.q[-1] - after.q[0]).max() > 1e-6:
            yield "a jump"
    for leg in legs:
        carries = {"old": tools[old], "new": tools[new]}.get(CARRIES.get(leg.name, ""))
        slot = {"stow": slots[old], "retract": slots[old]}.get(leg.name, slots[new])
        straight, at = leg.name in ("stow", "retract", "dock", "undock"), leg.q[0]
        if straight:
            at, end = leg.q[0], leg.q[-1]
            if leg.name in ("stow", "dock"):
                at, end = end, at
            T, U = flange_pose(cell, arm, at), flange_pose(cell, arm, end)
            if np.linalg.norm(T.translation - slot.T_world_flange.translation) > 0.0015:
                yield f"{leg.name} is not at the slot"
            way = slot.leave if carries else -slot.T_world_flange.rotation[:, 2]
            if np.linalg.norm(U.translation - T.translation - slot.distance * way) > 0.003:
                yield f"{leg.name} goes elsewhere"
        found = next(near_things(cell, plan, leg, carries, slot, at if straight else None), "")
        if found:
            yield found
            return


def near_things(
    cell: Cell, plan: Plan, leg: Leg, carries: Tool | None, slot: ToolSlot, at: Floats | None
) -> Iterator[str]:
    """What comes too near to something on a leg; `at` is the posture at the slot."""
    (arm,), still, box = cell.arms, standing(cell, plan, carries), plan.obstacles[0]
    full = "bin", Solid("full", Box(box.size), pin.SE3.Identity()), box.T_world_box
    floors: dict[tuple[int, int], float] = {}
    touches = {slot.fixture} if carries else {slot.fixture, slot.tool}
    if at is not None:
        there = enumerate(carried_at(cell, arm, carries, at))
        for (i, a), (j, b) in product(there, enumerate(still)):
            if b[0] in touches and a[0] in ("tool", "flange"):
                d = away(a, b)
                if d < -SLACK - 0.00001:
                    yield f"{leg.name}: {a[1].name} is {d * 1000:.1f} mm in {b[1].name} at the slot"
                floors[i, j] = d - SLACK if d <= 1e-6 else max(d - SLACK, d / 2)
    for q in between(leg.q, STEP):
        moving = list(carried_at(cell, arm, carries, q))
        for (i, a), (j, b) in product(enumerate(moving), enumerate([*still, full])):
            is_tool = at is not None and a[0] == "tool"
            margin = cell.policy.near_margin if is_tool else cell.policy.margin
            margin = min(margin, floors.get((i, j), np.inf))
            if (d := away(a, b)) < margin - TOO_NEAR:
                yield f"{leg.name}: {a[1].name} and {b[0]} {b[1].name} {d * 1000:.1f} mm"
                return


def test_the_judge_has_nothing_against_the_plan(cell: Cell, plan: Plan) -> None:
    assert list(refusals(cell, plan.scene, plan)) == []


def test_none_of_70_bent_changes_is_proven_that_the_judge_refuses(cell: Cell, plan: Plan) -> None:
    def bend(seed: int) -> Bent:
        there, bent = BENDS[seed % len(BENDS)](cell, plan, np.random.default_rng([11, seed]))
        return there, bent.scene, bent

    accepted, refused = judge_plans(70, bend, refusals)
    assert accepted > 5 and refused > 30, (accepted, refused)
