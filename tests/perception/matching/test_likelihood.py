"""A part against something unknown: what each kind of pixel says."""

from typing import Any

import numpy as np
import pytest

from workbench.perception.matching.likelihood import log_likelihood_ratio
from workbench.perception.matching.sightings import Sighting

TOLERANCE = 0.001
SPREAD = 0.25 * TOLERANCE
PIXELS = 2000


def seen(off: Any, *, through: int = 0, rim: int = 0, ahead: Any = ()) -> Sighting:
    """A sighting: points so far off [m], pixels that are looked through, and those in front."""
    count, hidden = len(off), len(ahead)
    return Sighting(
        explained=np.arange(count),
        off=np.asarray(off),
        violated=np.arange(count, count + through + rim),
        is_rim=np.arange(through + rim) >= through,
        hidden=np.arange(PIXELS - hidden, PIXELS),
        ahead=np.asarray(ahead, float),
    )


def ratio(sighting: Sighting, others: Any = (), *, is_all_known: bool = True) -> float:
    is_other = np.zeros(PIXELS, np.bool_)
    is_other[list(others)] = True
    return log_likelihood_ratio(sighting, is_other, SPREAD, TOLERANCE, is_all_known=is_all_known)


@pytest.fixture
def exact():
    """Points as far off as the scanner measures."""
    return np.random.default_rng(0).normal(0.0, SPREAD / 1.5, 1000)


@pytest.fixture
def anywhere():
    """Points anywhere within the tolerance."""
    return np.random.default_rng(0).uniform(-TOLERANCE, TOLERANCE, 1000)


def test_points_as_exact_as_the_scanner_speak_for_the_part(exact):
    assert ratio(seen(exact)) > 0.4


def test_points_anywhere_within_the_tolerance_speak_against_it(anywhere):
    assert ratio(seen(anywhere)) < 0.0


def test_what_is_seen_through_speaks_against_it_most_in_the_middle(exact):
    assert ratio(seen(exact, through=200)) < 0.0 < ratio(seen(exact, rim=200))
    assert ratio(seen(exact, rim=600)) < 0.0


def test_what_lies_in_front_is_another_part_or_speaks_against_it(exact):
    covered = seen(exact, ahead=np.full(300, 2 * TOLERANCE))
    others = range(PIXELS - 300, PIXELS)
    assert ratio(covered) < 0.0 < ratio(covered, others)
    assert ratio(covered, is_all_known=False) == ratio(covered, others) == ratio(seen(exact))


def test_what_lies_far_in_front_may_be_anything(exact):
    covered = seen(exact, ahead=np.full(300, 0.02))
    assert 0.0 < ratio(covered) < ratio(seen(exact))


def test_what_is_not_measured_says_nothing(exact):
    assert ratio(seen(exact, ahead=np.full(900, np.nan))) == ratio(seen(exact))


def test_points_of_another_part_are_not_counted_twice(exact, anywhere):
    both = seen(np.concatenate([exact[:500], anywhere[:500]]))
    assert ratio(both, range(500, 1000)) > ratio(both) > ratio(both, range(500))
    assert ratio(both, range(1000)) == -np.inf
