"""What lets a plan out to the robot, and what came back."""

from collections.abc import Mapping
from dataclasses import dataclass, field

from workbench.model.digest import LATER, digest_of
from workbench.model.geometry import Floats, put


@dataclass(frozen=True, slots=True, eq=False)
class Vote:
    """One person's agreement to a plan, `at` [s since the epoch]; a cell may want several."""

    plan_digest: str
    actor: str
    at: float


@dataclass(frozen=True, slots=True, eq=False)
class Approval:
    """A named person's vote for exactly one plan, until `until` [s since the epoch].

    Where a cell wants several people, `before` are the votes of the others.  `is_unwatched`
    says that the plan was not played before whoever approves it by a page.
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
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put(self, digest=digest_of(self))

    @property
    def people(self) -> tuple[str, ...]:
        """Everybody whose vote it is, in the order in which they gave it."""
        return (*(vote.actor for vote in self.before), self.actor)


@dataclass(frozen=True, slots=True, eq=False)
class PartReport:
    """What became of one part, as the gripper's signal has it.

    `detection` is an index into the plan's list.  `is_picked` is None while nobody knows: the
    cycle broke off before the hand let go, or the protocol reports no parts.
    """

    arm: str
    detection: int
    is_picked: bool | None
    why: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Receipt:
    """One message on the wire: what went out, and what the controller answered or said.

    `at` [s since the epoch]; `kind` is a word of the link's own; `sent` the text without padding,
    empty when the controller spoke unasked; `heard` its answer, empty where the protocol has none
    or none came.  `done`, `total` count messages of the whole plan.  `part` is set when it reported
    what became of a part.
    """

    at: float
    arm: str
    kind: str
    sent: str
    done: int
    total: int
    heard: str = ""
    part: PartReport | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LinkStatus:
    """How a connection for motion stands; times [s since the epoch].

    `phase` is what the controller says of itself, or `closed`; `acknowledged` its last
    acknowledgement; `stopped` how long [s] it took to acknowledge a stop, None when it did not, and
    `stop` says so in words.  `joints` (arm -> (n,) [rad]) are the last it reported on this link.
    """

    version: str = ""
    phase: str = "closed"
    step: int = 0
    steps: int = 0
    acknowledged: str = ""
    acknowledged_at: float = 0.0
    reported_at: float = 0.0
    stopped: float | None = None
    stop: str = ""
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
