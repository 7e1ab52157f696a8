"""Bins over HTTP."""

from dataclasses import replace

import pytest
from prepared_bench import make_results

from workbench.model.geometry import pose_from_rpy


@pytest.fixture(scope="module")
def results():
    usual = make_results()
    box = replace(usual.cell.bin, name="right", number=1)
    away = pose_from_rpy((0, 3.0, 0)) * box.T_world_bin
    other = replace(box, name="left", number=2, T_world_bin=away)
    return replace(usual, cell=replace(usual.cell, bin=box, other_bins=(other,)))


def test_a_bin_is_read_and_chosen_by_name_and_is_on_record(site):
    state = site.get("/state").json()
    assert (state["bin"], state["bins"]) == ("right", ["right", "left"])
    for path, phase in (("/scan", "scanned"), ("/localize", "localized")):
        site.post(path)
        site.reach(phase)
    assert site.post("/bin", who="bob", name="left").status_code == 200
    chosen = site.get("/state").json()
    assert (chosen["bin"], chosen["phase"], chosen["detections"]) == ("left", "scanned", None)
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
