"""A cell by one of its recipes, and why a recipe does not fit a cell."""

from collections.abc import Mapping
from dataclasses import replace
from itertools import cycle, islice

from workbench.model.cell import Arm, Cell
from workbench.model.derived.assembly_checks import assembly_problem
from workbench.model.derived.by_bin import with_bin
from workbench.model.derived.by_view import with_view
from workbench.model.errors import InputError
from workbench.model.messages.cells import RecipeText
from workbench.model.messages.message import Message
from workbench.model.messages.parts import PileText
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.part import Entry, Part
from workbench.model.part_edits import grasp_of, with_grasp
from workbench.model.recipes.kit import KitItem, Wanted, lacking
from workbench.model.recipes.recipe import NO_RECIPE, Recipe, names_of
from workbench.model.scan import ALL_KINDS


def strategies_of(cell: Cell) -> tuple[str, ...]:
    """What can be asked for in a cell: words, and its arms by name, each of which works alone.

    `auto` takes what the controller can run; `both` plans with two arms one after the other and at
    once, and compares.
    """
    arms = tuple(arm.name for arm in cell.arms)
    if len(arms) < 2:
        return ("auto", *arms)
    return ("auto", "alternated", "coordinated", *arms, "both")


def check_strategy(cell: Cell, strategy: str) -> None:
    """Look whether a strategy says anything about a cell.

    One for two arms does so in a cell with one: that none comes of it is the verdict of planning.

    Raises:
        InputError: it is neither a word for strategies nor the name of an arm of the cell.
    """
    if strategy not in (*strategies_of(cell), "alternated", "coordinated", "both"):
        raise InputError(
            ChangeRefusal.STRATEGY(
                strategy=f"{strategy!r:.60}", known=strategies_of(cell), cell=cell.name
            )
        )


def recipe_of(cell: Cell, number: int) -> Recipe:
    """The recipe of that number.

    Raises:
        InputError: there is none; the message lists those there are.
    """
    for recipe in cell.recipes:
        if recipe.number == number:
            return recipe
    known = [f"{recipe.number} {recipe.name}" for recipe in cell.recipes]
    if not known:
        raise InputError(RecipeText.NONE(cell=cell.name))
    raise InputError(RecipeText.UNKNOWN(cell=cell.name, number=number, known=known))


def with_recipe(cell: Cell, number: int) -> Cell:
    """A cell as its file states it, by its recipe of that number; `NO_RECIPE`: the cell itself.

    Parts that the recipe does not name are gone, grasps are disabled, and places are gone.

    Raises:
        InputError: there is no such recipe, or it does not fit the cell.
    """
    if number == NO_RECIPE:
        return cell
    recipe = recipe_of(cell, number)
    if problem := recipe_problem(cell, recipe):
        raise InputError(RecipeText.MISFIT(number=number, name=recipe.name, problem=problem[1]))
    policy = cell.policy
    if recipe.threshold is not None:
        policy = replace(policy, threshold=recipe.threshold)
    if recipe.speed is not None:
        policy = replace(policy, speed=recipe.speed)
    return replace(
        with_bin(cell, recipe.bin),
        parts=tuple(_part(part, recipe) for part in _parts(cell, recipe)),
        arms=tuple(_arm(arm, recipe) for arm in cell.arms),
        policy=policy,
        recipe=number,
    )


def as_chosen(cell: Cell, recipe: int, bin: str = "", view: str = "") -> Cell:
    """A cell as its file states it, by a recipe, a bin and a view of its scanner on an arm.

    Without a name it is the recipe's bin, and the first view of that.

    Raises:
        InputError: there is no such recipe, bin or view, or the recipe does not fit the cell.
    """
    return with_view(with_bin(with_recipe(cell, recipe), bin), view)


def strategy_of(cell: Cell) -> str:
    """The strategy of a planning for which nobody names one: the recipe's, or `auto`."""
    if cell.recipe == NO_RECIPE:
        return "auto"
    return recipe_of(cell, cell.recipe).strategy or "auto"


def kit_of(cell: Cell) -> tuple[KitItem, ...]:
    """What belongs in a kit by the recipe that is chosen; empty where nobody fills kits."""
    return () if cell.recipe == NO_RECIPE else recipe_of(cell, cell.recipe).items


def wanted_parts(cell: Cell, counts: Mapping[str, int] | None = None) -> Wanted | None:
    """What a kit lacks that has these parts by kind; None where nobody fills kits: everything."""
    items = kit_of(cell)
    if not items:
        return None
    # A part is put onto another one only when that is there.
    in_order = recipe_of(cell, cell.recipe).in_order or any(item.insertion for item in items)
    return Wanted(lacking(items, counts or {}), in_order)


def parts_in_turn(cell: Cell, kind: str, count: int) -> tuple[Part, ...]:
    """This many parts: of a kind, or with `ALL_KINDS` one of each kind in turn.

    When the kind is empty they are what kits consist of, or without a kit of the first kind.

    Raises:
        InputError: the cell has no part, or none of that kind.
    """
    if not cell.parts:
        raise InputError(PileText.NO_PART(cell=cell.name))
    kit = tuple(cell.part(item.part) for item in kit_of(cell) for _ in range(item.count))
    if kind == ALL_KINDS:
        kinds = cell.parts
    else:
        kinds = kit if kit and not kind else (cell.part(kind or cell.parts[0].name),)
    return tuple(islice(cycle(kinds), count))


def recipe_problem(cell: Cell, recipe: Recipe) -> tuple[str, Message] | None:
    """The key of a recipe that does not fit a cell, and why; None where all of it does."""
    kinds = tuple(part.name for part in cell.parts)
    for name in recipe.parts:
        if name not in kinds:
            return "parts", RecipeText.NO_PART(part=name, known=kinds)
    picked = recipe.parts or kinds
    for item in recipe.items:
        if item.part not in picked:
            return "item", RecipeText.NOT_PICKED(part=item.part, known=picked)
    if recipe.strategy and recipe.strategy not in strategies_of(cell):
        text = RecipeText.NO_STRATEGY(strategy=recipe.strategy, known=strategies_of(cell))
        return "strategy", text
    bins = tuple(box.name for box in cell.bins)
    if recipe.bin and recipe.bin not in bins:
        return "bin", RecipeText.NO_BIN(bin=recipe.bin, known=bins)
    if problem := assembly_problem(cell, recipe):
        return "item", problem
    return _grasp_problem(cell, recipe) or _place_problem(cell, recipe)


def _grasp_problem(cell: Cell, recipe: Recipe) -> tuple[str, Message] | None:
    parts = _parts(cell, recipe)
    known = tuple(dict.fromkeys(entry.name for part in parts for entry in part.library.entries))
    for name in recipe.grasps:
        if name not in known:
            return "grasps", RecipeText.NO_GRASP(grasp=name, known=known)
    for part in parts if recipe.grasps else ():
        if not any(_is_enabled(entry, recipe) for entry in part.library.entries):
            return "grasps", RecipeText.PART_WITHOUT_GRASP(part=part.name)
    return None


def _place_problem(cell: Cell, recipe: Recipe) -> tuple[str, Message] | None:
    known = tuple(dict.fromkeys(filter(None, (name for arm in cell.arms for name in _places(arm)))))
    for name in recipe.places:
        if name not in known:
            return "places", RecipeText.NO_PLACE(place=name, known=known)
    for arm in cell.arms if recipe.places else ():
        # An arm without any place brings parts home.
        if _places(arm) and not set(_places(arm)) & set(recipe.places):
            return "places", RecipeText.ARM_WITHOUT_PLACE(arm=arm.name)
    return None


def _places(arm: Arm) -> tuple[str, ...]:
    """The name of each place of an arm, empty where it has none."""
    of_tool = names_of(len(arm.Ts_world_place), arm.place_names)
    return (*of_tool, *(place.name for place in arm.part_places))


def _parts(cell: Cell, recipe: Recipe) -> tuple[Part, ...]:
    return tuple(part for part in cell.parts if part.name in recipe.parts or not recipe.parts)


def _is_enabled(entry: Entry, recipe: Recipe) -> bool:
    return grasp_of(entry).is_enabled and entry.name in recipe.grasps


def _part(part: Part, recipe: Recipe) -> Part:
    if not recipe.grasps:
        return part
    entries = tuple(
        entry if _is_enabled(entry, recipe) else _disable(entry) for entry in part.library.entries
    )
    return replace(part, library=replace(part.library, entries=entries, searches=False))


def _disable(entry: Entry) -> Entry:
    return with_grasp(entry, replace(grasp_of(entry), is_enabled=False))


def _arm(arm: Arm, recipe: Recipe) -> Arm:
    if not recipe.places:
        return arm
    names = names_of(len(arm.Ts_world_place), arm.place_names)
    stay = [k for k, name in enumerate(names) if name in recipe.places]
    return replace(
        arm,
        Ts_world_place=tuple(arm.Ts_world_place[k] for k in stay),
        place_names=tuple(names[k] for k in stay),
        part_places=tuple(place for place in arm.part_places if place.name in recipe.places),
    )
