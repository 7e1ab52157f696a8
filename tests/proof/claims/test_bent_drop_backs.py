"""Plans that drop back what a hand holds, bent: none is proven that a judge refuses."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import coal
import numpy as np
import pinocchio as pin
import pytest
from bending import with_leg
from bent_plans import TOO_NEAR, Bent, between, judge_plans, objections

from workbench.app.empty_hand.drop_back import plan_drop_back
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.digest import digest_of
from workbench.model.geometry import Box, Floats, Sphere, pose_from_rpy
from workbench.model.plan import Plan, Step
from workbench.model.scan import Obstacle, Scene
from workbench.model.tools.held_body import (
    GRIP_ROOM,
    HeldAmount,
    held_radius,
    held_reach,
    stand_below,
    with_held,
)
from workbench.perception.simulation.piles import pile_of
from workbench.planning.collision.bodies import coal_shape
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.proof.claims.drop_back import DROPPED, drop_point
from workbench.proof.claims.stirring import unseen_content

Bend = Callable[[Plan, np.random.Generator], Plan]


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="module")
def start(cell: Cell) -> Floats:
    """Where the right arm stands half way out of the bin with a part."""
    pile = pile_of(cell, "", 5, seed=1)
    plan = plan_pick(cell, pile, digest_of(pile)).plan
    assert plan is not None
    leg = plan.arm("right").leg("extract")
    return leg.at(leg.seconds / 2)


@pytest.fixture(scope="module")
def plan(cell: Cell, start: Floats) -> Plan:
    made = plan_drop_back(cell, "right", start, HeldAmount.ONE).plan
    assert made is not None and [leg.name for leg in made.arms[0].legs] == ["lift", "carry", "home"]
    return made


def rounded(q: Floats) -> Floats:
    return np.deg2rad(np.round(np.rad2deg(q), 2))


def joined(plan: Plan, paths: dict[str, Floats], *, slower: float = 6.0) -> Plan:
    """Legs go other paths, slowly; each begins where the one before ends."""
    arm, legs, end = plan.arms[0], [], None
    for leg in plan.arms[0].legs:
        q = rounded(np.array(paths.get(leg.name, leg.q)))
        if end is not None:
            q[0] = end
        t = np.asarray(leg.t) if len(q) == len(leg.t) else np.arange(len(q)) * 5.0
        legs.append(replace(leg, q=q, t=t * slower))
        end = q[-1]
    return replace(plan, arms=(replace(arm, legs=tuple(legs)),))


def test_it_holds_and_states_from_how_high_the_part_falls(cell: Cell, plan: Plan) -> None:
    assert objections(cell, plan) == ""
    point = drop_point(cell, HeldAmount.ONE)
    content = unseen_content(cell, plan.scene)
    high = float(cell.bin.T_world_bin.actInv(point)[2])
    assert high - held_radius(cell, HeldAmount.ONE) > content.top + cell.policy.margin


def test_more_in_the_hand_than_was_planned_for_is_refused(cell: Cell, plan: Plan) -> None:
    for held in ("two", "unknown"):
        arm = replace(plan.arms[0], held=held)
        assert "right held_body" in objections(cell, replace(plan, arms=(arm,)))
    arm = replace(plan.arms[0], held="three")
    assert "one, two or unknown" in objections(cell, replace(plan, arms=(arm,)))


def test_a_hand_that_goes_sideways_out_of_the_bin_is_refused(cell: Cell, plan: Plan) -> None:
    q = np.array(plan.arms[0].leg("lift").q)
    q[1:, 0] += np.linspace(0.0, 0.1, len(q))[1:]
    assert "straight" in objections(cell, joined(plan, {"lift": q}))
    down = joined(plan, {"lift": np.array(plan.arms[0].leg("lift").q)[::-1]})
    assert "straight up" in objections(cell, down)


def test_without_the_way_up_the_hand_is_among_the_parts(cell: Cell, plan: Plan) -> None:
    arm = plan.arms[0]
    carry = np.vstack([arm.leg("lift").q[:1], arm.leg("carry").q[1:]])
    legs = joined(plan, {"carry": carry}).arms[0].legs[1:]
    legs = (replace(legs[0], q=rounded(carry)), *legs[1:])
    steps = tuple(Step((("right", leg.name),)) for leg in legs)
    bent = replace(plan, arms=(replace(arm, legs=legs),), sequence=steps)
    assert "bin" in objections(cell, bent)


def test_the_hand_opens_nowhere_else_and_points_down(cell: Cell, plan: Plan) -> None:
    q = np.array(plan.arms[0].leg("carry").q)
    q[-1, 0] += 0.05
    assert "from where the hand is to open" in objections(cell, joined(plan, {"carry": q}))
    moved = replace(cell, bin=replace(cell.bin, p_world_drop=(0.3, 0.0, 0.4)))
    said = objections(moved, replace(plan, cell_digest=moved.digest))
    assert "from where the hand is to open" in said


def test_a_place_of_the_cell_file_is_where_the_hand_opens(cell: Cell, start: Floats) -> None:
    box = replace(cell, bin=replace(cell.bin, p_world_drop=(0.4, -0.05, 0.35)))
    result = plan_drop_back(box, "right", start, HeldAmount.ONE)
    assert result.plan is not None and result.proof is not None and result.proof.holds
    world = World(box, (), ())
    p = world.chains["right"].pose(result.plan.arms[0].leg("carry").q[-1]).translation
    assert np.allclose(p, (0.4, -0.05, 0.35), atol=0.002)


def test_a_plan_made_faster_by_hand_is_refused(cell: Cell, plan: Plan) -> None:
    for name in ("lift", "carry"):
        leg = plan.arms[0].leg(name)
        assert objections(cell, with_leg(plan, "right", name, t=np.asarray(leg.t) * 0.5))
    held = replace(cell, policy=replace(cell.policy, held_speed=0.02))
    assert "20 mm/s" in objections(held, replace(plan, cell_digest=held.digest))


def test_a_hand_that_goes_home_closed_a_grasp_and_another_link_are_refused(
    cell: Cell, plan: Plan
) -> None:
    closed = with_leg(plan, "right", "home", opening=0.0)
    assert "fingers 0.0 mm open" in objections(cell, closed)
    arm = replace(plan.arms[0], grasp="top")
    assert "something else" in objections(cell, replace(plan, arms=(arm,)))
    motion = replace(cell.controller.motion, keeps_hand=False)
    other = replace(cell, controller=replace(cell.controller, motion=motion))
    assert "opens or closes the hand" in objections(other, plan)


def test_a_thing_over_the_way_up_is_in_the_way(cell: Cell, plan: Plan, start: Floats) -> None:
    world = World(cell, (), ())
    over = world.chains["right"].pose(start).translation + [0.0, 0.0, 0.12]
    lamp = Obstacle(pin.SE3(np.eye(3), over + [0.1, 0.0, 0.0]), np.array([0.06, 0.06, 0.02]))
    scene = replace(plan.scene, obstacles=(lamp,))
    assert "seen-1" in objections(cell, replace(plan, obstacles=(lamp,)), scene)


def shaken(plan: Plan, draw: np.random.Generator) -> Plan:
    """One joint at one waypoint is elsewhere."""
    name = ("lift", "carry")[draw.integers(2)]
    q = np.array(plan.arms[0].leg(name).q)
    q[draw.integers(1, len(q) - 1), draw.integers(q.shape[1])] += (
        draw.normal() * 10 ** draw.uniform(-3.5, 0.3)
    )
    return joined(plan, {name: q})


def shifted(plan: Plan, draw: np.random.Generator) -> Plan:
    """All waypoints of the free leg but the ends are a little elsewhere."""
    q = np.array(plan.arms[0].leg("carry").q)
    q[1:-1] += draw.normal(size=q.shape[1]) * 10 ** draw.uniform(-2.5, -0.1)
    return joined(plan, {"carry": q})


def elsewhere(plan: Plan, draw: np.random.Generator) -> Plan:
    """The hand opens at another place."""
    q = np.array(plan.arms[0].leg("carry").q)
    q[-1] += draw.normal(size=q.shape[1]) * 10 ** draw.uniform(-3.5, -0.5)
    return joined(plan, {"carry": q})


def sideways(plan: Plan, draw: np.random.Generator) -> Plan:
    """The way up leans."""
    q = np.array(plan.arms[0].leg("lift").q)
    q[1:] += (
        np.linspace(0.0, 1.0, len(q))[1:, None]
        * draw.normal(size=q.shape[1])
        * 10 ** (draw.uniform(-3.5, -0.5))
    )
    return joined(plan, {"lift": q})


def hurried(plan: Plan, draw: np.random.Generator) -> Plan:
    """A leg takes less time."""
    name = ("lift", "carry")[draw.integers(2)]
    leg = plan.arms[0].leg(name)
    return with_leg(plan, "right", name, t=np.asarray(leg.t) * draw.uniform(0.3, 1.6))


def fuller(plan: Plan, draw: np.random.Generator) -> Plan:
    """The hand holds more."""
    held = ("two", "unknown")[draw.integers(2)]
    return replace(plan, arms=(replace(plan.arms[0], held=held),))


BENDS: tuple[Bend, ...] = (shaken, shifted, elsewhere, sideways, hurried, fuller)


def refusals(cell: Cell, scene: Scene, plan: Plan) -> Iterator[str]:
    """What is wrong with a plan, looked at densely."""
    arm, held = plan.arms[0], HeldAmount(plan.arms[0].held)
    holding = with_held(cell, arm.arm, held)
    content = unseen_content(cell, scene)
    world = World(holding, (), (*content.boxes, *content.others), by_coal=True)
    chain, moves = world.chains[arm.arm], frozenset({arm.arm})
    _, _, fastest = cell.robot.limits(arm.joints)
    for leg in arm.legs[:-1]:
        speeds = np.abs(np.diff(leg.q, axis=0)) / np.diff(leg.t)[:, None]
        if (speeds > 1.05 * fastest * cell.policy.speed).any():
            yield f"{leg.name} is too fast"
    end = chain.pose(arm.leg("carry").q[-1]).translation
    if np.linalg.norm(end - drop_point(cell, held)) > DROPPED + 1e-6:
        yield "opens elsewhere"
    for leg in arm.legs[:-1]:
        phase = LegPhase(moves, {arm.arm: leg.opening})
        first = chain.pose(leg.q[0]).translation
        if leg.name == "lift":
            phase = replace(phase, straight=moves, stirs=moves, below=below(holding, first))
        world.enter(phase)
        for q in between(leg.q):
            gone = chain.pose(q).translation - first
            if leg.name == "lift" and np.hypot(gone[0], gone[1]) > 0.006:
                yield "leans"
            for contact in world.contacts(world.configuration({arm.arm: q})):
                if contact.distance < contact.margin - TOO_NEAR:
                    yield f"{contact.pair} are {contact.distance * 1000:.1f} mm apart"


def below(cell: Cell, p: Floats) -> frozenset[str]:
    still = [body for body in World(cell, (), ()).surroundings.bodies if body.joint == 0]
    shapes = [(body.shape, body.T_joint_body) for body in still]
    are = stand_below(shapes, p, held_reach(cell), cell.bin.T_world_bin)
    return frozenset(body.label for body, is_below in zip(still, are, strict=True) if is_below)


def test_none_of_132_bent_plans_is_proven_that_the_judge_refuses(cell: Cell, plan: Plan) -> None:
    def bend(seed: int) -> Bent:
        bent = BENDS[seed % len(BENDS)](plan, np.random.default_rng([7, seed]))
        return cell, bent.scene, bent

    assert not next(refusals(cell, plan.scene, plan), "")
    accepted, refused = judge_plans(132, bend, refusals)
    assert accepted > 10 and refused > 50, (accepted, refused)


def test_no_part_that_is_held_clear_meets_anything_on_the_way_up(cell: Cell, plan: Plan) -> None:
    draw, lift = np.random.default_rng(5), plan.arms[0].leg("lift")
    part, world = cell.parts[0], World(cell, (), ())
    chain = world.chains["right"]
    still = [
        (coal_shape(body.shape), body.T_joint_body)
        for body in world.surroundings.bodies
        if body.joint == 0
    ]
    pieces = [(coal_shape(piece.shape), piece.T_owner_shape) for piece in part.pieces]
    poses = [chain.pose(lift.at(t)) for t in np.linspace(0.0, lift.seconds, 25)]

    def meets(T_world_part: pin.SE3) -> bool:
        request, result = coal.CollisionRequest(), coal.CollisionResult()
        for shape, T in pieces:
            at = T_world_part * T
            for other, T_other in still:
                result.clear()
                first = coal.Transform3s(at.rotation, at.translation)
                second = coal.Transform3s(T_other.rotation, T_other.translation)
                if coal.collide(shape, first, other, second, request, result):
                    return True
        return False

    clear = 0
    for _ in range(150):
        grasp = part.grasps[draw.integers(len(part.grasps))]
        off = draw.normal(size=3)
        off *= GRIP_ROOM * draw.uniform() / np.linalg.norm(off)
        T_tcp_part = pin.SE3(pin.Quaternion(*_turn(draw)).matrix(), off) * pin.SE3(
            np.eye(3), -np.asarray(grasp.T_part_tcp.translation)
        )
        if meets(poses[0] * T_tcp_part):
            continue
        clear += 1
        assert not any(meets(T * T_tcp_part) for T in poses)
    assert clear > 30


def _turn(draw: np.random.Generator) -> list[float]:
    quaternion = draw.normal(size=4)
    return (quaternion / np.linalg.norm(quaternion)).tolist()


def test_what_hangs_over_a_body_or_leans_is_not_below_it() -> None:
    up, cube = pin.SE3.Identity(), Box(np.array([0.1, 0.1, 0.1]))
    table = (Box(np.array([2.0, 2.0, 0.02])), pose_from_rpy((0.0, 0.0, -0.01)))
    stands = (cube, pose_from_rpy((0.12, 0.0, 0.05)))
    on_it = (Box(np.array([0.08, 0.08, 0.1])), pose_from_rpy((0.12, 0.0, 0.15)))
    shelf = (Box(np.array([0.3, 0.3, 0.02])), pose_from_rpy((0.12, 0.0, 0.21)))
    leans = (cube, pose_from_rpy((-0.12, 0.0, 0.05), (0.2, 0.0, 0.0)))
    ball = (Sphere(0.05), pose_from_rpy((0.0, 0.2, 0.05)))
    shapes = (table, stands, on_it, shelf, leans, ball)
    p = np.array([0.0, 0.0, 0.05])
    found = stand_below(shapes, p, 0.1, up).tolist()
    assert found == [True, True, True, False, False, False]
    edge = (Box(np.array([0.1, 2.0, 0.02])), pose_from_rpy((0.0, 0.0, -0.01)))
    assert stand_below((edge, stands), p, 0.1, up).tolist() == [False, False]
