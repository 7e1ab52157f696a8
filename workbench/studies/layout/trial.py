"""Whether a cell that was laid out takes parts of a pile, as `workbench demo` would."""

from dataclasses import replace

from workbench.app.picking.pipeline import plan_pick
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.perception.simulation.piles import drop_parts

DEMO_PARTS, DEMO_SEED = 2, 0
"""The pile with which `workbench demo` begins."""

LONGEST_PLANNING = 8.0
"""[s] Of processor time for a plan: where one takes longer, another bin is better."""


def takes_parts(cell: Cell) -> bool:
    """Whether there is a proven plan for a simulated pile of the cell's first part.

    By its library alone: where plans have to search grips, the bin is badly placed.
    """
    parts = tuple(replace(p, library=replace(p.library, searches=False)) for p in cell.parts)
    try:
        pile = drop_parts(parts[:1] * DEMO_PARTS, cell.bin, seed=DEMO_SEED)
    except InputError:  # the bin is too small for the part
        return False
    if not pile:
        return False
    hasty = replace(cell, parts=parts, policy=replace(cell.policy, seconds=LONGEST_PLANNING))
    return plan_pick(hasty, pile, "").is_proven
