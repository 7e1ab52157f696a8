"""What is offered under "Strategy" in a cell."""

import pytest
from three_arms import write_cell

from workbench.formats.cells.reading import read_cell
from workbench.gui.cycle.strategies import strategy_hint, strategy_words
from workbench.model.cell import ORDER_NAMES
from workbench.model.messages.changes import ChangeKindText
from workbench.model.messages.plans import OrderText
from workbench.model.prediction import CHANGE_KINDS
from workbench.words.catalogs import LANGUAGES
from workbench.words.words import words_of


def test_two_arms_are_offered_together_and_each_alone():
    assert strategy_words(read_cell("yumi")) == {
        "auto": "auto",
        "alternated": "alternated",
        "coordinated": "coordinated",
        "right arm only": "right",
        "left arm only": "left",
        "both": "both",
    }


def test_each_strategy_is_offered_in_the_language_of_who_chooses():
    assert strategy_words(read_cell("yumi"), words_of("de")) == {
        "auto": "auto",
        "abwechselnd": "alternated",
        "gemeinsam": "coordinated",
        "nur Arm rechts": "right",
        "nur Arm links": "left",
        "beide": "both",
    }


@pytest.mark.parametrize("kind, names", [(OrderText, ORDER_NAMES), (ChangeKindText, CHANGE_KINDS)])
def test_each_choice_of_a_list_has_a_text_in_every_language(kind, names):
    assert tuple(str(text()) for text in kind) == names
    for language in LANGUAGES:
        said = [words_of(language).say(name) for name in names]
        assert len(set(said)) == len(names), language
        assert language == "en" or said.count("order") + said.count("travel") == 0, language


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
