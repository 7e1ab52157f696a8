"""A kit as a PLC reads it."""

from dataclasses import replace

import pytest
from prepared_bench import make_results

from workbench.app.picking.pipeline import plan_pick
from workbench.extras.opcua.values import values_of
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.recipes.kit import KitItem
from workbench.model.recipes.recipe import Recipe

PAIR = Recipe(7, "pairs", items=(KitItem("keyed_cylinder", 2),))


@pytest.fixture(scope="module")
def results():
    usual = make_results()
    cell = with_recipe(replace(usual.cell, recipes=(PAIR,)), 7)
    planned = plan_pick(cell, usual.detections, usual.scan.digest, seed=0)
    return replace(usual, cell=cell, planned=planned)


def test_what_a_kit_lacks_and_how_many_are_complete(site):
    def values():
        return values_of(site.bench.state, site.bench.live, site.bench.head)

    for path, phase in (("/scan", "scanned"), ("/localize", "localized"), ("/plan", "planned")):
        site.post(path)
        site.reach(phase)
    plan = site.bench.state.plan.digest
    for path in ("/watch", "/approve", "/send"):
        assert site.post(path, plan=plan).ok, path
    site.reach("done")
    full = values()
    assert (full["KitLacks"], full["KitIsComplete"], full["KitsComplete"]) == ("", True, 0)
    assert site.post("/kit", who="bob").status_code == 200
    empty = values()
    assert (empty["KitLacks"], empty["KitsComplete"]) == ("2 keyed_cylinder", 1)
