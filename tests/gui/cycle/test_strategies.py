"""What is offered under "Strategy" in a cell."""

import pytest
from three_arms import write_cell

from workbench.formats.cells.reading import read_cell
from workbench.gui.cycle.strategies import strategy_hint, strategy_words


def test_two_arms_are_offered_together_and_each_alone():
    assert strategy_words(read_cell("yumi")) == {
        "auto": "auto",
        "alternated": "alternated",
        "coordinated": "coordinated",
        "right arm only": "right",
        "left arm only": "left",
        "both": "both",
    }


@pytest.mark.parametrize("name", ["manipulator", "right"])
def test_a_cell_with_one_arm_offers_nothing_for_two(tmp_path, name):
    cell = read_cell(write_cell(tmp_path / "cell", (name,)))
    assert strategy_words(cell) == {"auto": "auto", f"{name} arm only": name}
    assert "this cell has one" in strategy_hint(cell)


def test_of_three_arms_each_is_offered_alone(tmp_path):
    cell = read_cell(write_cell(tmp_path / "cell", ("a", "b", "c")))
    alone = [words for words in strategy_words(cell) if words.endswith("only")]
    assert alone == ["a arm only", "b arm only", "c arm only"]
    assert "coordinated with two at once" in strategy_hint(cell)
