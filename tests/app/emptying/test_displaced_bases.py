"""Bases that move after they were placed: parts mate where they are looked at again."""

from dataclasses import replace

import numpy as np
import pytest
from assembling import assembly_cell, standing_spacer

from workbench.app.emptying.assemblies import Assembled
from workbench.app.emptying.empty import empty_pile, fallen
from workbench.app.emptying.summary import summary
from workbench.app.picking.row import plan_row
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.geometry import pose_from_rpy
from workbench.model.prediction import PileTask
from workbench.model.recipes.seen_base import SightProblem
from workbench.model.scan import Detection
from workbench.perception.simulation.synthesize import synthesize

CELLS = {1: assembly_cell()}
CELLS[2] = with_recipe(read_cell(find("robots", "yumi") / "assembly.toml"), 2)
SURE = np.diag(np.square([5e-5] * 3 + [1e-3] * 3))


def lying(cell) -> tuple[Detection, ...]:
    bolt = cell.bin.T_world_bin * pose_from_rpy((0.0, -0.09, 0.0135), (0.0, 1.5708, 0.5))
    return (
        Detection("bolt", bolt, covariance=SURE),
        replace(standing_spacer(cell), covariance=SURE),
    )


def filled(recipe: int, displaced: float, seen: str = "scan") -> Assembled:
    """A kit into which a bolt was put, which moves, and then a spacer, by known poses."""
    cell, assembled = CELLS[recipe], Assembled()
    task = PileTask("assembly", "", 2, 7, seen=seen, recipe=recipe, displaced=displaced)
    left = lying(cell)
    for _ in range(2):
        truth = (*left, *assembled.truth)
        scan = synthesize(cell, truth, seed=3) if seen == "scan" else None
        boxes = assembled.boxes(cell, task, scan)
        digest = scan.digest if scan is not None else "study"
        wanted = left[:1] if not assembled.kit else left
        result = plan_row(cell, wanted, digest, obstacles=boxes)
        assert result.plan is not None and result.proof is not None and result.proof.holds
        assembled.add(cell, task, result.plan, result.plan.picks[0])
        left = left[1:]
    return assembled


@pytest.mark.parametrize("seen", ["scan", "truth"])
def test_a_spacer_mates_with_a_bolt_that_has_moved_only_where_it_is_looked_at_again(seen):
    jammed, mated = filled(1, 0.004, seen), filled(2, 0.004, seen)
    assert (jammed.complete, jammed.unmated) == (0, 1)
    assert (mated.complete, mated.unmated) == (1, 0)


def test_a_bolt_that_does_not_move_needs_no_second_look():
    kit = filled(1, 0.0)
    assert (kit.complete, kit.unmated, kit.kit, kit.truth) == (1, 0, [], ())


def test_a_bolt_that_has_moved_too_far_gets_no_spacer():
    cell, assembled = CELLS[2], Assembled()
    task = PileTask("assembly", "", 2, 7, seen="scan", recipe=2, displaced=0.014)
    result = plan_row(cell, lying(cell)[:1], "scan")
    assembled.add(cell, task, result.plan, result.plan.picks[0])
    (box,) = assembled.boxes(cell, task, synthesize(cell, assembled.truth, seed=3))
    assert box.seen is not None and box.seen.problem is SightProblem.TOO_FAR


@pytest.mark.extensive
def test_kits_that_do_not_mate_are_counted():
    cell = CELLS[1]
    task = PileTask("assembly", "", 4, 100, recipe=1, settles=False, displaced=0.006)
    pile = empty_pile(cell, task, fallen(cell, cell, task))
    found = summary([pile], scan_seconds=1.0, approval_seconds=0.0)
    assert found["kits"] == 0 and found["kits_unmated"] >= 1
