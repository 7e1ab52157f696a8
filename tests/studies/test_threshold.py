"""The threshold study: what a table says follows from its cases."""

from collections import Counter

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.cli.measuring.studies import _threshold_words
from workbench.formats.cells.reading import read_cell
from workbench.model.prediction import Forecast
from workbench.studies.pairs import Taken
from workbench.studies.threshold import Case, Way, planned_case, predictions, summary

WHOLE = Taken(2, "", True, "")

ways = st.builds(
    Way, is_proven=st.booleans(), planning=st.floats(0.01, 2), cycle=st.floats(1, 20)
).map(lambda way: way if way.is_proven else Way(False, way.planning, None))
cases = st.lists(
    st.builds(
        Case,
        seed=st.integers(0, 9999),
        distance=st.floats(0, 0.4),
        is_reachable=st.booleans(),
        alternated=ways,
        coordinated=ways,
        allowed=ways,
        taken=st.just(WHOLE),
    ),
    max_size=12,
)


@given(cases)
def test_a_higher_threshold_never_makes_more_coordinated(found):
    shares = [row["allowed_share"] for row in summary(found, (0.0, 0.1, 0.2, 0.5))]
    if any(case.is_reachable for case in found):
        assert shares[0] == 1.0 and shares[-1] == 0.0
        assert shares == sorted(shares, reverse=True)
    else:
        assert shares == [None] * 4


def test_unreachable_piles_do_not_count():
    good, bad = Way(True, 0.1, 9.9), Way(False, 0.1, None)
    found = [Case(0, 0.2, True, good, good, good, WHOLE), Case(1, 0.2, False, bad, bad, bad, WHOLE)]
    (row,) = summary(found, [0.1])
    assert (row["piles"], row["reachable"], row["allowed_success"]) == (2, 1, 1.0)
    assert row["parts_per_hour"] == pytest.approx(2 * 3600 / 10)


def test_what_is_allowed_is_counted_by_what_auto_made_of_it():
    quick, slow, none = Way(True, 0.1, 8.0), Way(True, 0.5, 7.0), Way(False, 0.2, None)
    (row,) = summary([Case(0, 0.2, True, quick, none, slow, WHOLE)], [0.1])
    assert (row["allowed_success"], row["allowed_planning"]["median"]) == (1.0, 0.5)
    assert (row["coordinated_success"], row["coordinated_planning"]["median"]) == (0.0, 0.2)
    said = Counter(_threshold_words(row))
    assert said["500.0"] == 3 and "200.0" not in said


def test_an_hour_pays_for_planning_that_comes_to_nothing():
    good, bad = Way(True, 0.1, 9.9), Way(False, 5.0, None)
    piles = [Case(0, 0.2, True, good, good, good, WHOLE), Case(1, 0.2, True, bad, bad, bad, WHOLE)]
    (row,) = summary(piles, [0.1])
    assert row["parts_per_hour"] == pytest.approx(2 * 3600 / 15)
    (row,) = summary(piles[1:], [0.1])
    assert (row["parts_per_hour"], row["cycle_mean"]) == (0.0, None)


def test_what_the_page_shows_is_what_the_table_says():
    good, bad = Way(True, 0.1, 9.9), Way(False, 0.3, None)
    two = [Case(0, 0.2, True, good, good, good, WHOLE), Case(1, 0.1, True, bad, bad, bad, WHOLE)]
    rows = summary(two, [0.15])
    cell = read_cell("yumi")
    kept = predictions(cell, rows)
    assert (kept.cell_digest, kept.piles) == (cell.digest, 2)
    (forecast,) = kept.forecasts
    assert forecast == Forecast(0.15, 0.5, 0.5, 0.2, 9.9, pytest.approx(2 * 3600 / 10.3))


def test_a_case_is_the_same_however_often_it_is_planned():
    first, again = planned_case(("yumi", 3)), planned_case(("yumi", 3))
    assert (first.distance, first.is_reachable) == (again.distance, again.is_reachable)
    assert first.alternated.cycle == again.alternated.cycle
    assert first.coordinated.cycle == again.coordinated.cycle
    assert first.taken == again.taken
