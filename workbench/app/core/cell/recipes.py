"""Recipes: chosen by number, from then on the cell is by that recipe.

The scan stays.  Detections, plan and approval were made for another cell, and are void.
"""

from dataclasses import dataclass, replace
from typing import ClassVar

from workbench.app.core.cell.changes import Changed, with_cell
from workbench.app.core.command import (
    SAFE,
    Asked,
    Command,
    Decision,
    Entry,
    Right,
    refuse,
    refuse_input,
)
from workbench.app.core.state import State
from workbench.app.core.value_checks import check_integer
from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import as_chosen, kit_of, recipe_of
from workbench.model.derived.by_view import view_name
from workbench.model.messages.cells import KitText, RecipeText
from workbench.model.messages.commands import CommandText
from workbench.model.messages.message import Message
from workbench.model.recipes.kit import KitProgress
from workbench.model.recipes.recipe import HIGHEST_NUMBER, NO_RECIPE


@dataclass(frozen=True, slots=True, eq=False)
class ChooseRecipe(Command):
    """Go on by the recipe of that number; 0: by none, as the cell file states the cell."""

    right: ClassVar[Right] = Right(CommandText.CHOOSE_RECIPE, SAFE)

    number: int

    def check(self, state: State, asked: Asked) -> None:
        check_integer("number", self.number, NO_RECIPE, HIGHEST_NUMBER)
        cell = by_recipe(state, self.number)
        refuse(_kit_problem(state, self.number) or _placed_problem(state, cell))

    def apply(self, state: State, entry: Entry) -> Decision:
        return _choose(state, self.number)


def by_recipe(state: State, number: int) -> Cell:
    """The cell of the state by one of its recipes.

    Raises:
        CommandRefused: there is none of that number, or it does not fit the cell.
    """
    whole = state.whole or state.cell
    with refuse_input():
        if number != NO_RECIPE and recipe_of(whole, number).bin:
            return as_chosen(whole, number)
        return as_chosen(whole, number, state.cell.bin.name, view_name(state.cell))


def _choose(state: State, number: int) -> Changed:
    """The state by another recipe; the recipe that is chosen already voids nothing."""
    whole, message = state.whole or state.cell, _message(state.cell, number)
    if number == state.cell.recipe:
        return replace(state, message=message), ()
    cell = by_recipe(state, number)
    after, effects = with_cell(state, cell, message)
    whole = None if cell.digest == whole.digest else whole
    return replace(after, whole=whole, kit=KitProgress()), effects


def _message(cell: Cell, number: int) -> Message:
    if number == NO_RECIPE:
        return RecipeText.NOT_CHOSEN()
    return RecipeText.CHOSEN(number=number, name=recipe_of(cell, number).name)


def _kit_problem(state: State, number: int) -> Message | None:
    """Why the recipe stays: its kit is being filled; else None."""
    is_begun = bool(kit_of(state.cell) and state.kit.parts)
    return KitText.NOT_TAKEN_AWAY() if is_begun and number != state.cell.recipe else None


def _placed_problem(state: State, cell: Cell) -> Message | None:
    """Why a cell cannot follow: it does not know a part that stands on a pallet; else None."""
    known = {part.name for part in cell.parts}
    strange = next((placed.part for placed in state.placed if placed.part not in known), None)
    return None if strange is None else RecipeText.STILL_PLACED(part=strange)
