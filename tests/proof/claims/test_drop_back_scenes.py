"""Drop backs where a part reaches what it must not: beside the hand, its own arm, another TCP."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.empty_hand.drop_back import plan_drop_back
from workbench.app.picking.judging import search_candidates
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell, Tcp
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Floats, pose_from_rpy
from workbench.model.load import tool_loads
from workbench.model.plan import Plan
from workbench.model.scan import Obstacle, Scene
from workbench.model.tools.held_body import (
    HeldAmount,
    held_loads,
    held_radius,
    stand_below,
    with_held,
)
from workbench.perception.simulation.piles import pile_of
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.kinematics.inverse import configurations, starts_of
from workbench.plugins.robot_link import spoken_to_by
from workbench.proof.claims.drop_back import drop_point, fall_height
from workbench.proof.claims.prove import prove
from workbench.proof.claims.stirring import bodies_of
from workbench.proof.claims.table import PairTable, Situation
from workbench.proof.engine.robot import tree_of

DOWN = pose_from_rpy((0.0, 0.0, 0.0), (np.pi, 0.0, 0.0)).rotation


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="module")
def plan(cell: Cell) -> Plan:
    """The right arm begins over the bin, low enough for a leg `lift`."""
    made = plan_drop_back(cell, "right", above_bin(cell, 0.1), HeldAmount.ONE).plan
    assert made is not None and made.arms[0].legs[0].name == "lift"
    return made


def above_bin(cell: Cell, high: float, beside: tuple[float, float] = (0.0, 0.0)) -> Floats:
    """Where the right arm (n,) [rad] has its hand `high` [m] above the bin's floor."""
    chain = World(cell, (), ()).chains["right"]
    p = cell.bin.T_world_bin.act(np.array([*beside, high]))
    return configurations(chain, pin.SE3(DOWN, p), starts_of(chain, cell.arm("right"), 0)).q[0]


def objections(cell: Cell, plan: Plan) -> str:
    scene = Scene(plan.scan_digest, (), plan.obstacles)
    return "\n".join(map(str, prove(cell, scene, plan).violations))


def test_what_a_scan_shows_beside_the_hand_stands_on_nothing(cell: Cell, plan: Plan) -> None:
    """A part that hangs slantwise below a bar takes it along on its way up."""
    q = plan.arms[0].leg("lift").q[0]
    p = World(cell, (), ()).chains["right"].pose(q).translation
    bar = Obstacle(pin.SE3(np.eye(3), p + [0.075, 0.0, -0.03]), np.array([0.01, 0.1, 0.01]))
    on_floor = replace(bar, size=np.array([0.01, 0.1, 2 * float(p[2])]))
    for seen in (bar, on_floor):
        assert "held_body" in objections(cell, replace(plan, obstacles=(seen,)))
        verdict = plan_drop_back(cell, "right", q, HeldAmount.ONE, placed=(seen,)).verdict
        assert "the part in the right hand" in str(verdict) and "seen-3" in str(verdict)


def test_what_is_held_does_not_come_to_the_arm_that_holds_it(cell: Cell, plan: Plan) -> None:
    world = World(with_held(cell, "right", HeldAmount.ONE), (), ())
    world.enter(LegPhase(frozenset({"right"}), {"right": 0.0}))
    step = np.deg2rad(0.01)
    chain, draw, refused = world.chains["right"], np.random.default_rng(3), 0
    while refused < 4:
        q = np.deg2rad(np.round(np.rad2deg(draw.uniform(chain.lower, chain.upper)), 2))
        pairs = [contact.pair for contact in world.contacts(world.configuration({"right": q}))]
        names = {name for pair in pairs for name in pair} - {"right held_body"}
        if len(pairs) != 1 or len(names) != 1 or "right_link" not in names.pop():
            continue
        carry, home = plan.arms[0].legs[1:]
        carry = replace(carry, q=np.vstack([q, q + step]), t=np.array([0.0, 5.0]))
        home = replace(home, q=np.vstack([q + step, home.q[-1]]), t=np.array([0.0, 60.0]))
        arm = replace(plan.arms[0], legs=(carry, home))
        said = objections(cell, replace(plan, arms=(arm,), sequence=plan.sequence[1:]))
        assert "right held_body" in said and "right_link" in said
        refused += 1


def test_it_is_compared_with_all_links_but_those_that_the_hand_is_fixed_to(
    cell: Cell, plan: Plan
) -> None:
    holding = with_held(cell, "right", HeldAmount.ONE)
    tree = tree_of(holding)
    bodies = bodies_of(holding, tree, plan)
    table = PairTable(holding, tree, bodies)
    moves = np.zeros(tree.model.nq, bool)
    moves[tree.columns["right"]] = True
    pairs = table.pairs(Situation(moves, near_arm="right"), np.array([b.joint for b in bodies]))
    met = {name for row in pairs.rows for name in ball_partner(table.labels(int(row)))}
    own = {f"right_link_{number}" for number in (1, 2, 7, 3, 4, 5)}
    assert own <= met and "right_link_6" not in met
    assert not any(name.startswith("right ") for name in met)
    world = World(holding, (), ())
    world.enter(LegPhase(frozenset({"right"}), {"right": 0.0}))
    q = world.configuration({})
    every = [world.nearest(q, np.array([k])).pair for k in world.pairs.among]
    seen = {name for pair in every for name in ball_partner(pair)}
    assert own <= seen and not any(name.startswith("right ") for name in seen)


def ball_partner(pair: tuple[str, str]) -> list[str]:
    """The other one of a pair with the ball."""
    return [b for a, b in (pair, pair[::-1]) if a == "right held_body"]


def test_a_tool_with_several_tcps_is_refused(cell: Cell, plan: Plan) -> None:
    cups = spoken_to_by(read_cell("robots/tx2_90/two_cups.toml"), "abb-socket/2")
    with pytest.raises(InputError, match="take it out by hand"):
        plan_drop_back(cups, "right", cups.arm("right").home, HeldAmount.ONE)
    arm = cell.arm("right")
    tcps = tuple(Tcp(name, arm.tool.T_flange_tcp) for name in ("first", "second"))
    arms = tuple(
        replace(each, tool=replace(each.tool, tcps=tcps)) if each is arm else each
        for each in cell.arms
    )
    other = replace(cell, arms=arms)
    said = objections(other, replace(plan, cell_digest=other.digest))
    assert "may hold a part at first or second" in said


def test_the_ball_holds_a_part_by_every_grip_that_a_search_finds(cell: Cell) -> None:
    radius, count = held_radius(cell, HeldAmount.ONE), 0
    for seed in (1, 2):
        pile = pile_of(cell, "", 3, seed=seed)
        world = World(cell, pile, ())
        for number, found in enumerate(pile):
            points = np.asarray(cell.part(found.part).mesh.points)
            for candidate in search_candidates(world, number, 0):
                p = candidate.grasp.T_part_tcp.translation
                assert np.linalg.norm(points - p, axis=1).max() < radius
                count += 1
    assert count > 20
    for first, second in pairwise((HeldAmount.ONE, HeldAmount.TWO)):
        assert held_radius(cell, first) < held_radius(cell, second)


def test_the_controller_gets_the_load_of_the_heaviest_part_in_the_hand(cell: Cell) -> None:
    arm = cell.arm("right")
    tool = replace(arm.tool, mass=0.3)
    known = replace(
        cell, arms=tuple(replace(each, tool=tool) if each is arm else each for each in cell.arms)
    )
    plan = plan_drop_back(known, "right", above_bin(known, 0.1), HeldAmount.ONE).plan
    assert plan is not None and objections(known, plan) == ""
    (arm_plan,) = plan.arms
    loads, heaviest = arm_plan.loads, max(part.mass for part in cell.parts)
    assert loads is not None and loads.part is not None
    assert loads.carried(True).mass == pytest.approx(0.3 + heaviest)
    assert loads.carried(False).mass == 0.3
    assert np.allclose(loads.part.centre, tool.T_flange_tcp.translation)
    assert [leg.holding for leg in arm_plan.legs] == [True, True, False]
    twice = held_loads(known, "right", HeldAmount.UNKNOWN)
    assert twice is not None and twice.part is not None
    assert twice.part.mass == pytest.approx(2 * heaviest)
    for wrong in (tool_loads(tool), twice):
        bent = replace(plan, arms=(replace(arm_plan, loads=wrong),))
        assert "the load of the part" in objections(known, bent)


def test_what_overhangs_step_by_step_or_over_a_slit_is_in_the_way() -> None:
    up = pin.SE3.Identity()
    floor = Box(np.array([0.4, 0.4, 0.01])), pin.SE3(np.eye(3), np.array([0.0, 0.0, -0.005]))
    steps = [
        (
            Box(np.array([0.05 + 2 * out, 0.1, 0.006])),
            pin.SE3(np.eye(3), np.array([0.12, 0.0, 0.003 + 0.006 * number])),
        )
        for number, out in enumerate((0.0, 0.0029, 0.0058))
    ]
    rail = Box(np.array([0.05, 0.1, 0.02])), pin.SE3(np.eye(3), np.array([-0.12, 0.0, 0.0129]))
    found = stand_below([floor, *steps, rail], np.array([0.0, 0.0, 0.03]), 0.1, up)
    assert found.tolist() == [True, True, False, False, False]


def test_a_hand_that_leaves_the_straight_way_up_by_millimetres_is_refused(
    cell: Cell, plan: Plan
) -> None:
    arm = plan.arms[0]
    lift = arm.leg("lift")
    some = [0, 2, len(lift.q) - 1]
    bent = replace(lift, q=lift.q[some], t=3 * lift.t[some])
    assert "not straight" not in objections(cell, plan)
    legs = tuple(bent if leg.name == "lift" else leg for leg in arm.legs)
    assert "is not straight" in objections(cell, replace(plan, arms=(replace(arm, legs=legs),)))


def moved_bin(cell: Cell, high: float, leaning: float) -> Cell:
    T = cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, high), (0.0, leaning, 0.0))
    return replace(cell, bin=replace(cell.bin, T_world_bin=T))


def test_over_a_bin_that_leans_the_hand_opens_plumb_over_its_rim(cell: Cell) -> None:
    """What is dropped goes down, not along the normal of the bin's floor."""
    leaning = moved_bin(cell, 0.05, np.deg2rad(30.0))
    box, point = leaning.bin, drop_point(leaning, HeldAmount.ONE)
    middle = box.T_world_bin.act(np.array([0.0, 0.0, float(box.size[2])]))
    assert np.allclose(point[:2], middle[:2])
    corners = [
        box.T_world_bin.act(np.array([x, y, 0.0]) * np.asarray(box.size) / 2)
        for x in (-1.0, 1.0)
        for y in (-1.0, 1.0)
    ]
    lowest = min(corner[2] for corner in corners)
    height = fall_height(leaning, HeldAmount.ONE)
    assert height is not None and height >= point[2] - lowest
    chain, T_bin_tcp = World(leaning, (), ()).chains["right"], pin.SE3(DOWN, np.array([0, 0, 0.12]))
    starts = starts_of(chain, leaning.arm("right"), 0)
    q = configurations(chain, box.T_world_bin * T_bin_tcp, starts).q[1]
    made = plan_drop_back(leaning, "right", q, HeldAmount.ONE).plan
    assert made is not None and objections(leaning, made) == ""
    hand = World(leaning, (), ()).chains["right"].pose(made.arms[0].leg("carry").q[-1])
    assert hand.rotation[2, 2] == pytest.approx(-1.0, abs=1e-3)
    along = box.T_world_bin.act(np.array([0.0, 0.0, 0.26]))
    elsewhere = replace(leaning, bin=replace(box, p_world_drop=tuple(map(float, along))))
    assert fall_height(elsewhere, HeldAmount.ONE) is None


def test_the_way_up_is_straight_also_where_joints_turn_fast(cell: Cell) -> None:
    high = moved_bin(cell, 0.05, 0.0)
    result = plan_drop_back(high, "right", above_bin(high, 0.12), HeldAmount.ONE)
    assert result.plan is not None and objections(high, result.plan) == ""
