"""What a recipe assembles: which parts come onto which others."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import kit_of
from workbench.model.recipes.kit import Insertion
from workbench.model.scan import Obstacle


def assembled_kinds(cell: Cell) -> frozenset[str]:
    """The kinds that come onto another part of the kit, or that others come onto."""
    insertions = [item.insertion for item in kit_of(cell)]
    bases = {insertion.base for insertion in insertions if insertion is not None}
    return frozenset(bases | {item.part for item in kit_of(cell) if item.insertion is not None})


def insertion_of(cell: Cell, part: str) -> Insertion | None:
    """How parts of a kind come onto another one of the kit; None for kinds that do not."""
    return next((item.insertion for item in kit_of(cell) if item.part == part), None)


def assembled_pose(cell: Cell, obstacles: Sequence[Obstacle], part: str) -> pin.SE3 | None:
    """`T_world_part` of the part of a kind that surely is in the assembly; None where none is."""
    return next((rest_pose(cell, box) for box in obstacles if part and box.part == part), None)


def rest_pose(cell: Cell, box: Obstacle) -> pin.SE3:
    """`T_world_part` of a part of an assembly, from the box around it."""
    return box.T_world_box * pin.SE3(np.eye(3), -cell.part(box.part).mesh.middle)
