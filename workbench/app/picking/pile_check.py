"""Whether a pile can be made, and anything in it be taken at all: asked before it is emptied."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace

from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import kit_of, parts_in_turn
from workbench.model.derived.by_tcp import has_tcp
from workbench.model.errors import InputError
from workbench.model.messages.message import Message
from workbench.model.messages.parts import PileText
from workbench.model.part import Part
from workbench.model.recipes.recipe import NO_RECIPE
from workbench.model.scan import ALL_KINDS
from workbench.perception.simulation.room import check_room


def kinds_in_turn(cell: Cell, count: int) -> tuple[Part, ...]:
    """What falls into a bin: this many parts, of each kind one in turn, or what kits consist of."""
    return parts_in_turn(cell, "" if kit_of(cell) else ALL_KINDS, count)


def with_kinds(cell: Cell, kinds: Sequence[str]) -> Cell:
    """The cell, picking only these of its parts, without a kit; as it is where none is named.

    Raises:
        InputError: it does not pick one of them.
    """
    if not kinds:
        return cell
    return replace(cell, parts=tuple(map(cell.part, kinds)), recipe=NO_RECIPE)


def check_pile(cell: Cell, count: int) -> None:
    """Check that this many parts of a cell fit into its bin and have usable grasps.

    Raises:
        InputError: no parts, too many parts, or a part larger than the bin; or a part needs
            grasps, and no tool of the cell can do any.
    """
    if not cell.parts:
        raise InputError(PileText.NO_PART(cell=cell.name))
    check_room(kinds_in_turn(cell, count), cell.bin)
    for part in cell.parts:
        _check_grasps(cell, part)


def _check_grasps(cell: Cell, part: Part) -> None:
    if part.library.searches:
        return
    grasps = [grasp for grasp in part.grasps if grasp.is_enabled]
    if not grasps:
        raise InputError(PileText.NO_GRASP(part=part.name))
    reasons: Counter[Message] = Counter()
    for grasp in grasps:
        for arm in cell.arms:
            low, high = arm.tool.stroke
            if grasp.arms and arm.name not in grasp.arms:
                reasons[PileText.FOR_ARM(arms=sorted(grasp.arms))] += 1
            elif grasp.tool and grasp.tool != arm.tool.name:
                carried = {"arm": arm.name, "carried": arm.tool.name}
                reasons[PileText.FOR_TOOL(tool=grasp.tool, **carried)] += 1
            elif not has_tcp(arm.tool, grasp.tcp):
                reasons[PileText.FOR_TCP(tcp=grasp.tcp, tool=arm.tool.name)] += 1
            elif arm.tool.fingers and not low <= grasp.opening <= high:
                stroke = {"tool": arm.tool.name, "low": low, "high": high}
                reasons[PileText.OPENING(opening=grasp.opening, **stroke)] += 1
            else:
                return
    why, _ = reasons.most_common(1)[0]
    raise InputError(PileText.NO_TOOL(cell=cell.name, part=part.name, count=len(grasps), why=why))
