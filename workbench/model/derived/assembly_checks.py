"""Why a recipe cannot be assembled in a cell."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.messages.cells import AssemblyText
from workbench.model.messages.message import Message
from workbench.model.recipes.kit import Insertion, KitItem
from workbench.model.recipes.recipe import Recipe

LEAST_RISE = 0.01
"""An insertion that rises by less than this share of its length comes from the side."""

OUTSIDE = 0.005
"""[m] The mouth of a joint is no farther outside of the box around its base."""

Items = dict[str, KitItem]
"""Items of a recipe by their kinds."""


def assembly_problem(cell: Cell, recipe: Recipe) -> Message | None:
    """Why the items of a recipe cannot be assembled in a cell; None where they can."""
    before: Items = {}
    for item in recipe.items:
        problem = None if item.insertion is None else _item_problem(recipe, item, before)
        if problem is not None:
            return problem
        before[item.part] = item
    if not any(item.insertion for item in recipe.items):
        return None
    passing = next((arm.name for arm in cell.arms if arm.passes_parts_on), None)
    if passing is not None:
        return AssemblyText.PASSED_ON(arm=passing)
    return next(filter(None, (_stand_problem(cell, recipe, item) for item in recipe.items)), None)


def _item_problem(recipe: Recipe, item: KitItem, before: Items) -> Message | None:
    """Why an item cannot come onto what it names."""
    assert item.insertion is not None
    base = item.insertion.base
    if item.part in _beneath(recipe, base):
        return AssemblyText.CIRCLE(part=item.part, base=base)
    if base not in before:
        return AssemblyText.NOT_EARLIER(part=item.part, base=base)
    for each in (item, before[base]):
        if each.count != 1:
            return AssemblyText.COUNT(part=each.part, count=each.count)
    if not item.insertion.look_again:
        return None
    # A scan compares the base with its own shape, which another part on it changes.
    for other in before.values():
        if other.insertion is not None and other.insertion.base == base:
            return AssemblyText.SEEN_BENEATH(part=item.part, base=base, other=other.part)
    return None


def _beneath(recipe: Recipe, part: str) -> list[str]:
    """A kind, that which it is on, that which this is on, and so on; none twice."""
    on = {item.part: item.insertion.base for item in recipe.items if item.insertion is not None}
    found: list[str] = []
    while part and part not in found:
        found.append(part)
        part = on.get(part, "")
    return found


def _stand_problem(cell: Cell, recipe: Recipe, item: KitItem) -> Message | None:
    """Why an item cannot be put onto its base wherever that stands."""
    insertion = item.insertion
    if insertion is None:
        return None
    poses = list(_poses(cell, recipe, insertion.base))
    if not poses:
        return AssemblyText.NO_PLACE(base=insertion.base)
    if any((R @ insertion.along)[2] > LEAST_RISE for R in (T.rotation for T in poses)):
        return AssemblyText.FROM_BELOW(part=item.part, base=insertion.base)
    return _joint_problem(cell, item.part, insertion)


def _joint_problem(cell: Cell, kind: str, insertion: Insertion) -> Message | None:
    """Why a joint is none of the two parts."""
    joint, base = insertion.joint, cell.part(insertion.base).mesh.points
    if joint is None:
        return None
    low, high = base.min(axis=0) - joint.mouth, base.max(axis=0) - joint.mouth
    away = float(np.maximum(np.maximum(low, -high), 0.0).max())
    if away > OUTSIDE:
        return AssemblyText.MOUTH(base=insertion.base, away=away)
    along = insertion.T_base_part.rotation.T @ insertion.along
    points = cell.part(kind).mesh.points
    across = points - np.outer(points @ along, along)
    half = float(np.linalg.norm(across - across.mean(axis=0), axis=1).max())
    if joint.chamfer >= half:
        return AssemblyText.CHAMFER(chamfer=joint.chamfer, part=kind, half=half)
    return None


def _poses(cell: Cell, recipe: Recipe, kind: str) -> Iterator[pin.SE3]:
    """Where a kind may stand, as T_world_part: at places of arms, or on its base there."""
    (insertion,) = (item.insertion for item in recipe.items if item.part == kind)
    if insertion is not None:
        for T_world_base in _poses(cell, recipe, insertion.base):
            yield T_world_base * insertion.T_base_part
        return
    for arm in cell.arms:
        for place in arm.places_for(kind):
            if not recipe.places or place.name in recipe.places:
                yield place.T_world_part
