"""The recipes of a cell file."""

from collections.abc import Iterable, Iterator

import numpy as np

from workbench.formats.cells.places import read_direction
from workbench.formats.files.toml_documents import number, numbers, text
from workbench.formats.files.toml_keys import Table
from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import recipe_problem
from workbench.model.part import DOWN
from workbench.model.recipes.joint import Joint
from workbench.model.recipes.kit import MOST_ITEMS, MOST_OF_ITEM, Insertion, KitItem
from workbench.model.recipes.recipe import HIGHEST_NUMBER, MOST_RECIPES, Recipe

LEAST_CLEARANCE_MM = 0.05
"""What is proven of two parts is exact to this."""

OF_INSERTION = ("position_mm", "insert_mm", "clearance_mm")
ABOUT_INSERTION = ("rpy_deg", "insert_along", "joint", "look_again")
"""Keys that an item with `on` needs, and others that it can have."""

FAR_MM = 2000.0
"""No part of a kit is farther from the one it comes onto."""


def read_recipes(table: Table) -> tuple[Recipe, ...]:
    """The recipes of a cell, no number and no name twice; `check_recipes` compares them with it.

    Args:
        table: of the cell.

    Raises:
        FileError: names the file, the key, its value and what was expected.
    """
    found: list[Recipe] = []
    for recipe in table.tables("recipe"):
        found.append(
            Recipe(
                recipe.whole("number", low=1, high=HIGHEST_NUMBER),
                recipe.text("name"),
                _names(recipe, "parts"),
                _names(recipe, "grasps"),
                _names(recipe, "places"),
                recipe.text("strategy", "", empty=True),
                recipe.number("threshold_mm", 200, low=0, high=1000) / 1000
                if recipe.has("threshold_mm")
                else None,
                recipe.number("speed", 0.5, low=0.01, high=1) if recipe.has("speed") else None,
                _items(recipe),
                recipe.flag("in_order", False),
                recipe.text("bin", "", empty=True),
            )
        )
        if found[-1].in_order and not found[-1].items:
            raise recipe.error("in_order", "says nothing without [[recipe.item]]")
        recipe.finish()
    if len(found) > MOST_RECIPES:
        raise table.error("recipe", f"{len(found)} recipes, {MOST_RECIPES} are allowed")
    table.once("recipe.number", (str(recipe.number) for recipe in found))
    table.once("recipe.name", (recipe.name for recipe in found))
    return tuple(found)


def _items(recipe: Table) -> tuple[KitItem, ...]:
    """What belongs in a kit, no kind twice."""
    found: list[KitItem] = []
    for item in recipe.tables("item"):
        kind, count = item.text("part"), item.whole("count", 1, low=1, high=MOST_OF_ITEM)
        found.append(KitItem(kind, count, _insertion(item)))
        item.finish()
    if len(found) > MOST_ITEMS:
        raise recipe.error("item", f"{len(found)} items, {MOST_ITEMS} are allowed")
    recipe.once("item.part", (item.part for item in found))
    return tuple(found)


def _insertion(item: Table) -> Insertion | None:
    """How a part of a kit comes onto another one; None where it comes onto none."""
    base = item.text("on", "", empty=True)
    for key in (*OF_INSERTION, *ABOUT_INSERTION):
        if item.has(key) and not base:
            raise item.error(key, "is about a part that comes onto another one: `on` is expected")
        if base and key in OF_INSERTION and not item.has(key):
            raise item.error(key, "is missing; `on` needs it")
    if not base:
        return None
    x, y, z = (item.numbers("position_mm", 3, [0, 0, 0], low=-FAR_MM, high=FAR_MM) / 1000).tolist()
    a, b, c = np.deg2rad(item.numbers("rpy_deg", 3, [0, 0, 0], low=-360, high=360)).tolist()
    length = item.number("insert_mm", 50, low=1, high=500) / 1000
    return Insertion(
        base,
        (x, y, z),
        (a, b, c),
        read_direction(item, "insert_along", DOWN),
        length,
        item.number("clearance_mm", 0.5, low=LEAST_CLEARANCE_MM, high=100) / 1000,
        _joint(item.table("joint"), length) if item.has("joint") else None,
        item.flag("look_again", False),
    )


def _joint(table: Table, length: float) -> Joint:
    """What a joint tolerates; the insertion goes over the length [m]."""
    x, y, z = (table.numbers("mouth_mm", 3, low=-FAR_MM, high=FAR_MM) / 1000).tolist()
    depth = table.number("depth_mm", low=0.1, high=500)
    if depth > length * 1000:
        raise table.error(
            "depth_mm",
            f"{depth:g} is more than insert_mm, {length * 1000:g}; the insertion begins before the "
            "parts meet",
        )
    part, base = (
        min(table.number(key, depth, low=0.1, high=500), depth)
        for key in ("part_length_mm", "base_length_mm")
    )
    if part + base < depth:
        raise table.error("depth_mm", f"{depth:g} brings the part past its base")
    joint = Joint(
        (x, y, z),
        depth / 1000,
        part / 1000,
        base / 1000,
        table.number("radial_clearance_mm", low=0.001, high=20) / 1000,
        table.number("chamfer_mm", 0, low=0, high=50) / 1000,
        table.number("compliance_mm", 0, low=0, high=20) / 1000,
        table.number("share", 0.95, low=0.01, high=0.999),
    )
    table.finish()
    return joint


def check_recipes(table: Table, cell: Cell) -> None:
    """Whether parts, grasps, places and strategies of all recipes are those of the cell.

    Raises:
        FileError: one names what the cell does not have; names the recipe and what there is.
    """
    for recipe in cell.recipes:
        if problem := recipe_problem(cell, recipe):
            key, why = problem
            raise table.error(f"recipe.{key}", f"recipe {recipe.number} {recipe.name}: {why}")


def recipe_lines(recipe: Recipe) -> Iterator[str]:
    """A recipe as the cell file has it."""
    yield from ("", "[[recipe]]", f"number = {recipe.number}", f"name = {text(recipe.name)}")
    for key in ("parts", "grasps", "places"):
        if names := getattr(recipe, key):
            yield f"{key} = {_list(names)}"
    if recipe.strategy:
        yield f"strategy = {text(recipe.strategy)}"
    if recipe.threshold is not None:
        yield f"threshold_mm = {number(recipe.threshold * 1000)}"
    if recipe.speed is not None:
        yield f"speed = {number(recipe.speed)}"
    if recipe.bin:
        yield f"bin = {text(recipe.bin)}"
    if recipe.in_order:
        yield "in_order = true"
    for item in recipe.items:
        yield from ("", "[[recipe.item]]", f"part = {text(item.part)}", f"count = {item.count}")
        if item.insertion is not None:
            yield from _insertion_lines(item.insertion)


def _insertion_lines(insertion: Insertion) -> Iterator[str]:
    yield f"on = {text(insertion.base)}"
    yield f"position_mm = {numbers(np.array(insertion.position) * 1000)}"
    yield f"rpy_deg = {numbers(np.rad2deg(insertion.rpy))}"
    yield f"insert_along = {numbers(insertion.along)}"
    yield f"insert_mm = {number(insertion.length * 1000)}"
    yield f"clearance_mm = {number(insertion.clearance * 1000)}"
    if insertion.look_again:
        yield "look_again = true"
    if (joint := insertion.joint) is not None:
        yield from (
            "",
            "[recipe.item.joint]",
            f"mouth_mm = {numbers(np.array(joint.mouth) * 1000)}",
        )
        yield f"depth_mm = {number(joint.depth * 1000)}"
        yield f"part_length_mm = {number(joint.part_length * 1000)}"
        yield f"base_length_mm = {number(joint.base_length * 1000)}"
        yield f"radial_clearance_mm = {number(joint.clearance * 1000)}"
        yield f"chamfer_mm = {number(joint.chamfer * 1000)}"
        yield f"compliance_mm = {number(joint.compliance * 1000)}"
        yield f"share = {number(joint.share)}"


def _names(table: Table, key: str) -> tuple[str, ...]:
    """Names, at least one and none twice; empty where the key is not there."""
    names = table.texts(key, ())
    if table.has(key) and not names:
        raise table.error(key, "names nothing; leave the key out to keep what the cell has")
    table.once(key, names)
    return names


def _list(names: Iterable[str]) -> str:
    return f"[{', '.join(map(text, names))}]"
