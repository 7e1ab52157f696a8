"""Families of grasps for parts that stayed in the bin, from where they lay."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.app.filling.clearing import add_family, takes
from workbench.app.filling.fill import check_mesh, rank_entries
from workbench.app.filling.hand import hands_for
from workbench.app.filling.keeping import select_families
from workbench.app.filling.work import WORK, WORLD, Work
from workbench.app.statistics.remaining import RemainingPart
from workbench.model.cell import Cell
from workbench.model.messages.work import ProgressText
from workbench.model.part import Entry
from workbench.planning.collision.world import World
from workbench.plugins.progress import Cancelled, Report, silent
from workbench.plugins.progress import never as nobody

MOST_WORK = WORK / 4
"""Points of work: some fifteen seconds."""


@dataclass(frozen=True, slots=True, eq=False)
class Proposal:
    """New `entries`, the most useful first, for parts of which `looked` were examined.

    The library takes `known` of them already, the entries take `added` more.
    """

    entries: tuple[Entry, ...]
    looked: int
    known: int
    added: int


def families_for(
    cell: Cell,
    name: str,
    left: Sequence[RemainingPart],
    *,
    most: float = MOST_WORK,
    report: Report = silent,
    cancelled: Cancelled = nobody,
) -> Proposal:
    """The families of grasps that take parts of one kind which no candidate could take.

    Args:
        cell: with its parts as they are now; their libraries count.
        name: of the kind.
        left: parts that stayed; those of other kinds, or among kinds that are gone, are left out.
        most: points of work after which it ends.
        report: takes the share done and what is being done.
        cancelled: asked now and then; True ends it.

    Raises:
        InputError: the mesh is inside out.
        JobCancelled: `cancelled` said so.
    """
    part = cell.part(name)
    check_mesh(part)
    # The first part of a cell is the one whose families are weighed.
    others = tuple(other for other in cell.parts if other.name != name)
    cell = replace(cell, parts=(part, *others))
    kinds = {other.name for other in cell.parts}
    work = Work(most, report, cancelled)
    hands = hands_for(cell, part, 0, work)
    known = {id(family) for hand in hands for family in hand.families}
    rng = np.random.default_rng(0)
    looked = count = added = 0
    # The latest first: the cell was as it is now.
    for remaining in reversed(left):
        if work.is_over() or not hands:
            break
        if remaining.part != name or any(
            detection.part not in kinds for detection in remaining.pile
        ):
            continue
        world = World(cell, remaining.pile)
        work.add(WORLD * len(remaining.pile) * len(part.pieces))
        looked += 1
        family = takes(hands, world, remaining.number, 0, rng)
        if family is None:
            taken_anew = add_family(hands, world, remaining.number, 0, rng) is None
        else:
            taken_anew = id(family) not in known
            count += not taken_anew
        added += taken_anew
        work.note = ProgressText.ADDED(added=added, looked=looked)
    worth = select_families(cell, hands, known, 0) if hands else []
    return Proposal(tuple(rank_entries(part, worth)), looked, count, added)
