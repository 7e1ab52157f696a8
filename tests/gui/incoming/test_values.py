"""What single fields offer, as values in and words out."""

import math

import pytest

from workbench.gui.incoming.values import number_problem, numbers_problem, text_problem

FIELD = {"low": 5.0, "high": 200.0, "step": 0.5, "digits": 1}


@pytest.mark.parametrize(
    ("value", "problem"),
    [
        (5, ""),
        (200.0, ""),
        (7.3, ""),
        (0.1 + 0.2 + 6.7, ""),
        (7.123, ""),  # it is there already
        (7.123 + 0.5, ""),
        (4.9, "too small"),
        (-1e300, "too small"),
        (200.5, "too large"),
        (7.34, "more digits than are shown"),
        (True, "no number"),
        ("7.3", "no number"),
        (None, "no number"),
        ([7.3], "no number"),
        (math.nan, "no number"),
        (math.inf, "no number"),
        (-math.inf, "no number"),
    ],
)
def test_a_number_is_one_that_can_be_typed_or_stepped_to(value, problem):
    assert number_problem(value, 7.123, **FIELD) == problem


@pytest.mark.parametrize(
    ("value", "problem"),
    [(3, ""), (3.0, ""), (3.5, "not whole"), (1e13, "too large"), (-1e13, "too small")],
)
def test_a_whole_number_stays_one_and_none_is_endless(value, problem):
    assert number_problem(value, 1, low=None, high=None, step=1, digits=0) == problem


def test_bounds_are_offered_whatever_their_digits():
    field = {"low": -2.93215, "high": 2.93215, "step": 0.1, "digits": 1}
    assert number_problem(2.93215, 0.0, **field) == ""
    assert number_problem(2.93216, 0.0, **field) == "too large"


def test_of_several_numbers_those_that_stay_need_no_digits():
    field = {"low": None, "high": None, "step": 0.1, "digits": 1}
    now = (1.23456, 2.0, 3.0)
    assert numbers_problem([1.23456, 2.5, 3.0], now, **field) == ""
    assert numbers_problem([1.23457, 2.5, 3.0], now, **field) == "more digits than are shown"
    for none in ([1.0, 2.0], [1.0, 2.0, 3.0, 4.0], 1.0, "123", None, {}):
        assert numbers_problem(none, now, **field) == "not 3 numbers"
    assert numbers_problem([1.0, None, 3.0], now, **field) == "no number"


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("", ""),
        ("Grüße, 测试 (0.5 mm) 🤖", ""),
        ("copied\tfrom a table", ""),
        ("no-break\u00a0space", ""),
        ("x" * 1000, ""),
        ("x" * 1001, "too long"),
        ("a\0b", "signs that nobody types"),
        ("a\nb", "signs that nobody types"),
        ("\x1b[31m", "signs that nobody types"),
        ("\u202egnp.exe", "signs that nobody types"),
        ("\x85", "signs that nobody types"),
        (5, "no text"),
        (None, "no text"),
        (b"a", "no text"),
    ],
)
def test_a_text_is_what_people_type(text, problem):
    assert text_problem(text) == problem


def test_where_there_are_several_lines_they_may_end():
    assert text_problem("a\nb\r\n" + "x" * 5000, has_lines=True) == ""
    assert text_problem("a\0b", has_lines=True) == "signs that nobody types"
