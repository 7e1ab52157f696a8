"""The path of a scanner to its view, bent: none is proven that an independent judge refuses."""

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import on_arm_cell, with_lower_view
from bending import with_leg
from bent_plans import TOO_NEAR, Bent, between, judge_plans, objections

from workbench.app.empty_hand.view_plan import plan_view
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.derived.by_view import with_view as chosen_view
from workbench.model.geometry import Box, Floats, Solid, pose_from_rpy
from workbench.model.load import Loads
from workbench.model.plan import Plan, Strategy
from workbench.model.robot import ScanPosture
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.proof.claims.prove import prove, scene_after
from workbench.proof.claims.scene import unseen_bin

ARM = "left"


@pytest.fixture(scope="module")
def cell() -> Cell:
    return on_arm_cell()


@pytest.fixture(scope="module")
def plan(cell: Cell) -> Plan:
    made = plan_view(cell).plan
    assert made is not None
    return made


def with_view(cell: Cell, q: Floats) -> Cell:
    """The cell with another view, for which the plan is to be."""
    carrier = cell.scanner.on_arm
    assert carrier is not None
    arms = tuple(replace(arm, home=q) if arm.name == ARM else arm for arm in cell.arms)
    other = replace(carrier, view=ScanPosture("other", q))
    return replace(cell, arms=arms, scanner=replace(cell.scanner, on_arm=other))


def with_housing(cell: Cell, size: Floats, at: Floats) -> Cell:
    carrier = cell.scanner.on_arm
    assert carrier is not None
    post = Solid("camera", Box(size), pin.SE3(np.eye(3), at))
    return replace(cell, scanner=replace(cell.scanner, on_arm=replace(carrier, housing=(post,))))


def on(cell: Cell, plan: Plan) -> Plan:
    """The plan, said to be for that cell and its bin."""
    return replace(plan, cell_digest=cell.digest, obstacles=(unseen_bin(cell),))


def ended(plan: Plan, shift: float, row: int) -> Plan:
    q = np.array(plan.arm(ARM).leg("view").q)
    q[row, 2] += shift
    return with_leg(plan, ARM, "view", q=q, t=plan.arm(ARM).leg("view").t * 3)


def test_the_plan_is_proven_and_leaves_the_scene_as_it_was(cell: Cell, plan: Plan) -> None:
    assert objections(cell, plan) == ""
    after = scene_after(cell, plan)
    assert not after.detections and after.obstacles == plan.obstacles


def test_it_ends_at_the_view_of_the_cell_and_begins_at_its_home(cell: Cell, plan: Plan) -> None:
    off = np.deg2rad(0.02)
    for row in (0, -1):
        assert "does not start where the arm stands" in objections(cell, ended(plan, off, row))
    carrier = cell.scanner.on_arm
    assert carrier is not None
    other = with_view(cell, carrier.view.q + off)
    assert "does not start where the arm stands" in objections(other, on(other, plan))


def test_the_way_back_begins_at_the_view_of_the_cell_and_ends_at_its_home(cell: Cell) -> None:
    back, off = plan_view(cell, view="home").plan, np.deg2rad(0.02)
    assert back is not None and objections(cell, back) == ""
    for row in (0, -1):
        assert "does not start where the arm stands" in objections(cell, ended(back, off, row))


def test_a_path_from_another_view_ends_at_the_view_that_is_chosen(cell: Cell) -> None:
    both = with_lower_view(cell)
    low = chosen_view(both, "low")
    plan = plan_view(low, start="bin").plan
    assert plan is not None and objections(low, plan) == ""
    start = np.asarray(plan.arm(ARM).leg("view").q)[0]
    assert np.abs(start - both.arm(ARM).home).max() < 1e-4
    off = np.deg2rad(0.02)
    for row in (0, -1):
        assert "does not start where the arm stands" in objections(low, ended(plan, off, row))
    # The same path in the cell by its first view: it leads from there to a view that is not chosen.
    assert "does not start where the arm stands" in objections(both, on(both, plan))
    # A single view knows no other one to begin at.
    carrier = low.scanner.on_arm
    assert carrier is not None
    alone = replace(low, scanner=replace(low.scanner, on_arm=replace(carrier, other_views=())))
    assert "does not start where the arm stands" in objections(alone, on(alone, plan))


def test_a_path_that_ends_where_it_begins_is_refused(cell: Cell, plan: Plan) -> None:
    leg = plan.arm(ARM).leg("view")
    there, back = np.asarray(leg.q), np.asarray(leg.q)[::-1]
    for q in (np.vstack([there, back[1:]]), np.vstack([back, there[1:]])):
        round_trip = with_leg(plan, ARM, "view", q=q, t=np.arange(len(q)) * 60.0)
        assert "does not start where the arm stands" in objections(cell, round_trip)


def test_a_plan_for_another_scan_is_refused(cell: Cell, plan: Plan) -> None:
    other = replace(plan, scan_digest="0" * 64)
    said = "\n".join(map(str, prove(cell, plan.scene, other).violations))
    assert "made for another scan" in said


def test_a_view_that_was_changed_makes_another_cell(cell: Cell, plan: Plan) -> None:
    carrier = cell.scanner.on_arm
    assert carrier is not None
    other = with_view(cell, carrier.view.q + np.deg2rad(1.0))
    assert "another cell" in objections(other, plan)


def test_a_housing_that_goes_through_a_wall_is_found(cell: Cell, plan: Plan) -> None:
    long = with_housing(cell, np.array([0.02, 0.02, 0.7]), np.array([0.0, -0.1, 0.35]))
    assert "left camera" in objections(long, on(long, plan))


def test_the_whole_bin_is_kept_clear_of(cell: Cell, plan: Plan) -> None:
    (box,) = plan.obstacles
    low = Obstacle(box.T_world_box, np.asarray(box.size) * [1, 1, 0.9])
    for some in ((), (low,)):
        assert "whole bin" in objections(cell, replace(plan, obstacles=some))


def test_it_takes_no_part_and_moves_no_other_arm(cell: Cell, plan: Plan) -> None:
    (arm,) = plan.arms
    found = Detection(cell.parts[0].name, pose_from_rpy((0.4, 0.0, 0.02)))
    other = replace(arm, arm="right", joints=cell.arm("right").joints)
    for bent in (
        replace(plan, detections=(found,)),
        replace(plan, arms=(replace(arm, grasp="side"),)),
        replace(plan, arms=(replace(arm, station="table"),)),
        replace(plan, arms=(arm, other), strategy=Strategy.ALTERNATED),
        replace(plan, arms=(other,), strategy=Strategy.single("right")),
    ):
        assert objections(cell, bent)
    assert "carries no scanner" in objections(cell, replace(plan, arms=(other,)))


def test_a_cell_whose_scanner_stands_has_no_such_plan(plan: Plan) -> None:
    standing = read_cell("yumi")
    assert "carries no scanner" in objections(standing, on(standing, plan))


def test_its_legs_loads_times_and_fingers_are_checked(cell: Cell, plan: Plan) -> None:
    (arm,) = plan.arms
    leg, loads = arm.leg("view"), arm.loads
    assert loads is not None
    for what, bent in (
        ("the legs are not", replace(plan, arms=(replace(arm, legs=(leg, leg)),))),
        ("in the hand", with_leg(plan, ARM, "view", holding=True)),
        ("linear", with_leg(plan, ARM, "view", motion="linear")),
        ("outside the stroke", with_leg(plan, ARM, "view", opening=0.2)),
        ("", with_leg(plan, ARM, "view", t=leg.t / 2)),
        ("", replace(plan, arms=(replace(arm, loads=None),))),
        ("", replace(plan, arms=(replace(arm, loads=Loads(loads.tool, loads.tool)),))),
    ):
        said = objections(cell, bent)
        assert said and what in said


# -- generated --------------------------------------------------------------------------------


BentCell = tuple[Cell, Plan]
Bend = Callable[[Cell, Plan, np.random.Generator], BentCell]


def moved_waypoint(cell: Cell, plan: Plan, draw: np.random.Generator) -> BentCell:
    leg = plan.arm(ARM).leg("view")
    q, row = np.array(leg.q), draw.integers(0, len(leg.q))
    way = draw.normal(size=q.shape[1])
    q[row] += way / np.linalg.norm(way) * np.deg2rad(10 ** draw.uniform(-1, 1.8))
    rounded = cell.controller.motion.rounded(q)
    return cell, with_leg(plan, ARM, "view", q=rounded, t=leg.t * 5)


def straight(cell: Cell, plan: Plan, draw: np.random.Generator) -> BentCell:
    leg = plan.arm(ARM).leg("view")
    stays = draw.random(len(leg.q)) < 0.5
    stays[[0, -1]] = True
    return cell, with_leg(plan, ARM, "view", q=leg.q[stays], t=leg.t[stays] * 5)


def grown_housing(cell: Cell, plan: Plan, draw: np.random.Generator) -> BentCell:
    size = np.array([0.02, 0.02, draw.uniform(0.05, 0.5)])
    at = np.array([draw.uniform(-0.1, 0.1), draw.uniform(-0.15, 0.0), size[2] / 2])
    other = with_housing(cell, size, at)
    return other, on(other, plan)


def other_view(cell: Cell, plan: Plan, draw: np.random.Generator) -> BentCell:
    carrier = cell.scanner.on_arm
    assert carrier is not None
    q = carrier.view.q + draw.normal(size=len(carrier.view.q)) * 10 ** draw.uniform(-6, -1)
    other = with_view(cell, np.asarray(q))
    return other, on(other, plan)


def raised_bin(cell: Cell, plan: Plan, draw: np.random.Generator) -> BentCell:
    size = np.asarray(cell.bin.size) + [0.0, 0.0, draw.uniform(0.0, 0.3)]
    other = replace(cell, bin=replace(cell.bin, size=size))
    return other, on(other, plan)


def thing_in_the_way(cell: Cell, plan: Plan, draw: np.random.Generator) -> BentCell:
    at = np.asarray(cell.scanner.T_world_scanner.translation) + draw.normal(0, 0.15, 3)
    box = Obstacle(pin.SE3(np.eye(3), at), draw.uniform(0.02, 0.2, 3))
    return cell, replace(plan, obstacles=(*plan.obstacles, box))


BENDS: tuple[Bend, ...] = (
    moved_waypoint,
    straight,
    grown_housing,
    other_view,
    raised_bin,
    thing_in_the_way,
)


def refusals(cell: Cell, scene: Scene, plan: Plan) -> Iterator[str]:
    """What speaks against a plan, by the planner's own world and without the proof."""
    del scene  # the bends change none
    carrier, leg = cell.scanner.on_arm, plan.arm(ARM).leg("view")
    assert carrier is not None
    step = cell.controller.motion.quantum
    ends = np.vstack([leg.q[0] - carrier.home, leg.q[-1] - carrier.view.q])
    if np.abs(ends).max() > step:
        yield "it goes from elsewhere, or to elsewhere"
    lower, upper, velocity = cell.robot.limits(cell.arm(ARM).joints)
    if np.any(leg.q < lower - 1e-9) or np.any(leg.q > upper + 1e-9):
        yield "a joint is beyond its limits"
    speeds = np.abs(np.diff(leg.q, axis=0)) / np.diff(leg.t)[:, None]
    # A corner that is rounded is shorter than the way to it and back.
    if np.any(speeds > velocity * cell.policy.speed / (1 - cell.zone) * 1.01):
        yield "a joint is too fast"
    world = World(cell, (), plan.obstacles)
    world.enter(LegPhase(frozenset({ARM}), {ARM: leg.opening}))
    for q in between(leg.q, np.deg2rad(0.5)):
        for contact in world.contacts(world.configuration({ARM: q})):
            if contact.distance < contact.margin - TOO_NEAR:
                yield f"{contact.pair} are {contact.distance * 1000:.1f} mm apart"
                return


def test_no_generated_plan_is_proven_that_the_judge_refuses(cell: Cell, plan: Plan) -> None:
    def bend(seed: int) -> Bent:
        made, draw = BENDS[seed % len(BENDS)], np.random.default_rng([7, seed])
        bent_cell, bent = made(cell, plan, draw)
        return bent_cell, bent.scene, bent

    accepted, refused = judge_plans(300, bend, refusals)
    assert accepted > 30 and refused > 100, (accepted, refused)
