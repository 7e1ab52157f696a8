"""How long votes have stood by a steady clock, and what is on record where they run out."""

import json
from dataclasses import replace

import pytest
from noted import Clock, Noted, approved

from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.state import Phase
from workbench.app.records.vote_ages import VoteAges
from workbench.app.runtime.bench import Bench
from workbench.journal.journal import Journal
from workbench.model.release import Vote


@pytest.fixture
def voted(cell, samples):
    """An approved state, ages that have noted it, and the steady clock [s]."""
    steady, state = [50.0], samples.approved(cell)
    state = replace(state, votes=(Vote(state.plan.digest, "ada", 1000.0),))
    ages = VoteAges(lambda: steady[0])
    ages.note(state)
    return state, ages, steady


def test_a_vote_that_has_run_out_by_both_clocks_means_no_clock_that_was_set_back(voted):
    state, ages, steady = voted
    at, valid = state.votes[0].at, state.cell.policy.approval_minutes * 60.0
    assert ages.find_lapse(state, at) is None
    steady[0] += valid
    assert ages.find_lapse(state, at + valid) is None
    assert "it was set back" in str(ages.find_lapse(state, at + 1.0))


def test_a_plan_that_takes_longer_than_its_approval_lasts_ends_as_it_was(cell, samples, tmp_path):
    now, steady = Clock(), Clock()
    bench = Bench(cell, Journal(tmp_path / "session"), now=now, steady=steady, effects=Noted)
    bench.do(SendPlan(approved(bench, samples)), "ada")
    for clock in (now, steady):
        clock.now += 60.0 * cell.policy.approval_minutes + 1.0
    assert bench.do(LinkEnded(parts_placed=1), "robot link").phase is Phase.DONE
    *_, last = bench.entries()
    assert last.kind == "LinkEnded"
    assert "row_ends" not in json.loads(last.body)["command"]
    bench.close()


def test_a_single_plan_ends_as_it_was_also_where_the_clock_was_set_back(cell, samples, tmp_path):
    now, steady = Clock(), Clock()
    bench = Bench(cell, Journal(tmp_path / "session"), now=now, steady=steady, effects=Noted)
    bench.do(SendPlan(approved(bench, samples)), "ada")
    steady.now += 60.0 * cell.policy.approval_minutes + 1.0
    bench.do(LinkEnded(parts_placed=1), "robot link")
    *_, last = bench.entries()
    assert "row_ends" not in json.loads(last.body)["command"]
    bench.close()
