"""Grasps of a priority below 0: only for parts that nothing else takes; and one part a heap."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking import judging, pipeline
from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason, Stage
from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import GraspLibrary
from workbench.model.scan import Detection
from workbench.planning.picking.propose import GRASPS_BEFORE_SPARE
from workbench.planning.planners.clock import processor_time


@pytest.fixture(scope="module")
def cell():
    return read_cell("yumi")


def with_priority(cell: Cell, priority: int, *, also: bool) -> Cell:
    """The cell whose part has its grasps with a priority, and as they are if `also`."""
    part = cell.parts[0]
    spares = tuple(
        replace(grasp, name=f"spare-{grasp.name}", priority=priority)
        for grasp in part.library.grasps
    )
    entries = (*part.library.entries, *spares) if also else spares
    return replace(cell, parts=(replace(part, library=GraspLibrary(entries)),))


def lying(cell: Cell, y: float) -> Detection:
    T = cell.bin.T_world_bin * pose_from_rpy((0, y, 0.019), (0, np.pi / 2, 0))
    return Detection("keyed_cylinder", T)


def test_spares_are_left_out_where_a_grasp_before_them_works(cell):
    one = (lying(cell, 0.0),)
    before = {(c.grasp.name, c.arm): c.verdict.reason for c in judge(cell, one)}
    after = judge(with_priority(cell, -1, also=True), one)
    usual = {c.arm for c in after if c.verdict.is_ok}
    assert usual and before == {
        (c.grasp.name, c.arm): c.verdict.reason for c in after if c.grasp.priority == 0
    }
    spares = [c for c in after if c.grasp.priority < 0 and c.arm in usual]
    assert not any(c.verdict.is_ok for c in spares)
    left_out = [c for c in spares if c.verdict.reason is Reason.DISABLED]
    assert left_out and all(c.verdict.note.text is VerdictNote.SPARE for c in left_out)


def test_spares_are_used_where_nothing_else_works_and_no_more_than_enough(cell):
    judged = judge(with_priority(cell, -1, also=False), (lying(cell, 0.0),))
    for arm in cell.arms:
        good = [c for c in judged if c.arm == arm.name and c.verdict.is_ok]
        assert 1 <= len(good) <= GRASPS_BEFORE_SPARE


def test_a_plan_looks_at_spares_only_when_it_needs_them(cell):
    both, spares = with_priority(cell, -1, also=True), with_priority(cell, -1, also=False)
    pile = (lying(cell, -0.1), lying(cell, 0.1))
    result = plan_pick(both, pile, "test")
    assert result.plan is not None and len(result.plan.arms) == 2
    assert {one.grasp.priority for one in result.candidates} == {0}
    only = plan_pick(spares, pile, "test")
    assert only.plan is not None
    assert {one.grasp.priority for one in only.candidates} == {-1}


def test_spares_are_looked_at_where_two_arms_could_work_and_the_others_bring_but_one(cell):
    both = with_priority(cell, -1, also=True)
    entries = tuple(
        replace(one, arms=("right",)) if one.priority == 0 else one
        for one in both.parts[0].library.grasps
    )
    library = replace(both.parts[0].library, entries=entries)
    both = replace(both, parts=(replace(both.parts[0], library=library),))
    apart = (lying(cell, -0.1), lying(cell, 0.1))
    result = plan_pick(both, apart, "test")
    assert result.plan is not None and len(result.plan.arms) == 2
    assert {one.grasp.priority for one in result.candidates} == {0, -1}
    alone = plan_pick(both, apart, "test", strategy="right")
    assert alone.plan is not None
    assert {one.grasp.priority for one in alone.candidates} == {0}
    one_heap = replace(both, policy=replace(both.policy, pair_gap=0.5))
    heap = plan_pick(one_heap, apart, "test")
    assert heap.plan is not None and {one.grasp.priority for one in heap.candidates} == {0}


def test_a_plan_takes_one_part_of_a_heap_and_two_of_two(cell):
    careful = replace(cell, policy=replace(cell.policy, pair_gap=0.002))
    touching = (lying(cell, -0.0201), lying(cell, 0.0201))
    apart = (lying(cell, -0.1), lying(cell, 0.1))

    def taken(changed: Cell, pile: tuple[Detection, ...]) -> int:
        plan = plan_pick(changed, pile, "test").plan
        return 0 if plan is None else len(plan.arms)

    assert taken(careful, apart) == 2
    near = replace(careful, policy=replace(careful.policy, pair_gap=0.01))
    assert taken(near, touching) <= 1
    far = replace(careful, policy=replace(careful.policy, pair_gap=0.5))
    assert taken(far, apart) == 1


def right_first(cell: Cell) -> Cell:
    """Usual grasps are for the right arm alone, spares for both."""
    both = with_priority(cell, -1, also=True)
    entries = tuple(
        replace(one, arms=("right",)) if one.priority == 0 else one
        for one in both.parts[0].library.grasps
    )
    library = replace(both.parts[0].library, entries=entries)
    return replace(both, parts=(replace(both.parts[0], library=library),))


def test_spares_are_not_looked_at_for_a_part_that_is_avoided(cell):
    apart = (lying(cell, -0.1), lying(cell, 0.1))
    result = plan_pick(right_first(cell), apart, "test", avoided={1: "its pick failed"})
    assert result.plan is not None and [one.detection for one in result.plan.arms] == [0]
    assert {one.grasp.priority for one in result.candidates} == {0}


@pytest.mark.parametrize(("late", "arms"), [(100.0, 2), (600.0, 1)])
def test_spares_do_not_take_the_time_of_a_plan_that_there_could_be(cell, monkeypatch, late, arms):
    """With half of 1000 s over when spares come, one arm is planned for, and none are tried."""
    gone, propose = [0.0], pipeline.propose

    def proposed(world, *, priorities, looked):
        gone[0] = late if -1 in priorities else 0.0
        return propose(world, priorities=priorities, looked=looked)

    monkeypatch.setattr(pipeline, "propose", proposed)
    for module in (pipeline, judging):
        monkeypatch.setattr(module, "processor_time", lambda: processor_time() + gone[0])
    patient = right_first(cell)
    patient = replace(patient, policy=replace(patient.policy, seconds=1000.0))
    result = plan_pick(patient, (lying(cell, -0.1), lying(cell, 0.1)), "test")
    assert result.plan is not None and len(result.plan.arms) == arms
    spares = [one.verdict for one in result.candidates if one.grasp.priority < 0]
    assert spares and any(one.is_ok for one in spares) == (arms == 2)
    if arms == 1:
        assert {one.reason for one in spares if one.stage is Stage.PROPOSE} >= {Reason.OUT_OF_TIME}
