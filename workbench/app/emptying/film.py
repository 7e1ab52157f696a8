"""An emptying as it can be shown: every plan carried out, and how the parts lay around it."""

from dataclasses import dataclass

import pinocchio as pin

from workbench.model.plan import Plan
from workbench.model.prediction import Emptying, PileTask
from workbench.model.scan import Detection

Numbered = tuple[tuple[int, Detection], ...]
"""Parts as they truly lie, each with the number under which it fell, from 0 on."""


@dataclass(frozen=True, slots=True, eq=False)
class FilmedPick:
    """What came of one arm's part of a plan.

    `number` is that of the part on which the hand closed, None when there was none, and
    `T_tcp_part` how that part lies in it.  `outcome` is the kind of failure, empty for a part
    taken; `after` is how the rest lies once it was lifted and all is at rest again.  On a `station`
    the next shot takes the part.
    """

    arm: str
    number: int | None
    T_tcp_part: pin.SE3
    outcome: str
    after: Numbered
    station: str = ""

    @property
    def is_taken(self) -> bool:
        """Whether the part has come to a place."""
        return not self.outcome and not self.station


@dataclass(frozen=True, slots=True, eq=False)
class Shot:
    """A plan carried out: how the parts lay before, and what came of each arm, as they lift.

    Where an arm stirs, `stirred` has how the parts lie at each waypoint of that leg instead.
    """

    plan: Plan
    before: Numbered
    picks: tuple[FilmedPick, ...]
    stirred: tuple[Numbered, ...] = ()

    @property
    def after(self) -> Numbered:
        """How the parts lie when it has ended."""
        return self.stirred[-1] if self.stirred else self.picks[-1].after


@dataclass(frozen=True, slots=True, eq=False)
class Film:
    """One pile from full to what stays: `fallen` before the first shot, `left` after the last."""

    task: PileTask
    fallen: Numbered
    shots: tuple[Shot, ...]
    left: Numbered


@dataclass(frozen=True, slots=True, eq=False)
class Filmed:
    """What was found, and a film of each pile that was emptied in the cell as it is, in order."""

    emptying: Emptying
    films: tuple[Film, ...]


def unseen(shot: Shot) -> None:
    """Nobody films it."""
