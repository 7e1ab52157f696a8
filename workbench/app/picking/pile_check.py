"""Whether a pile can be made, and anything in it be taken at all: asked before it is emptied."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from itertools import cycle, islice

from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.part import Part
from workbench.perception.simulation.room import check_room


def kinds_in_turn(parts: Sequence[Part], count: int) -> tuple[Part, ...]:
    """What falls into a bin: this many parts, of each kind one in turn."""
    return tuple(islice(cycle(parts), count))


def with_kinds(cell: Cell, kinds: Sequence[str]) -> Cell:
    """The cell, picking only these of its parts; all of them where none is named.

    Raises:
        InputError: it does not pick one of them.
    """
    return replace(cell, parts=tuple(map(cell.part, kinds))) if kinds else cell


def check_pile(cell: Cell, count: int) -> None:
    """Look whether this many of a cell's parts can be piled up in its bin and be taken.

    Raises:
        InputError: no parts, more than fit, one larger than the bin, no grasps, or none that any
            tool of the cell can do.
    """
    if not cell.parts:
        raise InputError(f"cell {cell.name} has no part, so there is nothing to drop into its bin")
    check_room(kinds_in_turn(cell.parts, count), cell.bin)
    for part in cell.parts:
        _check_grasps(cell, part)


def _check_grasps(cell: Cell, part: Part) -> None:
    grasps = [grasp for grasp in part.grasps if grasp.is_enabled]
    if not grasps:
        raise InputError(f"part {part.name} has no grasp, so nothing can take it; author one first")
    reasons: Counter[str] = Counter()
    for grasp in grasps:
        for arm in cell.arms:
            low, high = arm.tool.stroke
            if grasp.arms and arm.name not in grasp.arms:
                reasons[f"is for arm {' or '.join(grasp.arms)}"] += 1
            elif grasp.tool and grasp.tool != arm.tool.name:
                reasons[f"is for tool {grasp.tool}, arm {arm.name} carries {arm.tool.name}"] += 1
            elif arm.tool.fingers and not low <= grasp.opening <= high:
                reasons[
                    f"needs an opening of {grasp.opening * 1e3:g} mm, tool {arm.tool.name} opens "
                    f"{low * 1e3:g} to {high * 1e3:g} mm"
                ] += 1
            else:
                return
    why, _ = reasons.most_common(1)[0]
    raise InputError(
        f"no tool of cell {cell.name} fits a grasp of part {part.name}: each of {len(grasps)} "
        f"grasps is refused, most of them so: it {why}"
    )
