"""Pairs of bodies, and the distance that each has to keep."""

from dataclasses import dataclass, replace

import numpy as np

from workbench.model.geometry import Bools, Floats, Ints


class BodyPairs:
    """All pairs of bodies that can ever be compared: indices `first` and `second` (r,).

    `rounds` (b,) states that a body fills the same space however its own joint is turned.
    """

    first: Ints
    second: Ints
    rounds: Bools


@dataclass(frozen=True, slots=True, eq=False)
class Pairs:
    """The pairs (p,) that count in a situation, as rows of `BodyPairs`.

    `margins` (p,) [m] are to be kept; `commons` (p,) is the joint next to both that moves both,
    0 for none.  `beds` are pairs of a lifted part and what it may lie on, `released` those of an
    arm and the part it has placed.  Those `at_slot` are of an arm and what it touches in a slot.
    `arms` (p, 2) are those that carry the two, -1 for none.
    `shown`: their distance is worth showing; that of an arm's own links is not.
    """

    rows: Ints
    margins: Floats
    commons: Ints
    beds: Bools
    released: Bools
    arms: Ints
    shown: Bools
    at_slot: Bools

    def among(self, chosen: Bools) -> "Pairs":
        """Those of them that are chosen (p,)."""
        return Pairs(*(getattr(self, name)[chosen] for name in Pairs.__slots__))

    def between(self, first: int, second: int) -> Bools:
        """Whether pairs (p,) are of these two arms, by their numbers in the cell."""
        return (np.sort(self.arms, axis=1) == sorted((first, second))).all(axis=1)

    def hiding(self, hidden: Bools) -> "Pairs":
        """The same pairs, of which some (p,) are not worth showing."""
        return replace(self, shown=self.shown & ~hidden)

    def keeping(self, margins: Floats) -> "Pairs":
        """The same pairs with other margins (p,) [m]."""
        return replace(self, margins=margins)
