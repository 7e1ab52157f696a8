"""A kit as a PLC reads it."""

import pytest
from prepared_bench import results_with_kit

from workbench.extras.opcua.values import values_of


@pytest.fixture(scope="module")
def results():
    return results_with_kit()


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
