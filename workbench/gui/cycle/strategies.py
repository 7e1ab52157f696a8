"""The strategies that a cell offers, in words."""

from collections.abc import Mapping

from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import strategies_of
from workbench.model.messages.plans import strategy_message
from workbench.words.words import IN_ENGLISH, Words


def strategy_words(cell: Cell, words: Words = IN_ENGLISH) -> Mapping[str, str]:
    """What is offered, words for people -> strategy; an arm alone is `right arm only`."""
    return {words.render(strategy_message(strategy)): strategy for strategy in strategies_of(cell)}


def strategy_hint(cell: Cell) -> str:
    """What the offered strategies mean."""
    if len(cell.arms) < 2:
        return "Which arms work: this cell has one."
    return (
        "Which arms work: auto chooses what can be sent, alternated takes one part with each of "
        "two arms in turn, coordinated with two at once; an arm can work alone; both plans "
        "alternated and coordinated and lists them side by side."
    )
