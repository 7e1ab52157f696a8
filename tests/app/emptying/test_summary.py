"""What is told of all piles follows from each of them."""

from dataclasses import replace

import pytest
from made_piles import scene

from workbench.app.emptying.summary import summary


def test_shares_and_rates_are_those_of_all_piles_together():
    found = summary([scene(0, 6, 2), scene(1, 0, 8)], scan_seconds=1.0, approval_seconds=2.0)
    assert found["taken_share"] == pytest.approx(6 / 16)
    seconds = 60 + 0.8 + (9 + 3) * 1.0 + 6 * 2.0
    assert found["parts_per_hour"] == pytest.approx(3600 * 6 / seconds)
    assert found["planning_ms"] == {"median": pytest.approx(200), "p95": pytest.approx(300)}
    assert found["planning_ms_by_stage"] == {"propose": pytest.approx(200)}
    assert found["left_by_reason"] == {"tool collision": 10}
    assert [one["seed"] for one in found["scenes"]] == [0, 1]
    assert found["scenes"][0]["left"][1]["part"] == "part-2"


def test_what_hides_behind_motion_counts_once():
    pile = replace(scene(0, 3, 0), beside=((1.5, 0.2), (1.5, 0.9)))
    found = summary([pile], scan_seconds=1.0, approval_seconds=2.0)
    seconds = 30 + 0.4 + 6 * 1.0 + 3 * 2.0 - (1.2 + 1.5)
    assert found["parts_per_hour"] == pytest.approx(3600 * 3 / seconds)


def test_failed_picks_are_picks_and_counted_by_kind():
    found = summary([scene(0, 3, 0, failed=(2, 1, 0))], scan_seconds=0.0, approval_seconds=0.0)
    assert (found["picks"], found["failed_picks"]) == (6, 3)
    assert found["failed_by_kind"] == {"missed": 2, "crooked": 1, "turned": 0}


def test_what_slipped_is_told_where_grips_are_weighed():
    piles = [scene(0, 3, 0, failed=(1, 0, 0, 2)), scene(1, 3, 0, failed=(0, 1, 0))]
    found = summary(piles, scan_seconds=0.0, approval_seconds=0.0)
    assert found["failed_by_kind"] == {"missed": 1, "crooked": 1, "turned": 0, "slipped": 2}
    assert (found["picks"], found["failed_picks"]) == (10, 4)
    assert found["scenes"][1]["failed_by_kind"] == {"missed": 0, "crooked": 1, "turned": 0}


def test_what_hands_could_hold_is_told_where_all_piles_were_looked_at():
    looked = replace(scene(0, 3, 5), holdable=2)
    seconds = {"scan_seconds": 0.0, "approval_seconds": 0.0}
    assert summary([looked], **seconds)["estimate_share"] == pytest.approx(5 / 8)
    assert summary([looked, scene(1, 3, 5)], **seconds)["estimate_share"] is None


def test_no_piles_have_no_shares():
    found = summary([], scan_seconds=1.0, approval_seconds=0.0)
    assert found["taken_share"] is None and found["planning_ms"] is None
