"""What studies say beforehand: of a threshold, and of bins that are emptied in simulation."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from workbench.model.candidate import Reason
from workbench.model.digest import LATER
from workbench.model.messages.message import Message
from workbench.model.messages.states import LeftText

Seen = Literal["truth", "scan"]
"""Whether plans are made with the true poses or with those found in a simulated scan."""

TOGETHER = "+"
"""Joins the names of parts that fall into one pile."""

FAILURES = ("missed", "crooked", "turned", "slipped")
"""Kinds of failed picks: no part between the fingers; a part in another pose; a part whose unknown
roll prevents the grip; a part too heavy for the grip, where force and friction are stated."""

CHANGE_KINDS = ("fingers", "grasps", "lifts", "margins", "bin", "arms", "order", "tool")
"""Kinds of single changes of a cell that are tried where a bin does not empty."""


@dataclass(frozen=True, slots=True)
class Forecast:
    """What to expect where both arms may take parts at least `threshold` [m] apart at once.

    Shares are 0..1, None where nothing was counted: of the pairs that may be taken at once, and of
    the pairs with a proven plan.  `planning` and `cycle` [s]: the median and the mean for a pair.
    """

    threshold: float
    coordinated: float | None
    success: float | None
    planning: float | None
    cycle: float | None
    parts_per_hour: float | None


@dataclass(frozen=True, slots=True)
class Predictions:
    """Forecasts of one study, with its number of piles and the digest of its cell."""

    cell_digest: str
    piles: int
    forecasts: tuple[Forecast, ...]

    def near(self, threshold: float) -> Forecast | None:
        """The forecast for the threshold [m] that is nearest to this one."""
        return min(
            self.forecasts, key=lambda forecast: abs(forecast.threshold - threshold), default=None
        )


@dataclass(frozen=True, slots=True)
class PileTask:
    """One pile: of which cell and parts, how many, by which seed, and how it is emptied.

    `part` is one of the cell's, `all` for all of them in turn, or others by name or path, joined by
    `TOGETHER`; empty: the cell's first.  `settles`: the rest moves by physics as a part is lifted.
    `bounds`: what stays is tried by all grasps of the tool, too.  `change`: a change of the
    cell (`app.emptying.changes`) that the pile is emptied with, None for none; it lies as without
    it, and what stays is reported without a nearest fix.  `picks`: plans in a row after one look,
    at most.  `recipe` is the number of the cell's recipe, 0 for none; `bin` the name of its bin.
    `stirs`: how often in a row a hand stirs where nothing can be taken; None: as the cell says.
    `displaced` [m]: the sideways shift of an assembly's base after it was placed; if
    that is not 0, a kit is complete only if its parts mate.
    """

    cell: str
    part: str
    count: int
    seed: int
    seen: Seen = "truth"
    settles: bool = True
    strategy: str = "auto"
    bounds: bool = False
    change: Message | None = None
    picks: int = 1
    recipe: int = field(default=0, metadata=LATER)
    bin: str = field(default="", metadata=LATER)
    stirs: int | None = field(default=None, metadata=LATER)
    displaced: float = field(default=0.0, metadata=LATER)


NOT_FOUND, STOPPED = "not found", "stopped"
"""Kinds of parts that stay, on record, besides the reasons of verdicts."""


@dataclass(frozen=True, slots=True)
class LeftPart:
    """A part that stayed in the bin: `part-3` is the third that fell.

    `kind` is the word of the verdict that got furthest, `not found` or `stopped`, `reason` a
    sentence about it; `nearest_fix` is the smallest change of a grasp that takes it, empty when
    none was found; `any_grasp` what a search through all grasps of the tool said, empty when nobody
    asked.
    """

    part: str
    kind: str
    reason: Message
    nearest_fix: Message | str
    any_grasp: Message | str = ""

    @property
    def kind_message(self) -> Message:
        """The kind for people."""
        if self.kind in tuple(Reason):
            return Reason(self.kind).message
        return LeftText.STOPPED() if self.kind == STOPPED else LeftText.NOT_FOUND()

    @property
    def form(self) -> Mapping[str, object]:
        """What programs get."""
        fields = {
            known_field.name: getattr(self, known_field.name)
            for known_field in dataclasses.fields(self)
        }
        texts = {name: str(fields[name]) for name in ("reason", "nearest_fix", "any_grasp")}
        return {**fields, **texts, "said": self.reason.program_form}


@dataclass(frozen=True, slots=True)
class EmptiedPile:
    """Result of emptying a pile in simulation.

    Attributes:
        parts: number of parts in the pile.
        taken: number of parts picked as planned.
        failed: number of failed picks by kind, in the order of `FAILURES`; may be shorter.
        touches: number of legs with a collision that the plan excluded.
        knocked_out: number of parts that fell out of the bin, or that a hand missed on a station.
        cycles: number of approvals, of a plan or of a row of plans.
        scans: number of scans of the bin.
        motion_seconds: planned duration of all motions [s].
        left: parts that stayed in the bin.
        planning: measured planning time for each scan [s].
        stages: computing time by stage [s].
        finding: computing time of all searches for parts [s].
        more: remaining parts that some grasp of the tool can take; None: not computed.
        rolled: picked parts with another roll than found, whose roll was reported as unknown.
        outcomes: kind of failure of each pick, in order; empty for a success.
        beside: for each scan during a motion: remaining time of the motion [s], and computing time
            of search and planning [s].
        warned_picks: picks with a warning that an object may extend unseen into the hand's path.
        warned_touches: collisions of these picks.
        holdable: remaining parts that a hand can reach and hold; None: not computed.
        kits: number of completed kits, and of kits that the parts suffice for; None: no kits.
        stirs: number of times that a hand stirred the parts.
        unmated: number of kits with a part that did not mate with its base.
    """

    task: PileTask
    parts: int
    taken: int
    failed: tuple[int, ...]
    touches: int
    knocked_out: int
    cycles: int
    scans: int
    motion_seconds: float
    left: tuple[LeftPart, ...]
    planning: tuple[float, ...]
    stages: tuple[tuple[str, float], ...]
    finding: float
    more: int | None = None
    rolled: int = 0
    outcomes: tuple[str, ...] = ()
    beside: tuple[tuple[float, float], ...] = field(default=(), metadata=LATER)
    warned_picks: int = field(default=0, metadata=LATER)
    warned_touches: int = field(default=0, metadata=LATER)
    holdable: int | None = field(default=None, metadata=LATER)
    kits: tuple[int, int] | None = field(default=None, metadata=LATER)
    stirs: int = field(default=0, metadata=LATER)
    unmated: int = field(default=0, metadata=LATER)


@dataclass(frozen=True, slots=True)
class Emptying:
    """Piles emptied in simulation, in the cell that has this digest.

    Those without a change of the cell come first, in the order of their seeds; after them, where
    changes were tried, the same piles with each.
    """

    cell_digest: str
    piles: tuple[EmptiedPile, ...]

    @property
    def plain(self) -> tuple[EmptiedPile, ...]:
        """The piles that were emptied in the cell as it is."""
        return tuple(pile for pile in self.piles if not pile.task.change)
