"""Plans that stir the parts in the bin, bent: none is proven that an independent judge refuses."""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import pinocchio as pin
import pytest
from bending import with_leg
from bent_plans import TOO_NEAR, Bent, between, judge_plans, objections

from workbench.app.empty_hand.stirring import plan_stir
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.geometry import Floats
from workbench.model.plan import Plan
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.perception.simulation.piles import pile_of
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.proof.claims.stirring import content_of

Bend = Callable[[Plan, np.random.Generator], Plan]


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell("robots/yumi/kits.toml")


@pytest.fixture(scope="module")
def plan(cell: Cell) -> Plan:
    pile = pile_of(cell, "", 5, seed=3)
    made = plan_stir(cell, Scene(digest_of(pile), pile)).plan
    assert made is not None
    return made


def leg_with(plan: Plan, name: str, q: Floats, *, slower: float = 3.0) -> Plan:
    arm, q = plan.arms[0], np.deg2rad(np.round(np.rad2deg(q), 2))
    return with_leg(plan, arm.arm, name, q=q, t=arm.leg(name).t * slower)


def test_it_holds_and_nothing_else_may_be_in_the_parts(cell: Cell, plan: Plan) -> None:
    assert objections(cell, plan) == ""
    content = content_of(cell, plan.scene)
    highest = max(
        float(
            (cell.bin.T_world_bin.actInv(found.T_world_part) * cell.part(found.part).mesh.middle)[2]
        )
        for found in plan.detections
    )
    assert content.high > highest and content.top > content.high + 0.07
    assert content.others == ()


def test_a_hand_that_goes_into_things_is_refused_with_the_pair(cell: Cell, plan: Plan) -> None:
    said = ""
    for joint, off in product((1, 3), (0.3, -0.3)):
        q = np.array(plan.arms[0].leg("stir").q)
        q[len(q) // 2, joint] += off
        said += objections(cell, leg_with(plan, "stir", q))
    assert "leg stir after waypoint" in said and "clearance -" in said


def test_the_way_there_keeps_clear_of_the_parts(cell: Cell, plan: Plan) -> None:
    arm = plan.arms[0]
    stir = np.array(arm.leg("stir").q)
    deep = leg_with(plan, "reach", np.vstack([arm.leg("reach").q[:-1], stir[3]]), slower=1.0)
    bent = leg_with(deep, "stir", np.vstack([stir[3:4], stir[1:]]))
    assert "above_bin_content" in objections(cell, bent)


def test_a_plan_made_faster_by_hand_is_refused(cell: Cell, plan: Plan) -> None:
    leg = plan.arms[0].leg("stir")
    fast = with_leg(plan, plan.arms[0].arm, "stir", t=np.asarray(leg.t) * 0.8)
    assert "100 mm/s" in objections(cell, fast)


def test_open_fingers_a_grasp_or_another_leg_are_refused(cell: Cell, plan: Plan) -> None:
    arm = plan.arms[0]
    wide = with_leg(plan, arm.arm, "stir", opening=cell.arm(arm.arm).tool.stroke[1])
    assert "fingers 0.0 mm open" in objections(cell, wide)
    assert "something else" in objections(cell, replace(plan, arms=(replace(arm, grasp="top"),)))
    shorter = replace(arm, legs=arm.legs[:2])
    assert "the legs are not" in objections(cell, replace(plan, arms=(shorter,)))


def test_parts_beside_the_bin_and_a_bin_without_walls_are_refused(cell: Cell, plan: Plan) -> None:
    out = cell.bin.T_world_bin.act(np.array([0.4, 0.0, 0.02]))
    lost = replace(plan.detections[0], T_world_part=pin.SE3(np.eye(3), out))
    bent = replace(plan, detections=(lost, *plan.detections[1:]))
    assert "part-1 does not lie between the walls" in objections(cell, bent)
    flat = replace(cell, bin=replace(cell.bin, has_walls=False))
    assert "no walls" in objections(flat, replace(plan, cell_digest=flat.digest))


def test_a_part_or_thing_that_the_plan_leaves_out_is_refused(cell: Cell, plan: Plan) -> None:
    less = replace(plan, detections=plan.detections[1:])
    assert "part-1" in objections(cell, less, plan.scene)
    thing = Obstacle(plan.detections[0].T_world_part, np.array([0.02, 0.02, 0.02]))
    assert objections(cell, plan, replace(plan.scene, obstacles=(thing,)))


def test_a_higher_heap_makes_the_box_higher_and_what_stands_beside_stays(cell: Cell) -> None:
    low = Detection(cell.parts[0].name, cell.bin.T_world_bin)
    T_high = cell.bin.T_world_bin * pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.05]))
    beside = cell.bin.T_world_bin * pin.SE3(np.eye(3), np.array([0.4, 0.0, 0.02]))
    cube = np.array([0.02, 0.02, 0.02])
    flat = content_of(cell, Scene("", (low,)))
    high = content_of(cell, Scene("", (low,), (Obstacle(T_high, cube), Obstacle(beside, cube))))
    assert high.high > flat.high + 0.01
    assert [seen.T_world_box for seen in high.others] == [beside]


def obstacle_at(cell: Cell, place: tuple[float, float, float], size: list[float]) -> Obstacle:
    """A thing that the scan shows, in the bin's frame."""
    T_bin_box = pin.SE3(np.eye(3), np.array(place))
    return Obstacle(cell.bin.T_world_bin * T_bin_box, np.array(size))


def test_nothing_that_hangs_over_the_bin_or_lies_across_its_walls_may_be_stirred(
    cell: Cell, plan: Plan
) -> None:
    lamp = obstacle_at(cell, (0.0, 0.0, 0.2), [0.05, 0.05, 0.4])
    board = obstacle_at(cell, (0.05, 0.0, 0.04), [0.2, 0.03, 0.01])
    crumb = obstacle_at(cell, (0.05, 0.0, 0.02), [0.01, 0.01, 0.04])
    content = content_of(cell, replace(plan.scene, obstacles=(lamp, board, crumb)))
    assert content.others == (lamp, board)
    assert content.high == content_of(cell, plan.scene).high
    for thing in (lamp, board):
        over = replace(plan, obstacles=(thing,))
        assert "seen-1" in objections(cell, over)
    assert objections(cell, replace(plan, obstacles=(crumb,))) == ""


def test_a_rod_on_a_thick_wall_is_no_content(cell: Cell, plan: Plan) -> None:
    thick = replace(cell, bin=replace(cell.bin, wall=0.02))
    inner = float(cell.bin.size[0] / 2)
    rim = float(cell.bin.size[2])
    rod = obstacle_at(thick, (inner + 0.01, 0.0, rim + 0.005), [0.01, 0.1, 0.01])
    touching = obstacle_at(thick, (inner - 0.003, 0.0, 0.02), [0.01, 0.1, 0.02])
    content = content_of(thick, replace(plan.scene, obstacles=(rod, touching)))
    assert content.others == (rod,)


def shaken(plan: Plan, draw: np.random.Generator) -> Plan:
    """One joint at one waypoint of the way through the parts is elsewhere."""
    q = np.array(plan.arms[0].leg("stir").q)
    row, joint = draw.integers(1, len(q) - 1), draw.integers(q.shape[1])
    q[row, joint] += draw.normal() * 10 ** draw.uniform(-2.0, 0.3)
    return leg_with(plan, "stir", q, slower=10.0)


def shifted(plan: Plan, draw: np.random.Generator) -> Plan:
    """All waypoints but the ends are a little elsewhere."""
    q = np.array(plan.arms[0].leg("stir").q)
    q[1:-1] += draw.normal(size=q.shape[1]) * 10 ** draw.uniform(-2.5, -0.3)
    return leg_with(plan, "stir", q, slower=10.0)


def cut_short(plan: Plan, draw: np.random.Generator) -> Plan:
    """Some waypoints are left out: the hand goes straight from one to a later one."""
    q = np.array(plan.arms[0].leg("stir").q)
    first = int(draw.integers(0, len(q) - 3))
    last = int(draw.integers(first + 2, min(first + 25, len(q) - 1) + 1))
    keeps = np.r_[0 : first + 1, last : len(q)]
    arm = plan.arms[0]
    t = np.arange(len(keeps)) * 20.0
    return with_leg(plan, arm.arm, "stir", q=q[keeps], t=t)


BENDS: tuple[Bend, ...] = (shaken, shifted, cut_short)


def refusals(cell: Cell, scene: Scene, plan: Plan) -> Iterator[str]:
    """What comes too near to something on the way through the parts, looked at densely."""
    content, arm = content_of(cell, scene), plan.arms[0]
    world = World(cell, (), (*content.boxes, *content.others), by_coal=True)
    moves = frozenset({arm.arm})
    leg = arm.leg("stir")
    world.enter(LegPhase(moves, {arm.arm: leg.opening}, straight=moves, stirs=moves))
    for q in between(leg.q):
        for contact in world.contacts(world.configuration({arm.arm: q})):
            if contact.distance < contact.margin - TOO_NEAR:
                yield f"{contact.pair} are {contact.distance * 1000:.1f} mm apart"
                return


def test_none_of_90_bent_plans_is_proven_that_the_judge_refuses(cell: Cell, plan: Plan) -> None:
    def bend(seed: int) -> Bent:
        bent = BENDS[seed % len(BENDS)](plan, np.random.default_rng([7, seed]))
        return cell, bent.scene, bent

    accepted, refused = judge_plans(90, bend, refusals)
    assert accepted > 10 and refused > 15, (accepted, refused)
