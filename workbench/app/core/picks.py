"""What was sent, how the sending ended, the outcome of each pick, and which parts are avoided."""

from dataclasses import dataclass, field

import pinocchio as pin

from workbench.model.digest import LATER
from workbench.model.messages.message import Message
from workbench.model.plan import Plan
from workbench.model.release import PartReport, PickResult, result_of
from workbench.model.scan import Detection


@dataclass(frozen=True, slots=True, eq=False)
class SimulatedPile:
    """The pile that a simulated scan shows: parts that fell into a bin, without those taken since.

    `seed`, `parts` and `part` are those of the scan, `lifted` the poses `T_world_part` of the parts
    that were taken out, in order.
    """

    seed: int
    parts: int
    part: str
    bin: str
    lifted: tuple[pin.SE3, ...] = ()

    @property
    def name(self) -> tuple[int, int, str, str]:
        """What distinguishes it from other piles."""
        return self.seed, self.parts, self.part, self.bin

    @property
    def left(self) -> int:
        """How many parts are left in the bin."""
        return self.parts - len(self.lifted)


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """Outcome of a pick, reported by `by`; `detection` is the part's index in the plan.

    `result` is more detailed than `is_picked`; None: no details.  `is_early`: reported while the
    robot moved, so a picked part may still be in the hand.
    """

    detection: int
    is_picked: bool
    by: str
    why: Message | str = ""
    result: PickResult | None = field(default_factory=lambda: None, metadata=LATER)
    is_early: bool = field(default_factory=bool, metadata=LATER)

    @property
    def became(self) -> PickResult:
        """What became of the part."""
        return result_of(self.is_picked, self.result)


@dataclass(frozen=True, slots=True, eq=False)
class Avoided:
    """Place of a failed pick: a part of that kind there is not picked for a while.

    `p_bin` (3,) [m] in the frame of the bin of name `bin`; it ends at `until` [s since the epoch],
    or earlier, when `scans` more scans of that bin were taken.
    """

    part: str
    p_bin: tuple[float, float, float]
    until: float
    scans: int
    why: Message | str = ""
    bin: str = field(default_factory=str, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class SentFor:
    """The plans that were sent, in order, and the outcomes that people and grippers reported.

    Each outcome names its part by the index in the first plan.  `is_over`: the last plan has ended
    without a fault.  `placed` parts came to their places.
    """

    plans: tuple[Plan, ...]
    outcomes: tuple[Outcome, ...] = ()
    is_over: bool = field(default_factory=bool, metadata=LATER)
    placed: int = field(default_factory=int, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class SendingEnd:
    """How a sending has ended.  `fault` is empty when the controller reported the end.

    `parts` are the controller's reports on the parts.  `placed` are the parts that lie on pallets
    now, or may lie there; None: not yet computed.  `row_ends` states why no plan of the row may
    follow, from the link or the bench.  `may_have_moved` is as in `State`; None: not yet computed.
    """

    fault: Message | str = ""
    parts_placed: int = 0
    parts: tuple[PartReport, ...] = ()
    placed: tuple[Detection, ...] | None = None
    row_ends: Message | str = field(default_factory=str, metadata=LATER)
    may_have_moved: tuple[int, ...] | None = field(default_factory=lambda: None, metadata=LATER)
