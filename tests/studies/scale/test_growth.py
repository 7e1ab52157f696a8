"""Costs at several sizes, and the exponents between them."""

import math

import pytest

from workbench.studies.scale.growth import Growth, form, growths, seconds_and_megabytes


@pytest.mark.parametrize("power", [0, 1, 2, 1.5])
def test_the_exponent_is_that_of_the_law_by_which_costs_grow(power):
    sizes = (10, 20, 80)
    growth = Growth("entries", "replay, s", sizes, tuple(3.0 * size**power for size in sizes))
    assert growth.exponents == pytest.approx((power, power))


def test_a_cost_of_nothing_has_no_exponent():
    growth = Growth("entries", "list, ms", (1, 2, 4), (0.0, 1.0, 2.0))
    assert math.isnan(growth.exponents[0]) and growth.exponents[1] == pytest.approx(1.0)
    assert form(growth)["exponents"] == [None, 1.0]


def test_steps_are_compared_that_were_measured_at_every_size():
    found = growths("parts", {4: {"find, s": 2.0, "prove, s": 1.0}, 2: {"find, s": 1.0}})
    assert found == (Growth("parts", "find, s", (2, 4), (1.0, 2.0)),)


def test_memory_that_a_step_gives_back_counts():
    seconds, megabytes = seconds_and_megabytes(lambda: bytearray(b"x" * 2**26))
    assert seconds >= 0.0 and megabytes > 50
