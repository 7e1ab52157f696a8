"""A kit: how many parts of which kinds belong in it, and which of them it has."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import pinocchio as pin

from workbench.model.digest import LATER
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.cells import KitText
from workbench.model.messages.message import Message
from workbench.model.recipes.joint import Joint

MOST_ITEMS, MOST_OF_ITEM = 16, 99


@dataclass(frozen=True, slots=True)
class Insertion:
    """How a part comes onto another one of the kit, its base: straight, until it is seated.

    `position` (3,) [m] and `rpy` (3,) [rad] are its pose in the base when the hand lets go of it.
    It comes there along the unit direction `along` (3,) in the base, over `length` [m].  On this
    motion the two parts keep at least `clearance` [m] between them; all else keeps its margin.
    `joint` is what they tolerate, None where nobody states it.  With `look_again` it comes to where
    the base is seen in the scan that it is found in; where that shows none, it does not come.
    """

    base: str
    position: tuple[float, float, float]
    rpy: tuple[float, float, float]
    along: tuple[float, float, float]
    length: float
    clearance: float
    joint: Joint | None = field(default=None, metadata=LATER)
    look_again: bool = field(default=False, metadata=LATER)

    @property
    def T_base_part(self) -> pin.SE3:
        """The part where it is seated, in the frame of its base."""
        return pose_from_rpy(self.position, self.rpy)


@dataclass(frozen=True, slots=True)
class KitItem:
    """`count` parts of one kind that belong in a kit; with an `insertion` it is one, on another."""

    part: str
    count: int
    insertion: Insertion | None = field(default=None, metadata=LATER)


@dataclass(frozen=True, slots=True)
class KitPart:
    """A part that was put into the kit.

    `part` is its kind.  `plan` is the digest of the first plan of the row by which it came, and
    `detection` its index there.
    """

    part: str
    plan: str
    detection: int


@dataclass(frozen=True, slots=True)
class KitProgress:
    """The parts of the kit that is being filled, and how many kits were taken away before it.

    `complete` of those had all their parts, `incomplete` had not.  `bins_without` names the bins
    in which this cycle has found nothing that the kit lacks.
    """

    parts: tuple[KitPart, ...] = ()
    complete: int = 0
    incomplete: int = 0
    bins_without: tuple[str, ...] = field(default=(), metadata=LATER)

    @property
    def counts(self) -> Mapping[str, int]:
        """How many parts of each kind it has."""
        return Counter(kit_part.part for kit_part in self.parts)


@dataclass(frozen=True, slots=True)
class Wanted:
    """How many parts of each kind may still be taken; of other kinds none.

    `in_order`: those of a kind only when there are enough of the kinds before it.
    """

    counts: Mapping[str, int]
    in_order: bool = False

    @property
    def now(self) -> Mapping[str, int]:
        """How many parts of each kind may be taken next."""
        return dict(list(self.counts.items())[:1]) if self.in_order else self.counts

    def allows(self, kinds: Sequence[str]) -> bool:
        """Whether parts of these kinds may all be taken next."""
        return all(count <= self.now.get(kind, 0) for kind, count in Counter(kinds).items())

    def refusals(self, kinds: Sequence[str]) -> Mapping[int, Message]:
        """Why parts of these kinds may not be taken next, by index; without those that may."""
        return {
            number: KitText.HAS_ENOUGH(part=kind)
            for number, kind in enumerate(kinds)
            if not self.allows([kind])
        }

    def without(self, kinds: Sequence[str]) -> "Wanted":
        """What is still wanted when parts of these kinds have been taken."""
        taken = Counter(kinds)
        left = {part: count - taken[part] for part, count in self.counts.items()}
        return replace(self, counts={part: count for part, count in left.items() if count > 0})


def lacking(items: Sequence[KitItem], counts: Mapping[str, int]) -> Mapping[str, int]:
    """How many parts of each kind a kit lacks, in the order of its items; without those it has."""
    lacks = {item.part: item.count - counts.get(item.part, 0) for item in items}
    return {part: count for part, count in lacks.items() if count > 0}
