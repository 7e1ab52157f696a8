"""The shipped cell that assembles: a bolt in its nest, a spacer in the bin, and the plan for it."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.app.picking.pallets import boxes_around
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.model.cell import Cell
from workbench.model.derived.assembling import rest_pose
from workbench.model.derived.by_recipe import recipe_of, with_recipe
from workbench.model.geometry import pose_from_rpy
from workbench.model.recipes.kit import Insertion
from workbench.model.scan import Detection, Obstacle


def assembly_cell() -> Cell:
    """By its recipe: a spacer over a bolt."""
    return with_recipe(read_cell(find("robots", "yumi") / "assembly.toml"), 1)


def with_insertion(cell: Cell, **changes) -> Cell:
    """The cell whose recipe says something else of how the spacer comes onto the bolt."""
    recipe = recipe_of(cell, cell.recipe)
    bolt, spacer = recipe.items
    assert spacer.insertion is not None
    items = (bolt, replace(spacer, insertion=replace(spacer.insertion, **changes)))
    return replace(cell, recipes=(replace(recipe, items=items),))


def insertion(cell: Cell) -> Insertion:
    found = recipe_of(cell, cell.recipe).items[1].insertion
    assert found is not None
    return found


def standing_spacer(cell: Cell) -> Detection:
    """On its end, in the middle of the bin."""
    return Detection("spacer", cell.bin.T_world_bin * pose_from_rpy((0.0, 0.0, 0.0105)))


def placed_bolt(cell: Cell, T_place_part: pin.SE3 | None = None) -> tuple[Obstacle, ...]:
    """Let go of at the nest, or so much off."""
    T = cell.arm("right").part_places[0].T_world_part
    off = pin.SE3.Identity() if T_place_part is None else T_place_part
    return boxes_around(cell, [Detection("bolt", T * off)])


def moved(cell: Cell, obstacle: Obstacle, T_part: pin.SE3) -> Obstacle:
    """A part of an assembly elsewhere, by a motion in its own frame."""
    T_world_put, T_world_part = obstacle.T_world_put, rest_pose(cell, obstacle)
    T_part_box = T_world_part.actInv(obstacle.T_world_box)
    T_box = T_world_part * T_part * T_part_box
    return replace(obstacle, T_world_put=T_world_put * T_part, T_world_box=T_box)


def turn(axis: str, degrees: float) -> pin.SE3:
    angles = np.deg2rad([degrees if axis == name else 0.0 for name in "xyz"])
    return pose_from_rpy((0.0, 0.0, 0.0), angles)
