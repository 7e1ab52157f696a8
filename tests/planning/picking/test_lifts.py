"""Ways out of the bin, and fingers that arrive less open where there is no room."""

from dataclasses import replace

import numpy as np
import pytest
from shipped import without_search

from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import RUBS, Pick, Reason, Stage
from workbench.model.cell import LIFT_NAMES, Cell, LiftName
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.scan import Detection, Obstacle
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.collision.world import World
from workbench.planning.picking import resolve
from workbench.planning.picking.lifts import AUTHORED, lifts
from workbench.planning.picking.propose import propose
from workbench.proof.claims.prove import prove


@pytest.fixture(scope="module")
def cell():
    return without_search(read_cell("yumi"))


def by(cell: Cell, **policy) -> Cell:
    """The cell with a policy that is kept to, also where no plan comes out."""
    return replace(cell, policy=replace(cell.policy, as_needed=False, **policy))


def lying(cell: Cell, x: float, y: float) -> Detection:
    """A cylinder flat on the floor, along x."""
    T = cell.bin.T_world_bin * pose_from_rpy((x, y, 0.019), (0, np.pi / 2, 0))
    return Detection("keyed_cylinder", T)


def ways(cell: Cell, one: Detection):
    candidate = judge(cell, (one,))[0]
    return list(lifts(World(cell, (one,)), candidate, candidate.T_world_tcp))


def test_by_default_there_is_the_leaning_lift_alone(cell):
    only = by(cell, lifts=("leaning",))
    ((name, way),) = ways(only, lying(only, 0.0, 0.1))
    assert name == "leaning"
    up = way / np.linalg.norm(way)
    assert np.rad2deg(np.arccos(up[2])) == pytest.approx(25.0)
    assert up[1] < 0, "it leans to the middle"


def test_lifts_come_in_the_order_of_the_policy_and_none_twice(cell):
    every = by(cell, lifts=LIFT_NAMES)
    found = ways(every, lying(every, 0.0, 0.1))
    names = list(dict.fromkeys(name for name, _ in found))
    assert names == [name for name in LIFT_NAMES if name in names]
    assert {"leaning", "up", "around"} <= set(names)
    units = np.array([way / np.linalg.norm(way) for _, way in found])
    alike = units @ units.T - np.eye(len(units))
    assert alike.max() < np.cos(np.deg2rad(3.9))
    assert units[:, 2].min() > 0.4, "every lift goes up"


def test_the_way_off_the_wall_leads_away_from_the_nearest_one(cell):
    off = by(cell, lifts=("off-wall",))
    ((_, way),) = ways(off, lying(off, 0.0, 0.13))
    assert way[1] < 0 and abs(way[0]) < 1e-9


def test_where_there_is_no_wall_the_way_off_it_leads_straight_up(cell):
    table = replace(cell, bin=replace(cell.bin, has_walls=False))
    off = by(table, lifts=("off-wall",))
    ((_, way),) = ways(off, lying(off, 0.0, 0.13))
    assert way == pytest.approx([0.0, 0.0, off.policy.lift_length])


def test_a_grasp_that_says_how_to_go_out_has_no_other_way(cell):
    every = by(cell, lifts=LIFT_NAMES)
    one = lying(every, 0.0, 0.0)
    candidate = judge(every, (one,))[0]
    authored = replace(candidate.grasp, retreat=np.array([0.0, 0.0, -1.0]), retreat_length=0.08)
    candidate = replace(candidate, grasp=authored)
    ((name, way),) = lifts(World(every, (one,)), candidate, candidate.T_world_tcp)
    assert name == AUTHORED and np.linalg.norm(way) == pytest.approx(0.08)


@pytest.fixture(scope="module")
def heap(cell):
    return drop_parts(cell.parts[:1] * 10, cell.bin, seed=31)


def test_more_lifts_take_what_one_takes_and_more(cell, heap):
    def good(changed: Cell):
        return {
            (one.detection, one.grasp.name, one.arm)
            for one in judge(changed, heap)
            if one.verdict.is_ok
        }

    one, every = good(by(cell, lifts=("leaning",))), good(by(cell, lifts=LIFT_NAMES))
    assert one < every


def test_looking_at_the_hand_alone_refuses_nothing_that_works(cell, heap, monkeypatch):
    every = by(cell, lifts=LIFT_NAMES)
    leaning = tuple(
        replace(one, tilt=np.deg2rad(30.0), name=f"leaning-{one.name}")
        for one in every.parts[0].grasps[:4]
    )
    library = replace(every.parts[0].library, entries=leaning)
    every = replace(every, parts=(replace(every.parts[0], library=library),))

    def good():
        return [
            (one.detection, one.grasp.name, one.arm, one.verdict.note)
            for one in judge(every, heap)
            if one.verdict.is_ok
        ]

    quick = good()
    monkeypatch.setattr(
        resolve,
        "find_lifts_clear_for_part_and_hand",
        lambda *args, most=99: (list(lifts(*args)), None),
    )
    monkeypatch.setattr(
        resolve, "find_lifts_clear_for_part", lambda *args: (list(lifts(*args)), None)
    )
    assert quick and quick == good()


def test_the_verdict_tells_lift_and_opening_and_the_proof_agrees(cell, heap):
    eager = by(cell, lifts=LIFT_NAMES, least_air=0.0015)
    result = plan_pick(eager, heap, "test")
    good = [one for one in result.candidates if one.verdict.is_ok]
    assert good and all(one.verdict.note.mentions(VerdictNote.LIFT) for one in good)
    assert all(one.verdict.note.mentions(VerdictNote.FINGERS) for one in good)
    assert result.plan is not None
    assert prove(eager, result.plan.scene, result.plan).holds


def test_fingers_arrive_less_open_only_where_there_is_no_room(cell):
    slim, rolled = by(cell, least_air=0.0015), pose_from_rpy((0, 0, 0), (0, 0, np.pi))
    # Rolled so that a grasp points straight down.
    one = Detection("keyed_cylinder", lying(cell, 0.0, 0.0).T_world_part * rolled)
    # Faces 24.5 mm from the axis: fingers of 6 mm fit in between when open 33 mm, not 40 mm.
    sides = tuple(
        Obstacle(
            cell.bin.T_world_bin * pose_from_rpy((0, side * 0.0295, 0.015)),
            np.array([0.1, 0.01, 0.03]),
        )
        for side in (1, -1)
    )

    def openings(changed: Cell, obstacles: tuple[Obstacle, ...]) -> set[float]:
        judged = judge(changed, (one,), obstacles=obstacles)
        return {round(c.grasp.opening, 4) for c in judged if c.verdict.is_ok}

    assert openings(cell, ()) == openings(slim, ()) == {0.04}
    assert openings(by(cell, least_air=None), sides) == set()
    assert openings(slim, sides) == {0.033}


def test_a_proof_refuses_fingers_less_open_than_the_policy_allows(cell):
    slim = by(cell, least_air=0.0015)
    plan = plan_pick(slim, (lying(slim, 0.0, 0.0),), "test").plan
    assert plan is not None
    (arm,) = plan.arms

    def opened(opening: float):
        legs = tuple(leg if leg.holding else replace(leg, opening=opening) for leg in arm.legs)
        changed = replace(plan, arms=(replace(arm, legs=legs),))
        return prove(slim, changed.scene, changed)

    assert opened(0.034).holds
    assert not opened(0.031).holds
    assert not opened(0.045).holds


def test_a_blocked_lift_states_no_distance_that_nobody_has_measured(cell, heap):
    found = [
        one.verdict
        for one in judge(by(cell, lifts=LIFT_NAMES), heap)
        if one.verdict.reason is Reason.EXTRACT_BLOCKED
        and one.verdict.note is not None
        and one.verdict.note.text in (VerdictNote.LIFTS_TRIED, VerdictNote.LIFT_ENDS)
    ]
    assert any(one.note.text is VerdictNote.LIFTS_TRIED for one in found)
    assert all(one.pair is not None and one.distance is None for one in found)
    assert not any(", 0.0 mm" in str(one) for one in found)


@pytest.mark.parametrize("names", [("leaning",), LIFT_NAMES])
def test_a_lift_of_no_length_is_looked_at_without_a_division_by_zero(cell, names):
    """It is part of no plan: the part would still touch the floor."""
    still = by(cell, lifts=names, lift_length=0.0)
    with np.errstate(all="raise"):
        judged = judge(still, (lying(still, 0.0, 0.0),))
    assert {one.verdict.stage for one in judged} >= {Stage.EXTRACT}
    assert not any(one.verdict.is_ok for one in judged)


def test_ways_that_lead_away_come_before_those_that_rub_each_in_the_order_of_the_policy(cell):
    named = ("up", "off-wall", "around")
    every = by(cell, lifts=named)
    half = float(cell.bin.size[1]) / 2
    free, against = lying(every, 0.0, 0.0), lying(every, 0.0, half - 0.0195)
    assert [name for name, _ in ways(every, free)][:2] == ["up", "off-wall"]
    found = ways(every, against)
    gain = World(every, (against,)).part_ways.gain
    do_rub = [gain(0, way) < RUBS for _, way in found]
    assert True in do_rub and do_rub == sorted(do_rub)
    assert found[0][0] == "off-wall"
    rubbing = [name for (name, _), rubs in zip(found, do_rub, strict=True) if rubs]
    assert rubbing[0] == "up"
    again = ways(every, against)
    assert [name for name, _ in again] == [name for name, _ in found]
    assert all(np.array_equal(a, b) for (_, a), (_, b) in zip(again, found, strict=True))


def test_around_leans_to_twelve_sides_by_all_and_by_half_of_the_angle(cell):
    only = by(cell, lifts=("around",))
    found = np.array([way for _, way in ways(only, lying(only, 0.0, 0.0))])
    leans = np.rad2deg(np.arccos(found[:, 2] / np.linalg.norm(found, axis=1)))
    assert [round(lean, 3) for lean in sorted(leans)] == [12.5] * 12 + [25.0] * 12


def test_a_part_that_stands_against_something_is_taken_by_a_lift_that_leads_away_from_it(cell):
    one = lying(cell, 0.0, 0.0)
    end = float(cell.parts[0].mesh.points[:, 2].max())
    at = cell.bin.T_world_bin * pose_from_rpy((end + 0.0055, 0.0, 0.003))
    block = Obstacle(at, np.array([0.01, 0.02, 0.006]))

    def rubbing(*names: LiftName) -> set[bool]:
        world = World(by(cell, lifts=names), (one,), (block,))
        found = [resolve.resolve(world, candidate, seed=0) for candidate in propose(world)]
        return {pick.rubs for pick in found if isinstance(pick, Pick)}

    assert rubbing("up", "around") == {False}
    assert rubbing("up", "back") == {True}


def test_a_part_that_is_caught_is_taken_by_any_way_on_which_it_comes_off_and_proven(cell):
    """A bar reaches over one end of it: nothing that leans to the usual sides leads past that."""
    one = lying(cell, 0.0, 0.0)
    T = cell.bin.T_world_bin * pose_from_rpy((0.035, 0.009, 0.045))
    bar = Obstacle(T, np.array([0.03, 0.006, 0.01]))
    usual, more = (
        by(cell, lifts=names, least_air=0.0015) for names in (LIFT_NAMES[:-1], LIFT_NAMES)
    )
    before, now = (plan_pick(each, (one,), "test", obstacles=(bar,)) for each in (usual, more))
    assert before.plan is None
    assert now.plan is not None and now.proof is not None and now.proof.holds
    assert any("lift any" in str(c.verdict.note) for c in now.candidates if c.verdict.is_ok)


def test_ways_on_which_a_part_is_pushed_into_something_come_last(cell):
    every, one = by(cell, lifts=LIFT_NAMES), lying(cell, 0.0, 0.0)
    beside = cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0245, 0.019))
    wall = Obstacle(beside, np.array([0.2, 0.01, 0.038]))
    world = World(every, (one,), (wall,))
    candidate, part_ways = judge(every, (one,))[0], world.part_ways
    found = [way for _, way in lifts(world, candidate, candidate.T_world_tcp)]
    pushed = [part_ways.is_pushed(0, way) for way in found]
    assert True in pushed and pushed == sorted(pushed)
    # The collar of 19 mm is 0.5 mm off the wall, of which half is kept.
    assert [part_ways.gain(0, way) < -0.00025 for way in found] == pushed
