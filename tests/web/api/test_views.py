"""Views of a scanner on an arm over HTTP."""

from dataclasses import replace

import pytest
from arm_scanner_cell import on_arm_cell, with_lower_view
from prepared_bench import make_results

from workbench.model.robot import ScannedView
from workbench.web.api.forms import scan_form


@pytest.fixture(scope="module")
def results():
    return replace(make_results(), cell=with_lower_view(on_arm_cell()))


def test_a_view_is_read_and_chosen_by_name_and_is_on_record(site):
    state = site.get("/state").json()
    assert (state["view"], state["views"]) == ("bin", ["bin", "low"])
    assert site.post("/choose-view", who="bob", name="low").status_code == 200
    chosen = site.get("/state").json()
    assert chosen["view"] == "low" and chosen["said"]["id"] == "view_choice.chosen"
    assert chosen["cell_digest"] != state["cell_digest"]
    assert site.on_record("ChooseView")[0]["command"]["name"] == "low"
    assert site.post("/choose-view", name="high").status_code == 409
    assert site.post("/choose-view", who="vic", name="bin").status_code == 403


def test_a_merged_scan_says_of_each_view_whether_it_fits_the_others(results):
    scan = results.scan
    pose, count = scan.T_world_scanner, len(scan.points)
    views = (ScannedView("bin", 9, pose, 0.004), ScannedView("low", count - 9, pose))
    form = scan_form(replace(scan, views=views))
    assert [(view["name"], view["points"], view["is_off"]) for view in form["views"]] == [
        ("bin", 9, True),
        ("low", count - 9, False),
    ]
    assert scan_form(scan)["views"] == []
