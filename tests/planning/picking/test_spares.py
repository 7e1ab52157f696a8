"""Grasps of a priority below 0: only for parts that nothing else takes; and one part a heap."""

from dataclasses import replace

import numpy as np
import pytest

from workbench.app.picking.pipeline import ENOUGH, judge, plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.candidate import Reason
from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import GraspLibrary
from workbench.model.scan import Detection


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
    assert left_out and all("works and goes first" in c.verdict.note for c in left_out)


def test_spares_are_used_where_nothing_else_works_and_no_more_than_enough(cell):
    judged = judge(with_priority(cell, -1, also=False), (lying(cell, 0.0),))
    for arm in cell.arms:
        good = [c for c in judged if c.arm == arm.name and c.verdict.is_ok]
        assert 1 <= len(good) <= ENOUGH


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
