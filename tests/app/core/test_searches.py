"""Searches in one scan side by side, who changed what was found, and the check of the bin."""

from dataclasses import replace

import numpy as np
import pytest
from idle import Idle

from workbench.app.core.cell.changes import ChangeCell
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import FindParts, UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.scanning import TakeScan, UseScan
from workbench.app.core.people import WORKER
from workbench.app.picking.facts import bin_check_of
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import SearchOverrides


@pytest.fixture
def clock():
    return [1000.0]


@pytest.fixture
def bench(cell, tmp_path, clock):
    bench = Bench(cell, Journal(tmp_path / "s"), now=lambda: clock[0], effects=Idle)
    yield bench
    bench.close()


def search(bench, clock, found, command=None, seconds=0.5):
    number = bench.do(command or FindParts(), "ada").number
    clock[0] += seconds
    return bench.do(JobEnded(number, found), WORKER)


def test_searches_in_a_scan_are_kept_and_one_is_taken(bench, samples, clock):
    bench.do(UseScan(samples.scan()), "ada")
    first, second = samples.detections(1), samples.detections(2)
    search(bench, clock, first)
    state = search(bench, clock, second, FindParts(4, SearchOverrides(1.5, 0.2)), 2.0)
    one, other = state.searches
    assert (one.detections, one.seed, one.seconds) == (first, 0, pytest.approx(0.5))
    assert (other.overrides, other.seed) == (SearchOverrides(1.5, 0.2), 4)
    assert other.seconds == pytest.approx(2.0)
    assert state.detections is second
    state = bench.do(UseDetections(one.detections, "search 1 is taken"), "ben")
    assert state.searches == (one, other) and state.scan is not None
    assert [(r.by, r.says) for r in state.remarks] == [("ben", "search 1 is taken")]
    assert str(state.message) == "search 1 is taken, by ben"
    state = bench.do(UseScan(samples.scan(seed=3)), "ada")
    assert state.searches == () and state.remarks == ()


def test_a_search_to_be_compared_takes_nothing_until_somebody_does(bench, samples, clock):
    bench.do(UseScan(samples.scan()), "ada")
    with pytest.raises(CommandRefused, match="no parts were found yet"):
        bench.do(FindParts(is_compared=True), "ada")
    first, second = samples.detections(1), samples.detections(2)
    found = search(bench, clock, first)
    number = bench.do(MakePlan(), "ada").number
    planned = bench.do(JobEnded(number, samples.planned(found.scene_digest)), WORKER)
    state = search(bench, clock, second, FindParts(4, is_compared=True))
    assert state.detections is first and state.plan is planned.plan
    assert state.phase is planned.phase and [one.seed for one in state.searches] == [0, 4]
    assert "search 2 found 1 part" in str(state.message)
    state = bench.do(UseDetections(second, "search 2 is taken"), "ada")
    assert state.detections is second and state.plan is None


def test_what_people_do_to_the_parts_is_undone_step_by_step(bench, samples, clock):
    bench.do(UseScan(samples.scan()), "ada")
    found = samples.detections(1)
    state = search(bench, clock, found)
    assert state.parts_before == ()
    added, moved = (*found, *samples.detections(2)), (*found, *samples.detections(3))
    bench.do(UseDetections(added, "a part was added"), "ada")
    state = bench.do(UseDetections(moved, "it was moved"), "ben")
    assert state.parts_before == (added, found)
    for expected, before in ((added, (found,)), (found, ())):
        state = bench.do(UseDetections(state.parts_before[0], "undone"), "ada")
        assert state.detections is expected and state.parts_before == before
    # Parts of a bin that was picked from do not come back.
    bench.do(UseDetections(added, "a part was added"), "ada")
    assert search(bench, clock, found).parts_before == ()


def test_remarks_gather_until_parts_are_found_anew(bench, samples, clock):
    bench.do(UseScan(samples.scan()), "ada")
    for name, says in (("ada", "part-1 was corrected by hand"), ("ben", "a part was added")):
        clock[0] += 10
        state = bench.do(UseDetections(samples.detections(), says), name)
    assert [(r.by, r.at) for r in state.remarks] == [("ada", 1010.0), ("ben", 1020.0)]
    assert search(bench, clock, samples.detections()).remarks == ()


@pytest.mark.parametrize(
    "overrides",
    [SearchOverrides(0.1), SearchOverrides(9.0), SearchOverrides(1, 1.5), SearchOverrides(np.nan)],
)
def test_wishes_out_of_range_are_refused(bench, samples, overrides):
    bench.do(UseScan(samples.scan()), "ada")
    with pytest.raises(CommandRefused, match="must lie between"):
        bench.do(FindParts(0, overrides), "ada")


def test_the_check_of_the_bin_follows_scan_and_cell(bench, samples):
    assert bin_check_of(bench.state) is None
    state = bench.do(UseScan(samples.scan()), "ada")
    check = bin_check_of(state)
    assert check is not None and check.T_world_bin is None
    assert bin_check_of(state) is check
    moved = replace(bench.cell, bin=replace(bench.cell.bin, T_world_bin=pose_from_rpy((1, 0, 0))))
    after = bench.do(ChangeCell(moved, "moved"), "ada")
    assert after.scan is state.scan and bin_check_of(after) is not check
    assert bin_check_of(bench.do(TakeScan(), "ada")) is bin_check_of(after)


def test_the_session_tells_the_same_when_it_is_read_again(bench, samples, clock, tmp_path):
    bench.do(UseScan(samples.scan()), "ada")
    search(bench, clock, samples.detections(), FindParts(2, SearchOverrides(0.5)))
    bench.do(UseDetections(samples.detections(), "part-1 was corrected by hand"), "ben")
    before = bench.state
    bench.close()
    again = Bench(bench.cell, Journal(tmp_path / "s"), effects=Idle)
    assert again.state.searches[0].overrides == SearchOverrides(0.5)
    assert again.state.remarks == before.remarks
    again.close()
