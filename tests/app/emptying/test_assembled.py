"""Kits that are assembled are emptied out of a bin: what was put down stays until the kit is."""

import pytest
from assembling import assembly_cell

from workbench.app.emptying.empty import empty_pile, fallen
from workbench.app.emptying.film import Shot
from workbench.model.prediction import PileTask


@pytest.mark.extensive
@pytest.mark.parametrize("picks", [1, 2])
def test_each_kit_is_a_bolt_and_then_a_spacer_over_it(picks):
    cell = assembly_cell()
    task = PileTask("assembly", "", 4, 100, recipe=1, picks=picks, settles=False)
    shots: list[Shot] = []
    emptied = empty_pile(cell, task, fallen(cell, cell, task), film=shots.append)
    plans = [shot.plan for shot in shots]
    kinds = [plan.detections[plan.picks[0].detection].part for plan in plans]
    assert emptied.kits is not None and emptied.kits[0] >= 1
    assert kinds == ["bolt", "spacer"] * (len(kinds) // 2) + ["bolt"] * (len(kinds) % 2)
    around = [[box.part for box in plan.obstacles] for plan in plans]
    assert around == [[] if kind == "bolt" else ["bolt"] for kind in kinds]
    assert emptied.taken == len(kinds)
