"""What stands in the way of a whole bin, and one change for many of its parts."""

from dataclasses import replace

import numpy as np
import pytest
from bending import with_grasps
from shipped import without_search

from workbench.app.picking.judging import judge
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import LIFT_NAMES
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.grasps import FixText
from workbench.model.scan import Detection, Obstacle
from workbench.planning.picking.nearest_fix import Fixes, nearest_fix
from workbench.planning.picking.whole_bin import blockers, common_fixes


@pytest.fixture(scope="module")
def deep(cell, detections):
    """Every grasp taken 9 mm deeper: the fingers reach the floor."""
    deep = with_grasps(
        cell, lambda g: replace(g, T_part_tcp=g.T_part_tcp * pose_from_rpy((0, 0, 0.009)))
    )
    return deep, judge(deep, detections)


def test_what_refuses_most_comes_first_and_nobody_is_counted_twice(deep):
    cell, candidates = deep
    rows = blockers(cell, candidates)
    assert rows[0].label == "bin_floor" and rows[0].parts == (0, 1)
    counts = [row.candidates for row in rows]
    assert counts == sorted(counts, reverse=True)
    told = [one for one in candidates if not one.verdict.is_ok and one.verdict.pair is not None]
    assert sum(counts) == len(told)
    assert all(sum(count for _, count in row.reasons) == row.candidates for row in rows)


def test_one_change_takes_all_parts_that_nothing_takes(deep, detections):
    cell, candidates = deep
    assert not any(one.verdict.is_ok for one in candidates)
    (change, parts), *rest = common_fixes(cell, detections, candidates, seed=0)
    assert parts == (0, 1)
    assert "less deep" in str(change)
    assert all(len(some) <= 2 for _, some in rest)


def test_parts_that_are_taken_need_no_change(cell, detections):
    candidates = judge(cell, detections)
    assert common_fixes(cell, detections, candidates, seed=0) == ()


def test_fingers_that_are_too_wide_open_are_told_so():
    cell = without_search(read_cell("yumi"))
    cell = replace(cell, policy=replace(cell.policy, as_needed=False))
    T = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.019), (0, np.pi / 2, 0))
    rolled = pose_from_rpy((0, 0, 0), (0, 0, np.pi))
    one = (Detection("keyed_cylinder", T * rolled),)
    sides = tuple(
        Obstacle(
            cell.bin.T_world_bin * pose_from_rpy((0, side * 0.0295, 0.015)),
            np.array([0.1, 0.01, 0.03]),
        )
        for side in (1, -1)
    )
    candidates = judge(cell, one, obstacles=sides)
    assert not any(c.verdict.is_ok for c in candidates)
    fixes = Fixes(cell, one, sides, seed=0)
    tried = (fix for c in candidates if c.verdict.pair is not None for fix in fixes.of(c))
    assert any(fix.change == OPENING and fixes.admits(fix) for fix in tried)
    assert nearest_fix(cell, one, candidates, seed=0, obstacles=sides) is not None


OPENING = FixText.OPENING(opening=0.032)


def test_where_the_lift_is_blocked_other_lifts_are_tried_first(cell, detections):
    fixes = Fixes(cell, detections, seed=0)
    candidate = judge(cell, detections)[0]
    assert fixes.of(candidate)[0].change.text is not FixText.LIFTS
    blocked = replace(candidate.verdict, stage=Stage.EXTRACT)
    assert "allow other lifts" in str(fixes.of(replace(candidate, verdict=blocked))[0].change)
    every = replace(cell, policy=replace(cell.policy, lifts=LIFT_NAMES))
    assert not any(
        "allow other lifts" in str(fix.change)
        for fix in Fixes(every, detections, seed=0).of(candidate)
    )


def refused_by(cell, one, pair) -> str:
    """The label that is told for a candidate that two bodies refuse."""
    verdict = Verdict(Reason.IN_COLLISION, Stage.GRASP, pair, -0.001)
    (row,) = blockers(cell, [replace(one, verdict=verdict)])
    return row.label


def test_the_arm_is_known_by_its_joints_and_not_by_how_its_bodies_are_called():
    """The arm `right`, whose links are `link_1` to `link_6`, beside something called `right_...`"""
    cell = read_cell("tx2_90")
    T = cell.bin.T_world_bin * pose_from_rpy((0, 0, 0.02))
    one = judge(cell, (Detection("puck", T),))[0]
    assert one.arm == "right"
    for own in ("link_5", "link_6", "right tube"):
        assert refused_by(cell, one, (own, "bin_wall_left")) == "bin_wall_left"
        assert refused_by(cell, one, ("right_stand", own)) == "right_stand"
        assert refused_by(cell, one, ("part-1", own)) == "part-1"
    assert refused_by(cell, one, ("part-1", "part-2")) == "part-2"
    foot = cell.robot.links[0].name
    assert refused_by(cell, one, ("link_5", foot)) == foot


def test_the_other_arm_is_in_the_way(cell, detections):
    one = next(c for c in judge(cell, detections) if c.arm == "right")
    own, other = (
        next(link.name for link in cell.robot.links if link.collision and link.name.startswith(arm))
        for arm in ("right", "left")
    )
    assert refused_by(cell, one, (own, other)) == other
    assert refused_by(cell, one, (other, own)) == other


def test_the_order_of_changes_does_not_hang_on_what_else_could_be_changed(cell, detections):
    """Without a near margin the other lifts are the only change of the policy."""
    free = replace(cell, policy=replace(cell.policy, near_margin=0.0, lifts=("leaning",)))
    candidate = judge(cell, detections)[0]
    blocked = replace(candidate, verdict=Verdict(Reason.EXTRACT_BLOCKED, Stage.EXTRACT))
    fixes = Fixes(free, detections, seed=0)
    first, last = fixes.of(blocked), fixes.of(candidate)
    assert "allow other lifts" in str(first[0].change)
    assert "allow other lifts" in str(last[-1].change)
    assert {fix.change for fix in first} == {fix.change for fix in last}
    every = replace(cell, policy=replace(cell.policy, near_margin=0.002, lifts=LIFT_NAMES))
    assert "near_margin" in str(Fixes(every, detections, seed=0).of(blocked)[-1].change)
