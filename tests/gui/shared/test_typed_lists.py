"""Lists of numbers as people type them."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.gui.shared.typed_lists import numbers_in, shown_numbers
from workbench.model.errors import InputError


@pytest.mark.parametrize(
    ("text", "numbers"),
    [
        ("0, 72, 144", (0, 72, 144)),
        ("0 72  144", (0, 72, 144)),
        ("5 x 72", (0, 72, 144, 216, 288)),
        ("3x13 from -28", (-28, -15, -2)),
        ("-.5", (-0.5,)),
        (" 2 x -4.5 from 1 ", (1, -3.5)),
    ],
)
def test_what_people_type(text, numbers):
    assert numbers_in(text, "around") == pytest.approx(numbers)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "a",
        "1,,x",
        "0 x 3",
        "2000 x 1",
        "nan",
        "inf",
        "1e9",
        "5 x",
        "1 2 ;",
        "9" * 5000 + " x 1",
    ],
)
def test_what_is_no_list_is_refused_in_words(text):
    with pytest.raises(InputError, match="around: "):
        numbers_in(text, "around")


@given(st.lists(st.floats(-360, 360).map(lambda v: round(v, 2)), min_size=1, max_size=9))
def test_what_is_shown_can_be_typed(values):
    assert numbers_in(shown_numbers(tuple(values)), "x") == pytest.approx(values, abs=1e-2)


def test_even_steps_are_shown_as_such():
    assert shown_numbers((0.0, 72.0, 144.0, 216.0, 288.0)) == "5 x 72"
    assert shown_numbers((-28.0, -15.0, -2.0)) == "3 x 13 from -28"
    assert shown_numbers((0.0, 5.0)) == "0, 5"
