"""Several plans after one scan: as far as the scan stays true, each in what those before leave."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import workbench.app.picking.row as row_module
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.row import (
    check_picks,
    plan_row,
    prove_row,
)
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import MOST_PICKS
from workbench.model.derived.row_parts import label_in, parts_taken, renumber
from workbench.model.digest import digest_of
from workbench.model.errors import CommandRefused, InputError, JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.message import FoundPart, all_of
from workbench.model.messages.plans import RowEnd
from workbench.model.messages.proofs import ProofText
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.plan import PlanResult
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.planning.collision.world import World
from workbench.planning.kinematics.robot import Kinematics
from workbench.proof.claims.prove import may_have_moved, prove, scene_after

GAP = 0.01

NONE = PlanResult((), None, None, Verdict(Reason.OUT_OF_REACH, Stage.GRASP), {})


def lying(cell, x, y, yaw, **about):
    place = cell.bin.T_world_bin.translation + np.array([x, y, 0.0191])
    return Detection("keyed_cylinder", pose_from_rpy(place, (np.pi / 2, 0.0, yaw)), 0.9, **about)


def asked(cell, parts, picks, **about):
    return plan_row(cell, parts, digest_of(parts), picks=picks, **about)


@pytest.fixture(scope="module")
def stays():
    """Parts stay where they were put."""
    cell = read_cell("yumi")
    return replace(cell, policy=replace(cell.policy, pair_gap=GAP))


@pytest.fixture(scope="module")
def cell(stays):
    """Parts are taken away at once."""
    return replace(stays, arms=tuple(replace(arm, passes_parts_on=True) for arm in stays.arms))


@pytest.fixture(scope="module")
def apart(cell):
    """Four parts, none near another."""
    places = ((-0.05, -0.08, 0.4), (0.05, 0.08, -0.6), (-0.05, 0.04, 1.2), (0.05, -0.05, 0.0))
    return tuple(lying(cell, *place) for place in places)


@pytest.fixture(scope="module")
def row(cell, apart):
    return asked(cell, apart, 4)


def test_all_parts_that_lie_alone_are_taken_in_a_row_each_once(cell, apart, row):
    taken = [parts_taken(row.plan, plan) for plan in row.plans]
    assert len(row.plans) > 1
    assert sorted(number for one in taken for number in one) == [0, 1, 2, 3]
    assert row.row_ends == RowEnd.NO_PART()
    assert row.plan.digest == asked(cell, apart, 1).plan.digest, "the first is as ever"


@pytest.mark.extensive
def test_both_strategies_have_a_row_each_and_either_comes_again_when_asked_for(cell, apart):
    both = asked(cell, apart, 2, strategy="both")
    (other,) = both.beside
    for one in (both, other):
        assert {str(plan.strategy) for plan in one.plans} == {str(one.plan.strategy)}
        alone = asked(cell, apart, 2, strategy=str(one.plan.strategy))
        assert [plan.digest for plan in alone.plans] == [plan.digest for plan in one.plans]
        assert len(one.plans) == 2
    seconds = [sum(plan.cycle_seconds for plan in one.plans) for one in (both, other)]
    assert seconds[0] <= seconds[1], "whole rows are compared"


def test_each_plan_is_proven_in_the_scene_that_those_before_leave(cell, apart, row):
    digest, gone = digest_of(apart), set()
    for plan, proof in [(row.plan, row.proof), *((one.plan, one.proof) for one in row.row)]:
        left = tuple(one for number, one in enumerate(apart) if number not in gone)
        again = prove(cell, Scene(digest, left), plan)
        assert proof.holds and again.digest == proof.digest
        gone |= set(parts_taken(row.plan, plan))
    second = row.row[0].plan
    assert not prove(cell, Scene(digest, apart), second).holds, "parts would be where they were"


def test_one_pick_is_what_it_always_was(cell, apart):
    one, usual = asked(cell, apart, 1), plan_pick(cell, apart, digest_of(apart))
    assert (one.plan.digest, one.row, one.row_ends) == (usual.plan.digest, (), None)


def test_the_same_row_comes_out_again(cell, apart, row):
    again = asked(cell, apart, 4)
    assert [one.digest for one in again.plans] == [one.digest for one in row.plans]


def test_as_many_as_were_asked_for_and_no_reason_why_not_more(cell, apart):
    two = asked(cell, apart, 2, strategy="right")
    assert len(two.plans) == 2 and two.row_ends is None
    three = asked(cell, apart, 3, strategy="right")
    assert [one.digest for one in three.plans[:2]] == [one.digest for one in two.plans]


def corners(cell, plan, one):
    """Where the part of an arm is let go of, (n, 3) [m] in the world."""
    arm, part = cell.arm(one.arm), cell.part(plan.detections[one.detection].part)
    T = Kinematics(cell).tcp_pose(arm, np.asarray(one.leg("place").q[-1])) * one.T_tcp_part
    return part.mesh.points @ T.rotation.T + T.translation


def test_a_part_that_stays_at_its_place_is_in_the_way_of_the_next(stays, apart):
    first = asked(stays, apart, 1, strategy="right").plan
    scene = scene_after(stays, first)
    assert len(scene.detections) == 3 and len(scene.obstacles) == 1
    (box,) = scene.obstacles
    seen = corners(stays, first, first.arms[0]) - box.T_world_box.translation
    seen = seen @ box.T_world_box.rotation
    np.testing.assert_allclose(np.abs(seen).max(axis=0), box.size / 2, atol=1e-6)
    row = asked(stays, apart, 3, strategy="right")
    assert len(row.plans) == 1 and row.row_ends.text is RowEnd.NO_PLAN
    passed_on = replace(stays, arms=tuple(replace(one, passes_parts_on=True) for one in stays.arms))
    assert scene_after(passed_on, first).obstacles == ()


def test_the_other_arm_goes_on_beside_a_part_that_stays(stays, apart):
    first = asked(stays, apart, 1, strategy="right").plan
    scene = scene_after(stays, first)
    plan = plan_pick(
        stays, scene.detections, scene.scan_digest, strategy="left", obstacles=scene.obstacles
    ).plan
    assert prove(stays, scene, plan).holds
    elsewhere = replace(plan, obstacles=())
    told = prove(stays, scene, elsewhere).violations
    assert "leaves out obstacle seen-1" in str(told[0])


def test_a_part_of_unknown_roll_takes_the_room_of_all_its_turns(stays):
    part = stays.part("keyed_cylinder")
    axis = np.array([[0.001, 0.0, 0.002], [0.0, 0.6, 0.8]])
    one = lying(stays, 0.0, 0.0, 0.0, roll_known=False, roll_axis=axis)
    plan = asked(stays, (lying(stays, 0.0, 0.0, 0.0),), 1, strategy="right").plan
    (box,) = scene_after(stays, replace(plan, detections=(one,))).obstacles
    arm = plan.arms[0]
    kinematics, way = Kinematics(stays), np.asarray(arm.leg("place").q[-1])
    T = kinematics.tcp_pose(stays.arm(arm.arm), way) * arm.T_tcp_part
    most = np.zeros(3)
    for angle in np.linspace(0, 2 * np.pi, 400):
        R = pin.exp3(axis[1] * angle)
        points = (part.mesh.points - axis[0]) @ R.T + axis[0]
        world = points @ T.rotation.T + T.translation - box.T_world_box.translation
        most = np.maximum(most, np.abs(world @ box.T_world_box.rotation).max(axis=0))
    assert (most <= box.size / 2 + 1e-9).all()
    np.testing.assert_allclose(most, box.size / 2, rtol=1e-3)


@pytest.fixture(scope="module")
def near(cell):
    """Four parts, of which the second and fourth lie 8 mm from each other."""
    places = ((-0.05, -0.096), (-0.044, 0.101), (0.044, -0.009), (-0.059, 0.028))
    yaws = (1.2, 0.1, -0.8, 0.8)
    parts = tuple(lying(cell, *place, yaw) for place, yaw in zip(places, yaws, strict=True))
    heaps = World(cell, parts).part_ways.heaps(cell.policy.pair_gap)
    assert heaps[1] == heaps[3] and len(set(heaps)) == 3
    return parts


def test_parts_of_a_heap_are_taken_last_and_end_the_row(cell, near):
    row = asked(cell, near, 4, strategy="right")
    taken = [parts_taken(row.plan, plan) for plan in row.plans]
    assert len(taken) == 3 and {number for one in taken[:2] for number in one} == {0, 2}
    ((last,),) = taken[2:]
    other = {1: 4, 3: 2}[last]
    assert row.row_ends == ProofText.MAY_MOVE(stays=FoundPart(other - 1), taken=FoundPart(last))
    told = [one for one in row.candidates if one.detection in (1, 3)]
    assert all(one.verdict.note == VerdictNote.TAKEN_LAST() for one in told)


def test_what_may_move_is_what_the_planner_takes_for_one_heap(cell):
    rng = np.random.default_rng(5)
    found = {True: 0, False: 0}
    plan = asked(cell, (lying(cell, 0.0, 0.0, 0.0),), 1, strategy="right").plan
    for _ in range(40):
        parts = tuple(
            lying(cell, *rng.uniform((-0.06, -0.1), (0.06, 0.1)), rng.uniform(-3, 3))
            for _ in range(3)
        )
        ways = World(cell, parts).part_ways
        near = any(ways.gap(0, other) < GAP for other in (1, 2))
        told = may_have_moved(cell, replace(plan, detections=parts))
        assert (told is not None) == near
        found[near] += 1
    assert min(found.values()) > 5


def test_parts_that_two_arms_take_do_not_end_the_row_for_each_other(cell, apart):
    plan = asked(cell, apart, 1, strategy="alternated").plan
    assert len(plan.arms) == 2
    taken = tuple(plan.detections[one.detection] for one in plan.arms)
    both = replace(
        plan,
        detections=taken,
        arms=tuple(replace(one, detection=k) for k, one in enumerate(plan.arms)),
    )
    wide = replace(cell, policy=replace(cell.policy, pair_gap=1.0))
    assert may_have_moved(wide, both) is None
    assert may_have_moved(wide, plan) is not None


def test_what_is_left_alone_is_left_alone_in_the_whole_row(cell, apart):
    row = asked(cell, apart, 4, strategy="right", avoided={1: "its pick failed"})
    taken = [number for plan in row.plans for number in parts_taken(row.plan, plan)]
    assert sorted(taken) == [0, 2, 3]
    assert row.row_ends.text is RowEnd.NO_PLAN


def test_words_get_the_numbers_of_the_first_plan_and_names_stay(apart, row):
    # Digits of a file may differ in the last place.
    left = tuple(
        replace(one, T_world_part=pin.SE3(T.rotation, T.translation + 1e-12))
        for one in (apart[3], apart[1])
        for T in [one.T_world_part]
    )

    def said(*numbers):
        named = VerdictNote.ALL_TURNS(parts=map(FoundPart, numbers))
        return all_of((named, VerdictNote.SPARE(grasp="part-1")))

    assert renumber(said(0, 1, 98), row.plan, left) == said(3, 1, 98)
    assert [label_in(one, row.plan, left) for one in ("part-1", "finger")] == ["part-4", "finger"]


def test_no_plan_at_all_is_no_row(cell):
    outside = (lying(cell, 5.0, 0.0, 0.0), lying(cell, 6.0, 0.0, 0.0))
    row = asked(cell, outside, 3)
    assert (row.plan, row.plans, row.row) == (None, (), ())


@pytest.mark.parametrize("picks", [0, MOST_PICKS + 1])
def test_too_many_picks_or_none_are_refused(cell, picks):
    with pytest.raises(InputError, match=f"by 1 to {MOST_PICKS} picks, not {picks}"):
        check_picks(cell, picks)


def test_a_cell_that_does_not_say_what_moves_has_no_rows(cell, apart):
    plain = replace(cell, policy=replace(cell.policy, pair_gap=0.0))
    with pytest.raises(InputError, match=r"need a pair_gap_mm in \[policy\]"):
        asked(plain, apart, 2)
    check_picks(plain, 1)


def test_a_row_is_proven_again_as_it_was_planned(cell, apart, row):
    again = prove_row(cell, row.plans, detections=apart)
    assert [one.proof.digest for one in again] == [
        row.proof.digest,
        *(one.proof.digest for one in row.row),
    ]
    assert all(one.proof.holds for one in again)


def test_plans_in_another_order_or_twice_are_not_proven(cell, row):
    first, second = row.plans
    for plans in ((second, first), (first, first)):
        *_, last = prove_row(cell, plans)
        assert not last.proof.holds


def test_the_second_plan_is_not_proven_in_the_scan_of_the_first(cell, apart, row):
    """It would still have the parts that the first has taken."""
    first, second = row.plan, row.row[0].plan
    assert len(second.detections) < len(first.detections)
    other = replace(second, detections=first.detections, obstacles=first.obstacles)
    _, proven = prove_row(cell, [first, other], detections=apart)
    problems = " ".join(str(violation.problem) for violation in proven.proof.violations)
    assert "is not in the scan" in problems


def test_after_a_plan_that_does_not_hold_nothing_is_proven(cell, apart, row):
    (only,) = prove_row(cell, row.plans, detections=apart[:3])
    assert not only.proof.holds


def test_a_plan_does_not_follow_one_that_takes_a_part_of_a_heap(cell, near):
    first = asked(cell, near, 1, strategy="right", avoided={0: "later", 2: "later"}).plan
    assert first.arms[0].detection in (1, 3)
    scene = scene_after(cell, first)
    second = plan_pick(cell, scene.detections, scene.scan_digest, strategy="right").plan
    with pytest.raises(CommandRefused, match=r"plan 2 of the row cannot follow.* may move"):
        prove_row(cell, (first, second))


def told_by(monkeypatch, cell, parts, picks, *, is_enough, **about):
    """What a planning tells of its progress in which every look goes from nothing to its end."""
    told: list[float] = []

    def look(cell, detections, scan_digest, *, report, **asked):
        for done in (0.0, 0.5, 1.0):
            report(done, "looking")
        return plan_pick(cell, detections, scan_digest, **asked) if is_enough(len(told)) else NONE

    monkeypatch.setattr(row_module, "plan_pick", look)
    asked(cell, parts, picks, report=lambda done, note: told.append(done), **about)
    return told


def test_progress_never_falls_and_is_full_with_the_last_plan_alone(monkeypatch, cell, apart):
    told = told_by(monkeypatch, cell, apart, 2, is_enough=lambda count: True)
    assert told == sorted(told) and len(told) == 6
    assert [round(one, 3) for one in told] == [0.0, 0.25, 0.5, 0.5, 0.75, 1.0]


def test_progress_leaves_room_for_a_second_look_with_less_around(monkeypatch, cell, apart):
    wall = Obstacle(pose_from_rpy((5.0, 5.0, 0.0), (0, 0, 0)), (0.1, 0.1, 0.1))
    told = told_by(monkeypatch, cell, apart, 1, is_enough=lambda count: count > 3, unseen=(wall,))
    assert told == sorted(told) and len(told) == 6
    assert told[2] == told[3] < 0.7 and told[5] == pytest.approx(1.0)


def test_planning_tells_how_many_hands_it_has_tried_and_is_full_at_its_end_alone(cell, apart):
    told: list[tuple[float, str]] = []
    result = plan_pick(
        cell, apart[:1], "a scan", report=lambda done, note: told.append((done, note))
    )
    shares = [done for done, _ in told]
    assert shares == sorted(shares) and max(shares) < 1.0
    count = len(result.candidates)
    notes = [str(note) for _, note in told]
    assert notes[: count + 1 : count] == [f"checking hand 1 of {count}", f"candidate 1 of {count}"]
    assert notes[count - 1] == f"checking hand {count} of {count}"


def test_planning_ends_between_two_hands(cell, apart):
    looks, told = iter(range(100)), list[str]()
    with pytest.raises(JobCancelled):
        plan_pick(
            cell,
            apart,
            "a scan",
            report=lambda done, note: told.append(str(note)),
            cancelled=lambda: next(looks) > 1,
        )
    assert [note.split(" of ")[0] for note in told] == ["checking hand 1", "checking hand 2"]
