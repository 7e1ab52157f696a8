"""How sure detections say they are, against what is right."""

import numpy as np
import pytest

from workbench.studies.sureness import sureness


def test_stated_chances_that_hold_are_not_apart():
    stated = [(0.92, number >= 8) for number in range(100)] + [(0.6, True), (0.6, False)]
    told = sureness(stated, [])
    assert [one["count"] for one in told["bins"]] == [2, 100]
    assert told["bins"][1]["right"] == pytest.approx(0.92)
    assert told["calibration_error"] == pytest.approx(2 * 0.1 / 102)
    assert told["within"] is None


def test_chances_that_are_too_high_are_told():
    assert sureness([(0.99, False)] * 4, [])["calibration_error"] == pytest.approx(0.99)
    assert sureness([(1.0, True)], [])["calibration_error"] == 0.0


def test_errors_lie_within_the_ellipsoid_as_often_as_chi_squared_has_it():
    errors = np.random.default_rng(0).standard_normal((20_000, 6))
    told = sureness([], [(float(square), 6) for square in (errors**2).sum(axis=1)])
    assert told["within"] == pytest.approx(0.99, abs=0.003)
    assert (told["errors"], told["bins"], told["calibration_error"]) == (20_000, [], None)


@pytest.mark.parametrize(("freedom", "limit"), [(6, 16.812), (5, 15.086), (3, 11.345)])
def test_errors_with_fewer_unknowns_have_a_smaller_ellipsoid(freedom, limit):
    """The limits are those of printed tables of chi-squared for 99 %."""
    told = [sureness([], [(limit + off, freedom)])["within"] for off in (-0.001, 0.001)]
    assert told == [1.0, 0.0]
