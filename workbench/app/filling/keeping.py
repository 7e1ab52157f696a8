"""The fewest of some families that take what all of them take."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.app.filling.families import Family
from workbench.app.filling.hand import Hand
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.part import GraspLibrary, Part
from workbench.model.part import with_symmetry as multiplied
from workbench.planning.collision.surroundings import Surroundings
from workbench.planning.collision.tool_check import ToolCheck

TAKEN, FITTING = 0.95, 0.5
"""How surely a family takes a part that it took, and one that its hand only fits at."""

CASES = 80
"""Parts that were taken by which families are weighed."""

MOST_GRASPS = 170
"""Grasps of all families, at most, those counted that the part's symmetry makes."""

ADDS = 0.004
"""Share of the parts that a family has to add."""

EACH = 25
"""Grasps by which a family is dearer for being one more."""


@dataclass(frozen=True, slots=True)
class Kept:
    """A family, and what share of the parts it adds to those before it."""

    family: Family
    adds: float


def select_families(cell: Cell, hands: Sequence[Hand], known: set[int], seed: int) -> list[Kept]:
    """Those of the new families that are worth their grasps, what adds most for them first.

    Args:
        cell: that the parts lay in; the symmetry of its part multiplies grasps.
        hands: with their families.
        known: ids of families that stay whatever they add.
        seed: of which parts are weighed.
    """
    families = [(hand, family) for hand in hands for family in hand.families]
    cases = [(family, case) for _, family in families for case in family.took]
    if not cases:
        return []
    some = np.random.default_rng(seed).permutation(len(cases))[:CASES]
    odds = np.zeros((len(families), len(some)))
    for column, k in enumerate(some.tolist()):
        by, (pile, number) = cases[k]
        tools = ToolCheck(Surroundings(cell, pile))
        for row, (hand, family) in enumerate(families):
            if by is family:
                odds[row, column] = TAKEN
            elif hand.fits(family, tools, number):
                odds[row, column] = FITTING
    left = np.ones(len(some))
    for row, (_, family) in enumerate(families):
        if id(family) in known:
            left *= 1.0 - odds[row]
    new = {row: family for row, (_, family) in enumerate(families) if id(family) not in known}
    part = cell.parts[0]
    costs = {row: _count(part, family) for row, family in new.items()}
    return _greedily(new, costs, odds, left)


def _greedily(
    new: dict[int, Family], costs: dict[int, int], odds: Floats, left: Floats
) -> list[Kept]:
    """The families by what they add for each of their grasps; `left` (n,) is what is not taken."""
    found: list[Kept] = []
    room = MOST_GRASPS
    while new:
        gains = {row: float((left * odds[row]).mean()) for row in new if costs[row] <= room}
        gains = {row: gain for row, gain in gains.items() if gain >= ADDS}
        if not gains:
            break
        best = max(gains, key=lambda row: gains[row] / (costs[row] + EACH))
        found.append(Kept(new.pop(best), gains[best]))
        left, room = left * (1.0 - odds[best]), room - costs[best]
    return found


def _count(part: Part, family: Family) -> int:
    """How many grasps it is with those that the part's symmetry makes."""
    return len(multiplied(GraspLibrary((family.entry,)), part.symmetry))
