"""The nearest fix: a change that really admits, and the smallest of those tried."""

import re
from dataclasses import replace

import pytest
from bending import with_grasps

from workbench.app.picking.judging import judge
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import GraspLibrary
from workbench.planning.picking.nearest_fix import nearest_fix


@pytest.fixture(scope="module")
def deep(cell, detections):
    """Every grasp taken 9 mm deeper: the fingers reach the floor."""
    deep = with_grasps(
        cell, lambda g: replace(g, T_part_tcp=g.T_part_tcp * pose_from_rpy((0, 0, 0.009)))
    )
    return deep, judge(deep, detections)


def test_too_deep_a_grasp_is_told_to_come_out(deep, detections):
    cell, candidates = deep
    assert not any(candidate.verdict.is_ok for candidate in candidates)
    fix = nearest_fix(cell, detections, candidates, seed=0)
    assert fix is not None
    assert not fix.candidate.verdict.is_ok
    assert re.fullmatch(r"grasp \d+ mm less deep", str(fix.change))


def test_the_change_admits_and_a_smaller_one_does_not(deep, detections):
    cell, candidates = deep
    fix = nearest_fix(cell, detections, candidates, seed=0)
    millimetres = int(re.findall(r"\d+", str(fix.change))[0])

    def admitted(back: float) -> bool:
        part = cell.parts[0]
        T = fix.candidate.grasp.T_part_tcp * pose_from_rpy((0, 0, -back / 1000))
        changed = replace(fix.candidate.grasp, T_part_tcp=T)
        alone = replace(cell, parts=(replace(part, library=GraspLibrary((changed,))),))
        alone = replace(alone, policy=replace(alone.policy, as_needed=False))
        wanted = (fix.candidate.detection, fix.candidate.arm)
        return any(
            one.verdict.is_ok
            for one in judge(alone, detections)
            if (one.detection, one.arm) == wanted
        )

    assert admitted(millimetres)
    assert not admitted(millimetres - 1)


def test_the_same_request_has_the_same_answer(deep, detections):
    cell, candidates = deep
    first, second = (nearest_fix(cell, detections, candidates, seed=3) for _ in range(2))
    assert (first.change, first.candidate.grasp.name) == (
        second.change,
        second.candidate.grasp.name,
    )


def test_what_is_out_of_reach_has_no_small_fix(cell, detections):
    far = tuple(
        replace(one, T_world_part=pose_from_rpy((3, 0, 0)) * one.T_world_part) for one in detections
    )
    candidates = judge(cell, far)
    assert nearest_fix(cell, far, candidates, seed=0) is None


def test_a_bin_that_is_out_of_reach_is_said_to_be_moved_and_by_how_much(cell, detections):
    def moved(cell, detections, x):
        shift = pose_from_rpy((x, 0, 0))
        there = replace(cell.bin, T_world_bin=shift * cell.bin.T_world_bin)
        lying = tuple(replace(one, T_world_part=shift * one.T_world_part) for one in detections)
        return replace(cell, bin=there), lying

    far, lying = moved(cell, detections, 0.3)
    fix = nearest_fix(far, lying, judge(far, lying), seed=0)
    by, back = map(int, re.findall(r"[+-]\d+", str(fix.change)))
    assert str(fix.change).startswith("move the bin by -") and back == -by
    nearer, there = moved(far, lying, by / 1000)
    wanted = (fix.candidate.detection, fix.candidate.arm, fix.candidate.grasp.name)
    admitted = {
        (one.detection, one.arm, one.grasp.name)
        for one in judge(nearer, there)
        if one.verdict.is_ok
    }
    assert wanted in admitted
    none = nearest_fix(far, lying, judge(far, lying), seed=0, may_move_bin=False)
    assert none is None or "bin" not in str(none.change)


def test_where_no_other_grasp_helps_the_margin_is_named(cell, detections, monkeypatch):
    """With a margin of 9 mm to the floor, which its fingers do not have."""
    for name in ("TURNS_TRIED", "BACK_OFFS", "SLIDES", "OPENINGS"):
        monkeypatch.setattr(f"workbench.planning.picking.nearest_fix.{name}", ())
    wide = replace(cell, policy=replace(cell.policy, near_margin=0.009, as_needed=False))
    candidates = judge(wide, detections)
    fix = nearest_fix(wide, detections, candidates, seed=0)
    assert fix is not None
    assert "near_margin, now 9.0 mm" in str(fix.change)
    assert not fix.candidate.verdict.is_ok
    assert any(
        one.verdict.is_ok
        for one in judge(cell, detections)
        if (one.detection, one.arm, one.grasp.name)
        == (fix.candidate.detection, fix.candidate.arm, fix.candidate.grasp.name)
    )
