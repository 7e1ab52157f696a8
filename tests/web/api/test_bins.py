"""Bins over HTTP."""

import pytest
from prepared_bench import results_with_bins

from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.people import WORKER


@pytest.fixture(scope="module")
def results():
    return results_with_bins()


def test_a_bin_is_read_and_chosen_by_name_and_is_on_record(site):
    state = site.get("/state").json()
    assert (state["bin"], state["bins"]) == ("right", ["right", "left"])
    for path, phase in (("/scan", "scanned"), ("/localize", "localized")):
        site.post(path)
        site.reach(phase)
    assert site.post("/bin", who="bob", name="left").status_code == 200
    chosen = site.get("/state").json()
    assert (chosen["bin"], chosen["phase"], chosen["detections"]) == ("left", "idle", None)
    assert (
        chosen["cell_digest"] != state["cell_digest"]
        and chosen["said"]["id"] == "bin_choice.chosen"
    )
    assert chosen["is_saved"] == state["is_saved"]
    assert site.on_record("ChooseBin")[0]["command"]["name"] == "left"


def test_unknown_bins_are_refused_and_viewers_choose_none(site):
    answer = site.post("/bin", name="third")
    assert answer.status_code == 409
    assert answer.json()["said"]["text"] == "cell yumi has no bin third; it has right, left"
    assert site.post("/bin", name=4).status_code == 400
    assert site.post("/bin", who="vic", name="left").status_code == 403


def test_an_empty_bin_is_read_and_said_to_be_new_without_control(site):
    site.post("/scan")
    site.reach("scanned")
    site.effects.hold.set()
    site.post("/localize")
    site.bench.do(JobEnded(site.bench.state.job.number, ()), WORKER)
    assert site.get("/state").json()["empty_bins"] == ["right"]
    assert site.post("/control/take").ok
    assert site.post("/new-bin", who="bob", name="third").status_code == 409
    assert site.post("/new-bin", who="vic", name="right").status_code == 403
    assert site.post("/new-bin", who="bob", name="right").status_code == 200
    state = site.get("/state").json()
    assert (state["empty_bins"], state["phase"]) == ([], "idle")
    assert state["said"]["id"] == "bin_choice.new"
    assert site.on_record("NewBin")[0]["actor"] == "Bob"
