"""A kit filled over HTTP, and as the statistics see it."""

import pytest
from prepared_bench import results_with_kit

from workbench.app.statistics.kits import KitCount
from workbench.app.statistics.statistics import statistics, together


@pytest.fixture(scope="module")
def results():
    return results_with_kit()


def cycle(site) -> None:
    for path, phase in (("/scan", "scanned"), ("/localize", "localized"), ("/plan", "planned")):
        site.post(path)
        site.reach(phase)
    plan = site.bench.state.plan.digest
    for path in ("/watch", "/approve", "/send"):
        assert site.post(path, plan=plan).ok, path
    site.reach("done")


def test_a_kit_is_filled_and_replaced_over_http(site):
    kit = site.get("/state").json()["kit"]
    assert kit == {
        "items": [{"part": "keyed_cylinder", "count": 2, "has": 0}],
        "is_complete": False, "complete_before": 0, "incomplete_before": 0, "bases": [],
    }  # fmt: skip
    assert site.post("/kit").json()["said"]["id"] == "kit.nothing"
    cycle(site)
    kit = site.get("/state").json()["kit"]
    assert (kit["items"][0]["has"], kit["is_complete"]) == (2, True)
    for path, phase in (("/scan", "scanned"), ("/localize", "localized")):
        site.post(path)
        site.reach(phase)
    refused = site.post("/plan")
    assert (refused.status_code, refused.json()["said"]["id"]) == (409, "kit.complete")
    assert site.post("/kit", who="vic").status_code == 403
    assert site.post("/kit", who="bob").status_code == 200
    kit = site.get("/state").json()["kit"]
    assert (kit["items"][0]["has"], kit["complete_before"]) == (0, 1)


def test_kits_are_counted_by_recipe_over_sessions(site):
    cycle(site)
    site.post("/kit")
    cycle(site)
    site.post("/report", detection=0, is_picked=False)
    site.post("/kit")
    assert site.get("/statistics").json()["kits"] == [{"recipe": 7, "complete": 1, "incomplete": 1}]
    counted = statistics(site.bench.entries(0))
    assert together([counted, counted]).kits == (KitCount(7, 2, 2),)
