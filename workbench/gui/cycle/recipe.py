"""The recipe by which the cell picks, chosen by number and name."""

from collections.abc import Callable, Mapping
from typing import Any

from workbench.app.core.cell.recipes import ChooseRecipe
from workbench.app.core.state import State
from workbench.gui.shared.visitor import Visitor
from workbench.model.cell import Cell
from workbench.model.recipes.recipe import NO_RECIPE


class RecipeInput:
    """A list of the cell's recipes, which nobody sees where the cell has none.

    Concurrency: any thread.
    """

    def __init__(self, visitor: Visitor, follow: Callable[[Cell], None]):
        """Add the list.

        Args:
            visitor: whose browser.
            follow: called with the cell when another recipe is chosen, whoever has chosen it.
        """
        self._visitor, self._follow = visitor, follow
        cell = visitor.cell
        self._numbers = _recipes(cell)
        # A browser may send anything.
        self._chosen: Any = visitor.gui.add_dropdown(
            "Recipe",
            tuple(self._numbers),
            initial_value=_words(cell),
            visible=bool(cell.recipes),
            hint="Parts, grasps, places, strategy, threshold and speed that belong together. "
            "Parts found and plan are void when another one is chosen.",
        )

        @self._chosen.on_update
        def _(event: Any) -> None:
            # The renderer sets it, too; only a person's hand comes with a browser.
            if event.client is None:
                return
            number = self._numbers.get(str(self._chosen.value), NO_RECIPE)
            is_other = number != visitor.bench.state.cell.recipe
            if is_other and not visitor.ask(lambda: ChooseRecipe(number)):
                self._chosen.value = _words(visitor.bench.state.cell)

    def show(self, old: State | None, new: State) -> None:
        """Show the recipe that is chosen now, whichever way it was chosen."""
        cell = new.cell
        self._numbers = _recipes(cell)
        if self._chosen.options != tuple(self._numbers):
            self._chosen.options = tuple(self._numbers)
        if self._chosen.value != _words(cell):
            self._chosen.value = _words(cell)
        self._chosen.visible = bool(cell.recipes)
        self._visitor.admit(self._chosen, new, ChooseRecipe)
        was = NO_RECIPE if old is None else old.cell.recipe
        if was != cell.recipe:
            self._follow(cell)


def _recipes(cell: Cell) -> Mapping[str, int]:
    """What can be chosen: words -> number."""
    return {"no recipe": NO_RECIPE} | {
        f"{recipe.number} {recipe.name}": recipe.number for recipe in cell.recipes
    }


def _words(cell: Cell) -> str:
    """The words of the recipe that is chosen."""
    return next(words for words, number in _recipes(cell).items() if number == cell.recipe)
