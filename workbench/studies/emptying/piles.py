"""A pile of the study, by the name of its cell: what a worker anywhere is given."""

from dataclasses import replace
from functools import lru_cache

from workbench.app.emptying import empty
from workbench.app.emptying.changes import apply_change
from workbench.app.picking.pile_check import check_pile, kinds_in_turn
from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import as_chosen
from workbench.model.messages.message import Message
from workbench.model.prediction import TOGETHER, EmptiedPile, PileTask
from workbench.model.recipes.recipe import NO_RECIPE
from workbench.model.scan import ALL_KINDS, SearchOverrides
from workbench.perception.simulation.piles import drop_parts
from workbench.perception.simulation.synthesize import synthesize
from workbench.planning.collision.world import World
from workbench.planning.picking.propose import propose
from workbench.plugins.localizer import find_parts


def cell_of(name: str, part: str, recipe: int = NO_RECIPE, bin: str = "") -> Cell:
    """The cell by its recipe of that number and that bin, picking what `PileTask.part` names.

    Raises:
        InputError: cell or part cannot be read, or there is no such recipe or bin.
    """
    cell = as_chosen(read_cell(name), recipe, bin)
    if part in ("", ALL_KINDS):
        return cell if part or recipe else replace(cell, parts=cell.parts[:1])
    known = {known_part.name: known_part for known_part in cell.parts}
    kinds = (known[kind] if kind in known else read_part(kind) for kind in part.split(TOGETHER))
    return replace(cell, parts=tuple(kinds), recipe=NO_RECIPE)


def check_task(task: PileTask) -> None:
    """Look whether a pile can be made and anything in it be taken at all.

    Raises:
        InputError: cell or part cannot be read, or see `check_pile`.
    """
    check_pile(cell_of(task.cell, task.part, task.recipe, task.bin), task.count)


def empty_pile(task: PileTask) -> EmptiedPile:
    """Drop a pile and empty it; see `app.emptying.empty`."""
    cell = _warm(task.cell, task.part, task.seen, task.change, task.recipe, task.bin)
    pile = empty.fallen(cell_of(task.cell, task.part, task.recipe, task.bin), cell, task)
    return empty.empty_pile(cell, task, pile, estimates=not task.change)


@lru_cache(maxsize=4)
def _warm(name: str, part: str, seen: str, change: Message | None, recipe: int, bin: str) -> Cell:
    """The cell, after one plan: compiled code is loaded before a clock runs."""
    cell = apply_change(cell_of(name, part, recipe, bin), change)
    pile = drop_parts(kinds_in_turn(cell, 2), cell.bin, seed=0)
    if seen == "scan":
        scan = synthesize(cell, pile, seed=0)
        find_parts(scan, cell, seed=0, detail=SearchOverrides().detail)
    plan_pick(cell, pile, "warm")
    propose(World(cell, pile))  # also spares, which that plan did not need
    return cell
