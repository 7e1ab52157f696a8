"""Which families are worth their grasps."""

import numpy as np

from workbench.app.filling.keeping import MOST_GRASPS, _greedily


def test_a_family_that_adds_nothing_to_those_before_it_is_left_out():
    odds = np.array([[0.9, 0.9, 0.0], [0.9, 0.9, 0.0], [0.0, 0.0, 0.9]]) + 0.0
    odds[1] *= 0.0
    found = _greedily({0: "a", 1: "b", 2: "c"}, {0: 4, 1: 4, 2: 4}, odds, np.ones(3))
    assert [one.family for one in found] == ["a", "c"]


def test_a_family_of_too_many_grasps_gives_way_to_smaller_ones():
    odds = np.array([[0.9, 0.9, 0.9], [0.9, 0.9, 0.0]])
    found = _greedily({0: "huge", 1: "small"}, {0: MOST_GRASPS + 1, 1: 10}, odds, np.ones(3))
    assert [one.family for one in found] == ["small"]
