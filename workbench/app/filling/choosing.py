"""The families that together fit at most of the parts of some piles, as they fell."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.app.filling.families import Family, Pile, family_of
from workbench.app.filling.hand import Hand
from workbench.app.filling.work import WORLD
from workbench.model.cell import Cell
from workbench.model.geometry import Bools, Floats
from workbench.planning.collision.tool_check import ToolCheck
from workbench.planning.collision.world import World
from workbench.planning.picking.lifts import find_lifts_clear_for_part
from workbench.planning.picking.propose import candidate_of

WORTH = 0.5
"""What a part counts for, times itself for each family that fits it already."""

LEAST_GAIN = 0.03
"""Share of all parts that a family has to add."""

MOST_FAMILIES = 10
"""Families, at most."""

LOOKED, GROWN = 16, 3
"""Grips that are checked in each round, and those that become families to be compared."""

AMONG = 12
"""Times as many of the grips that add most: which of them are checked is left to chance."""


@dataclass(slots=True)
class _Case:
    """A part as it lies in a pile, and which grips (n,) of the raster fit there."""

    tools: ToolCheck
    number: int
    free: Bools


def choose(
    cell: Cell, hand: Hand, piles: Sequence[Pile], seed: int, is_over: Callable[[], bool]
) -> None:
    """Add families to a hand, each the one that adds most to those before it.

    Args:
        cell: that the piles lie in.
        hand: whose families grow.
        piles: as they fell.
        seed: of what is left to chance.
        is_over: asked now and then; True ends it.
    """
    cases = list(_cases(cell, hand, piles, is_over))
    if not cases:
        return
    rng = np.random.default_rng(seed)
    free = np.array([case.free for case in cases], np.float32)
    worth = np.array(
        [WORTH ** sum(hand.fits(f, c.tools, c.number) for f in hand.families) for c in cases]
    )
    for _ in range(MOST_FAMILIES):
        if is_over():
            return
        best = _best(hand, cases, worth, np.asarray(worth @ free, np.float64), rng)
        if best is None:
            return
        family, fits = best
        if float(worth @ fits) < LEAST_GAIN * len(cases):
            return
        hand.families.append(family)
        worth = np.where(fits, WORTH * worth, worth)


def _cases(
    cell: Cell, hand: Hand, piles: Sequence[Pile], is_over: Callable[[], bool]
) -> list[_Case]:
    """Parts that some grip fits and that could be lifted."""
    found: list[_Case] = []
    for pile in piles:
        world = World(cell, pile)  # large: only what the tools need of it stays
        hand.grower.work.add(WORLD * len(pile) * len(hand.grower.part.pieces))
        for number in range(len(pile)):
            if is_over():
                return found
            free = hand.free(world.tool_check, number)
            if free.any() and not _is_covered(hand, world, number, int(np.argmax(free))):
                found.append(_Case(world.tool_check, number, free))
    return found


def _is_covered(hand: Hand, world: World, number: int, k: int) -> bool:
    """Whether no lift leads out, whoever holds it: others lie on it."""
    grasp = hand.raw(k)
    candidate = candidate_of(world, number, grasp, hand.arm)
    return find_lifts_clear_for_part(world, candidate, candidate.T_world_tcp)[1] is not None


def _best(
    hand: Hand, cases: Sequence[_Case], worth: Floats, gains: Floats, rng: np.random.Generator
) -> tuple[Family, Bools] | None:
    """The family that adds most, of a few, and at which of the cases it fits."""
    gains[list(hand.useless)] = 0.0
    first = np.argsort(-gains, kind="stable")[: LOOKED * AMONG]
    looked: list[tuple[float, int]] = []
    grips = {}
    for k in rng.permutation(first).tolist():
        if gains[k] <= 0.0 or len(looked) == LOOKED:
            continue
        found = hand.grip(k)
        if found is not None:
            grips[k] = found[0]
            looked.append((float(gains[k]) * (0.5 + 0.5 * hand.goodness(*found)), k))
    best: tuple[float, Family, Bools] | None = None
    for _, k in sorted(looked, reverse=True)[:GROWN]:
        part = hand.grower.part
        family = family_of(part, hand.arm, hand.grower.extend(grips[k]), hand.least_air)
        fits = np.array([hand.fits(family, case.tools, case.number) for case in cases])
        if best is None or float(worth @ fits) > best[0]:
            best = float(worth @ fits), family, fits
    return None if best is None else best[1:]
