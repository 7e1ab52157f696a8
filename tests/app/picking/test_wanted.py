"""For a kit no more parts are taken than it lacks, and none of other kinds."""

import pytest

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.row import plan_row
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.derived.by_recipe import wanted_parts, with_recipe
from workbench.model.recipes.kit import Wanted
from workbench.perception.simulation.piles import drop_parts, pile_of

KITS = find("robots", "yumi") / "kits.toml"


@pytest.fixture(scope="module")
def cell():
    return with_recipe(read_cell(KITS), 1)


@pytest.fixture(scope="module")
def bolts(cell):
    """Three bolts that lie apart, and a bracket."""
    bolt, bracket = cell.part("bolt"), cell.part("bracket")
    return drop_parts((bolt, bolt, bolt, bracket), cell.bin, seed=3)


def kinds_taken(result) -> list[str]:
    plans = (result.plan, *(proven.plan for proven in result.row))
    return sorted(plan.detections[arm.detection].part for plan in plans for arm in plan.arms)


def test_what_falls_for_kits_is_what_they_consist_of(cell):
    pile = pile_of(cell, "", 6, seed=1)
    assert [found.part for found in pile] == ["bracket", "bolt", "bolt"] * 2


@pytest.mark.parametrize("strategy", ["auto", "alternated", "coordinated", "both"])
def test_the_last_part_is_taken_by_one_arm_whatever_the_strategy(cell, bolts, strategy):
    result = plan_pick(cell, bolts, "scan", strategy=strategy, wanted=Wanted({"bolt": 1}))
    assert result.proof is not None and result.proof.holds
    assert kinds_taken(result) == ["bolt"]
    refused = {c.detection: str(c.verdict.message) for c in result.candidates}
    assert "the kit needs no bracket now" in refused[3]


def test_two_arms_take_two_parts_only_if_both_are_lacking(cell, bolts):
    both = plan_pick(cell, bolts, "scan", strategy="alternated", wanted=Wanted({"bolt": 2}))
    assert kinds_taken(both) == ["bolt", "bolt"]
    mixed = Wanted({"bolt": 1, "bracket": 1})
    result = plan_pick(cell, bolts, "scan", strategy="alternated", wanted=mixed)
    assert kinds_taken(result) == ["bolt", "bracket"]


def test_in_order_the_other_kind_waits(cell, bolts):
    wanted = Wanted({"bracket": 1, "bolt": 2}, in_order=True)
    result = plan_pick(cell, bolts, "scan", strategy="alternated", wanted=wanted)
    assert kinds_taken(result) == ["bracket"]


def test_a_row_fills_the_kit_and_ends_with_it(cell):
    bolt, bracket = cell.part("bolt"), cell.part("bracket")
    pile = drop_parts((bolt, bolt, bracket, bolt), cell.bin, seed=5)
    result = plan_row(cell, pile, "scan", picks=4, wanted=wanted_parts(cell))
    assert kinds_taken(result) == ["bolt", "bolt", "bracket"]
    assert str(result.row_ends) == "the kit is complete"
