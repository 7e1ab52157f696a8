"""The record of acceptance: the last picks against what was agreed."""

from dataclasses import replace

import pytest

from workbench.app.core.state import State
from workbench.app.review.commissioning import Targets
from workbench.app.statistics.cycles import CycleRecord, PickRecord
from workbench.app.statistics.statistics import Statistics
from workbench.extras.evidence.acceptance import acceptance_page, judge_acceptance
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import InputError

NOW = 1_795_000_000.0


@pytest.fixture(scope="module")
def state():
    return State(read_cell("yumi"))


def cycles(*results: str, seconds: float = 10.0) -> Statistics:
    """Cycles of one pick each, of which a person's approval takes 4 s."""
    return Statistics(
        tuple(
            CycleRecord(
                number,
                NOW + 60 * number,
                NOW + 60 * number + seconds,
                end="done",
                picks=(PickRecord(0, "bolt", "side", "left", result, "dropped"),),
                seconds={"approve": 4.0},
            )
            for number, result in enumerate(results)
        )
    )


def judged(state, counted, targets):
    return judge_acceptance(state, ["a session"], counted, targets, NOW)


def table(acceptance, title):
    return next(each for each in acceptance.tables if each.title == title)


def test_the_last_picks_count_and_those_before_do_not(state):
    counted = cycles(*["failed"] * 5, *["picked"] * 20)
    assert judged(state, counted, Targets(20, 1.0)).is_met
    missed = judged(state, counted, Targets(21, 1.0))
    assert not missed.is_met
    assert [row[-1] for row in missed.result.rows] == ["met", "missed"]
    assert not judged(state, counted, Targets(26, 0.5)).is_met


def test_a_pick_that_nobody_reported_counts_as_not_taken(state):
    acceptance = judged(state, cycles("picked", "unknown"), Targets(2, 0.6))
    assert not acceptance.is_met
    assert table(acceptance, "Not taken").rows[0][:2] == ("dropped", "1")


def test_the_time_of_a_part_leaves_the_approval_out_and_shares_what_failed(state):
    counted = cycles("picked", "picked", "failed", seconds=10.0)
    assert judged(state, counted, Targets(3, 0.5, 9.0)).is_met
    assert not judged(state, counted, Targets(3, 0.5, 8.9)).is_met
    assert not judged(state, cycles("failed"), Targets(1, 0.1, 100.0)).is_met


def test_the_bound_of_the_share_is_that_of_clopper_and_pearson(state):
    says = judged(state, cycles(*["picked"] * 59), Targets(59, 1.0)).result.says
    assert "at least 95.0%" in says  # 59 of 59 show 95% with a confidence of 95%
    assert "at least 0.0%" in judged(state, cycles("failed"), Targets(1, 1.0)).result.says


def test_nothing_picked_meets_nothing(state):
    assert not judged(state, Statistics(), Targets(1, 0.01)).is_met


def test_a_simulated_cell_is_called_so_and_signatures_have_room(state):
    acceptance = judged(state, cycles("picked"), Targets(1, 1.0))
    assert "simulated" in table(acceptance, "Cell").says
    real = replace(state, cell=replace(state.cell, scanner=replace(state.cell.scanner, source="x")))
    assert table(judged(real, cycles("picked"), Targets(1, 1.0)), "Cell").says == ""
    session = "a session", 7, "0" * 64
    page = acceptance_page(state, session, cycles("picked"), Targets(1, 1.0), NOW).decode()
    for said in ("a session, 7 entries", "Signature", "<td", "All targets are met"):
        assert said in page


@pytest.mark.parametrize(
    "targets",
    [Targets(0), Targets(10**9), Targets(share=0.0), Targets(share=98.0), Targets(seconds=0.0),
     Targets(seconds=float("nan")), Targets(share=float("nan"))],
)  # fmt: skip
def test_targets_that_cannot_be_met_are_refused(state, targets):
    with pytest.raises(InputError):
        judged(state, cycles("picked"), targets)
