"""A change of the code that is not meant to change plans changes none."""

import pytest
from make_plans import SCENES, cell_of, kept, planned


@pytest.mark.parametrize("name", SCENES)
def test_the_plans_are_those_of_before(name):
    cell = cell_of(name)
    scenes = [one for one in kept() if one[0] == name]
    assert len(scenes) == SCENES[name][2]
    other = [seed for _, seed, pile, before in scenes if planned(cell, pile, seed) != before]
    assert other == [], f"seeds of {name} whose plan is another one"
