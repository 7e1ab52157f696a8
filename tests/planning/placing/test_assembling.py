"""Planning puts a part onto the one it belongs to, and nowhere else."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from assembling import (
    assembly_cell,
    insertion,
    moved,
    placed_bolt,
    standing_spacer,
    turn,
    with_insertion,
)

from workbench.app.picking.pipeline import plan_pick
from workbench.model.candidate import Reason
from workbench.model.derived.assembling import rest_pose
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.cells import KitText
from workbench.model.messages.verdicts import VerdictNote
from workbench.planning.collision.legs import phase_of, stretches
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.placing.assembling import arm_placing

BORE, SHANK = 0.009, 0.008


@pytest.fixture(scope="module")
def cell():
    return assembly_cell()


def planned(cell, obstacles, **asked):
    return plan_pick(cell, (standing_spacer(cell),), "scan", obstacles=obstacles, **asked)


@pytest.fixture(scope="module")
def result(cell):
    return planned(cell, placed_bolt(cell))


def poses(cell, plan, leg: str, between: int = 40) -> list[pin.SE3]:
    """Where the spacer is on a leg, in the frame of the bolt, seen often."""
    ((arm_plan,), (bolt,)) = plan.arms, plan.obstacles
    chain, q = chain_of(cell, cell.arm(arm_plan.arm)), np.asarray(arm_plan.leg(leg).q)
    at = np.linspace(0, len(q) - 1, between)
    rows = np.array([np.interp(at, np.arange(len(q)), column) for column in q.T]).T
    return [rest_pose(cell, bolt).actInv(chain.pose(row) * arm_plan.T_tcp_part) for row in rows]


def test_a_spacer_goes_straight_over_its_bolt_and_ends_in_its_seat(cell, result):
    assert result.proof is not None and result.proof.holds
    way, asked = poses(cell, result.plan, "place"), insertion(cell)
    off_axis = [float(np.hypot(*T.translation[:2])) for T in way]
    # The bore is a hexagon as wide across its flats, so a circle of this radius goes through it.
    assert max(off_axis) < BORE - SHANK - asked.clearance
    heights = [float(T.translation[2]) for T in way]
    assert heights[0] - heights[-1] == pytest.approx(asked.length, abs=1e-3)
    assert heights[-1] == pytest.approx(asked.position[2], abs=3e-4)
    assert (np.diff(heights) < 0).all()
    assert all(abs(T.rotation[2, 2]) > np.cos(0.005) for T in way)


def test_the_bolt_is_in_the_way_of_all_other_legs(cell, result):
    plan = result.plan
    world = World(cell, plan.detections, plan.obstacles)
    (arm_plan,) = plan.arms
    columns, base = world.kinematics.columns[arm_plan.arm], world.configuration({})
    for stretch in stretches(plan):
        ((_, leg),) = stretch.runs
        world.enter(stretch.phase)
        q = base.copy()
        q[columns] = leg.q[-1]
        met = [contact.pair for contact in world.contacts(q) if "bolt" in contact.pair]
        assert met == [], leg.name
        world.enter(replace(stretch.phase, inserts=frozenset()))
        met = [set(contact.pair) for contact in world.contacts(q) if "bolt" in contact.pair]
        assert met == ([{"bolt", "part-1"}] if leg.name == "place" else []), leg.name
    phase = phase_of([(arm_plan, "return", arm_plan.leg("return").opening)])
    assert phase.inserts == frozenset()


@pytest.mark.parametrize(
    "T_part", [turn("z", 25.0), pose_from_rpy((0.004, -0.003, 0.0), (0.0, 0.0, 0.1))]
)
def test_the_seat_goes_along_with_where_the_bolt_stands(cell, T_part):
    there = tuple(moved(cell, box, T_part) for box in placed_bolt(cell))
    result = planned(cell, there)
    assert result.proof is not None and result.proof.holds, str(result.verdict)
    assert np.hypot(*poses(cell, result.plan, "place")[-1].translation[:2]) < 3e-4


def test_nothing_is_put_where_no_base_stands_or_where_one_is_assembled_already(cell):
    (bolt,) = placed_bolt(cell)
    missing = planned(cell, ())
    assert missing.plan is None and missing.verdict.reason is Reason.NO_PLACE
    assert missing.verdict.note == VerdictNote.NO_BASE(base="bolt")
    unsure = planned(cell, (replace(bolt, part="", T_world_put=None),))
    assert unsure.verdict.note == VerdictNote.NO_BASE(base="bolt")
    world = World(cell, (standing_spacer(cell),), (bolt, replace(bolt, part="spacer")))
    refused = arm_placing(world, cell.arms[0], 0)
    assert refused.note == KitText.HAS_ENOUGH(part="spacer")
    unseen = (replace(standing_spacer(cell), roll_known=False),)
    refused = arm_placing(World(cell, unseen, (bolt,)), cell.arms[0], 0)
    assert refused.note == VerdictNote.PLACE_NEEDS_ROLL()


def test_without_the_recipe_places_are_those_of_the_arm(cell):
    plain = replace(with_recipe(cell, 0), recipe=0)
    world = World(plain, (standing_spacer(plain),), placed_bolt(cell))
    assert arm_placing(world, plain.arms[0], 0) is plain.arms[0]


@pytest.mark.parametrize(
    "changes",
    [
        {"position": (0.0, 0.0, -0.0155)},  # in the head
        {"along": (-1.0, 0.0, 0.0)},  # through the shank
    ],
)
def test_an_insertion_that_is_not_possible_is_no_place(cell, changes):
    result = planned(with_insertion(cell, **changes), placed_bolt(cell))
    assert result.plan is None and result.verdict.reason is Reason.NO_PLACE


@pytest.mark.parametrize(
    "changes",
    [{"clearance": 0.0012}, {"length": 0.05}],
    ids=["more than there is between bore and shank", "begins around the tip"],
)
def test_what_keeps_the_two_parts_from_coming_together_is_named(cell, changes):
    result = planned(with_insertion(cell, **changes), placed_bolt(cell))
    assert result.plan is None and result.verdict.reason is Reason.NO_PLACE
    met = [set(one.verdict.pair or ()) for one in result.candidates]
    assert {"part-1", "bolt"} in met
