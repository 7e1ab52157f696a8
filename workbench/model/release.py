"""Approvals of plans, and the reports that the robot sends back."""

import enum
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from workbench.model.digest import LATER, digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, put
from workbench.model.messages.commands import MannerText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal

SLOWEST = 0.05
"""The least share of the planned speed at which a plan is sent."""


Manner = tuple[float, bool]
"""How a plan is sent: at which share of its speed, and whether step by step."""

AS_PLANNED: Manner = (1.0, False)


def manner_words(speed_share: float, is_stepped: bool) -> Message | None:
    """How a plan is to be executed, for people; None where it is in one go and as planned."""
    speed = MannerText.SPEED(share=speed_share) if speed_share < 1.0 else None
    stepped = MannerText.STEPPED() if is_stepped else None
    if speed is not None and stepped is not None:
        return MannerText.BOTH(speed=speed, stepped=stepped)
    return speed or stepped


@dataclass(frozen=True, slots=True, eq=False)
class Vote:
    """One person's agreement to a plan, `at` [s since the epoch]; a cell may want several.

    It is for one manner of sending: `speed_share` and `is_stepped` as in `Approval`.
    """

    plan_digest: str
    actor: str
    at: float
    speed_share: float = field(default=1.0, metadata=LATER)
    is_stepped: bool = field(default=False, metadata=LATER)

    @property
    def manner(self) -> Manner:
        """What two votes must have in common to count together."""
        return self.speed_share, self.is_stepped


@dataclass(frozen=True, slots=True, eq=False)
class Approval:
    """A person's approval of exactly one plan, valid until `until` [s since the epoch].

    If the cell requires several people, `before` are the votes of the others.  `is_unwatched`: the
    page has not shown the plan to the person who approves it.  `ran` is the digest of the inventory
    of the installation (`app.provenance`), empty where none was recorded.

    The plan is sent at `speed_share` (`SLOWEST`..1) of its planned speed: every motion takes longer
    by the inverse of this factor.  `is_stepped`: the robot waits before each step until a person
    allows it.

    An approval may cover a row of plans: `row` names the following ones by the digests of plan and
    proof.  `onward` is the approval of the next plan.  Its `first` is the digest of the approval
    that the person gave; `first` is empty for that approval itself.

    `is_switched_off`: nobody has approved this plan.  `actor` is the engineer who switched approval
    off, which a cell allows if its robot link sends only poses.
    """

    plan_digest: str
    proof_digest: str
    cell_digest: str
    scan_digest: str
    actor: str
    at: float
    until: float
    before: tuple[Vote, ...] = ()
    is_unwatched: bool = field(default=False, metadata=LATER)
    ran: str = field(default="", metadata=LATER)
    speed_share: float = field(default=1.0, metadata=LATER)
    is_stepped: bool = field(default=False, metadata=LATER)
    row: tuple[tuple[str, str], ...] = field(default=(), metadata=LATER)
    first: str = field(default="", metadata=LATER)
    is_switched_off: bool = field(default=False, metadata=LATER)
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        if not SLOWEST <= self.speed_share <= 1.0:
            raise InputError(Refusal.SPEED_SHARE(least=SLOWEST, share=repr(self.speed_share)))
        put(self, digest=digest_of(self))

    @property
    def manner(self) -> Manner:
        """How the plan goes out."""
        return self.speed_share, self.is_stepped

    def onward(self) -> "Approval | None":
        """The same people's agreement to the next plan of the row; None where there is none."""
        if not self.row:
            return None
        (plan, proof), *rest = self.row
        first = self.first or self.digest
        return replace(self, plan_digest=plan, proof_digest=proof, row=tuple(rest), first=first)

    @property
    def people(self) -> tuple[str, ...]:
        """Everybody whose vote it is, in the order in which they gave it."""
        if self.is_switched_off:
            return ()
        return (*(vote.actor for vote in self.before), self.actor)


class PickResult(enum.StrEnum):
    """Outcome of a pick.

    `PICKED`: the part is at its place.  `FAILED`: the hand held nothing.  `DROPPED`: the part was
    lost on the way and may lie anywhere.  `DOUBLE`: a second part came to the place with it.
    """

    PICKED = "picked"
    FAILED = "failed"
    DROPPED = "dropped"
    DOUBLE = "double"

    @property
    def is_picked(self) -> bool:
        """Whether the part counts as placed."""
        return self in (PickResult.PICKED, PickResult.DOUBLE)


def result_of(is_picked: bool, result: PickResult | None) -> PickResult:
    """The stated result; without one what `is_picked` alone says."""
    return result or (PickResult.PICKED if is_picked else PickResult.FAILED)


@dataclass(frozen=True, slots=True, eq=False)
class PartReport:
    """Outcome of one pick according to the gripper's signal.

    `detection` is an index into the plan's list.  `is_picked` is None if unknown: the cycle broke
    off before the release, or the protocol reports no parts.  `is_missed`: the grip closed on
    nothing, so the hand never held the part.
    """

    arm: str
    detection: int
    is_picked: bool | None
    why: Message | str = ""
    is_missed: bool = field(default=False, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class Receipt:
    """One message between the link and the controller.

    `at` [s since the epoch] is its time, `kind` a word of the link.  `sent` is the text without
    padding, empty for a report of the controller.  `heard` is the answer, empty without one.
    `done` and `total` count messages of the whole plan.  `part` is the reported outcome of a part.
    `waits` is the step before which the robot waits for a person, `step` the step that runs, as
    reported and counted from 1; 0: no report.
    """

    at: float
    arm: str
    kind: str
    sent: str
    done: int
    total: int
    heard: str = ""
    part: PartReport | None = None
    waits: int = field(default=0, metadata=LATER)
    step: int = field(default=0, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class LinkStatus:
    """Status of a connection for motion; times [s since the epoch].

    `phase` is the controller's state as it reports it, or `closed`; `acknowledged` the time of its
    last acknowledgement.  `stopped` [s] is the time until it acknowledged a stop, None without
    acknowledgement; `stop` is the message about it.  `joints` (arm -> (n,) [rad]) are the last
    reported ones.
    """

    version: str = ""
    phase: str = "closed"
    step: int = 0
    steps: int = 0
    acknowledged: str = ""
    acknowledged_at: float = 0.0
    reported_at: float = 0.0
    stopped: float | None = None
    stop: Message | None = None
    joints: Mapping[str, Floats] | None = None


@dataclass(frozen=True, slots=True)
class RobotState:
    """State that a controller reports on a connection of its own.

    `joints` [rad], chain order, and `openings` [m] are by arm; `moving` is the arm in motion or "".
    `received` counts messages, `placed` the parts placed since its start.  `fault` is empty when
    there is none.
    """

    joints: Mapping[str, tuple[float, ...]]
    openings: Mapping[str, float]
    moving: str
    received: int
    placed: int
    fault: str
