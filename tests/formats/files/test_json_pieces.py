"""JSON made piece by piece says what it says when made in one go."""

import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from workbench.formats.files.json_pieces import encode_json, pieces

PLAIN = st.none() | st.booleans() | st.integers() | st.floats(allow_nan=False) | st.text()
VALUES = st.recursive(
    PLAIN, lambda inner: st.lists(inner) | st.dictionaries(st.text(), inner), max_leaves=60
)


def in_one_go(value):
    return json.dumps(value, ensure_ascii=False, separators=(",", ":"))


@given(VALUES)
def test_it_is_the_same_as_in_one_go(value):
    assert "".join(pieces(value, in_one_go, 0)) == in_one_go(value)
    assert encode_json(value, allow_nan=True).decode("utf-8", "surrogatepass") == in_one_go(value)


@pytest.mark.parametrize("value", [{1: "a"}, {None: [1]}, [(1, 2), {"a": (3,)}], (), [], {}])
def test_keys_and_rows_that_json_has_no_word_for_are_as_usual(value):
    assert encode_json(value).decode() == in_one_go(value)


def test_a_number_that_is_none_is_refused_unless_it_may_be():
    for value in (float("nan"), [[float("inf")]], {"a": {"b": {"c": float("nan")}}}):
        with pytest.raises(ValueError):
            encode_json(value)
        assert json.loads(encode_json(value, allow_nan=True)) is not None


def test_no_piece_of_many_candidates_is_large():
    candidate = {"verdict": {"q": [0.123456789] * 7, "note": "x" * 100}, "T": [[1.0] * 4] * 4}
    for value in ([candidate] * 5000, {"result": {"plan": {"candidates": [candidate] * 5000}}}):
        assert max(len(piece) for piece in pieces(value, in_one_go, 0)) < 1000
