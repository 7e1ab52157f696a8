"""What lets a plan out to the robot, and what came back."""

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
"""How a plan goes out: at which share of its speed, and whether step by step."""

AS_PLANNED: Manner = (1.0, False)


def _full_speed() -> float:
    return 1.0


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
    speed_share: float = field(default_factory=_full_speed, metadata=LATER)
    is_stepped: bool = field(default_factory=bool, metadata=LATER)

    @property
    def manner(self) -> Manner:
        """What a vote has to share with another one to count beside it."""
        return self.speed_share, self.is_stepped


@dataclass(frozen=True, slots=True, eq=False)
class Approval:
    """A named person's vote for exactly one plan, until `until` [s since the epoch].

    Where a cell wants several people, `before` are the votes of the others.  `is_unwatched`
    says that the plan was not played before whoever approves it by a page.  `ran` is the digest of
    the inventory of what ran there (`app.provenance`), empty where none was recorded.

    The plan goes out at `speed_share` (`SLOWEST`..1) of the speed at which it was planned: every
    motion takes this many times longer.  `is_stepped`: the robot waits before each step until a
    person lets that one run.

    It may be for a row of plans that go out one after the other: `row` names those after this one,
    each by the digests of plan and proof.  What lets the next one out is `onward`, whose `first` is
    the digest of the approval as it was given; empty for that one itself.

    `is_switched_off`: nobody has approved this plan.  `actor` is the engineer who had switched
    approval off, which a cell allows whose robot link sends poses alone.
    """

    plan_digest: str
    proof_digest: str
    cell_digest: str
    scan_digest: str
    actor: str
    at: float
    until: float
    before: tuple[Vote, ...] = ()
    is_unwatched: bool = field(default_factory=bool, metadata=LATER)
    ran: str = field(default_factory=str, metadata=LATER)
    speed_share: float = field(default_factory=_full_speed, metadata=LATER)
    is_stepped: bool = field(default_factory=bool, metadata=LATER)
    row: tuple[tuple[str, str], ...] = field(default_factory=tuple, metadata=LATER)
    first: str = field(default_factory=str, metadata=LATER)
    is_switched_off: bool = field(default_factory=bool, metadata=LATER)
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
    """What became of a part that was sent for.

    `PICKED`: it came to its place; `FAILED`: the hand held nothing; `DROPPED`: it was lost on the
    way, and may lie anywhere; `DOUBLE`: it came to its place, and a second part with it.
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
    """What became of one part, as the gripper's signal has it.

    `detection` is an index into the plan's list.  `is_picked` is None while nobody knows: the
    cycle broke off before the hand let go, or the protocol reports no parts.  `is_missed`: the grip
    closed on nothing, so that the hand never held it.
    """

    arm: str
    detection: int
    is_picked: bool | None
    why: Message | str = ""
    is_missed: bool = field(default_factory=bool, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class Receipt:
    """One message on the wire: what went out, and what the controller answered or said.

    `at` [s since the epoch]; `kind` is a word of the link's own; `sent` the text without padding,
    empty when the controller spoke unasked; `heard` its answer, empty where the protocol has none
    or none came.  `done`, `total` count messages of the whole plan.  `part` is set when it reported
    what became of a part; `waits` when it reported that it stands before that step of the plan,
    counted from 1, and waits for a person's word.  `step` is the step that it reported to run,
    counted from 1; 0 where it said nothing of that.
    """

    at: float
    arm: str
    kind: str
    sent: str
    done: int
    total: int
    heard: str = ""
    part: PartReport | None = None
    waits: int = field(default_factory=int, metadata=LATER)
    step: int = field(default_factory=int, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class LinkStatus:
    """How a connection for motion stands; times [s since the epoch].

    `phase` is what the controller says of itself, or `closed`; `acknowledged` its last
    acknowledgement; `stopped` how long [s] it took to acknowledge a stop, None when it did not, and
    `stop` is the message about it.  `joints` (arm -> (n,) [rad]) are the last reported there.
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
    """What a controller reports of itself beside the link for motion.

    `joints` [rad], chain order, and `openings` [m] by arm; `moving` the arm in motion or "";
    `received` counts messages and `placed` the parts put down since it started.  `fault` is
    empty when there is none.
    """

    joints: Mapping[str, tuple[float, ...]]
    openings: Mapping[str, float]
    moving: str
    received: int
    placed: int
    fault: str
