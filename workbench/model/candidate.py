"""Candidates for a pick, the closed vocabulary of verdicts, and picks."""

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin

from workbench.model.digest import LATER, FactsRepr
from workbench.model.geometry import Floats, frozen, own, put
from workbench.model.messages.message import HELD_BODY, FoundPart, Message, all_of, found_part
from workbench.model.messages.verdicts import ReasonText, StageText, VerdictText
from workbench.model.part import Grasp


class Reason(enum.StrEnum):
    """Why a candidate, a pick or a plan was admitted or refused; the values are on record."""

    OK = "ok"
    DISABLED = "disabled"
    OUTSIDE_REGIONS = "outside of the regions of interest"
    ARM_NOT_ALLOWED = "arm not allowed"
    NO_GRASP = "no grasp"
    NO_GRIP = "no grip"
    OUT_OF_STROKE = "out of stroke"
    TOOL_COLLISION = "tool collision"
    ROLL_UNKNOWN = "roll unknown"
    TILTED = "tilted"
    OUT_OF_REACH = "out of reach"
    IN_COLLISION = "in collision"
    APPROACH_BLOCKED = "approach blocked"
    EXTRACT_BLOCKED = "extract blocked"
    NO_PATH = "no path"
    NO_RETURN = "no return"
    NO_PLACE = "no place"
    OUT_OF_TIME = "out of time"
    WITHIN_MARGIN = "margin not kept"

    @property
    def message(self) -> Message:
        """For people."""
        return ReasonText[self.name]()


COLLISIONS = frozenset({Reason.TOOL_COLLISION, Reason.IN_COLLISION})
"""Reasons of bodies that touch, or are nearer to each other than was asked."""


class Stage(enum.StrEnum):
    """Where in the line a verdict was given, in the order of the line."""

    PROPOSE = "propose"
    GRASP = "grasp"
    APPROACH = "approach"
    EXTRACT = "extract"
    PLACE = "place"
    ROUTE = "route"

    @property
    def message(self) -> Message:
        """For people."""
        return StageText[self.name]()


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """A reason with its evidence.

    Attributes:
        pair: names of the two bodies that are too close.
        distance: distance of the pair [m], negative: penetration depth.  Out of reach: how far
            the TCP stays away [m], plus 0.1 m per radian.  None: not measured.
        q: the arm's configuration at that moment (n,) [rad], for the page.
    """

    reason: Reason
    stage: Stage
    pair: tuple[str, str] | None = None
    distance: float | None = None
    q: Floats | None = None
    note: Message | None = None

    def __post_init__(self) -> None:
        own(self, "q")

    @property
    def is_ok(self) -> bool:
        """Whether it admits."""
        return self.reason is Reason.OK

    @property
    def progress(self) -> tuple[int, float]:
        """How far it got: number of the stage, and distance [m]; the larger the further."""
        return list(Stage).index(self.stage), self.distance or 0.0

    @property
    def kind(self) -> Reason:
        """The reason; that of bodies that do not touch is their margin."""
        return kind_of(self.reason, is_apart=self.distance is not None and self.distance > 0)

    @property
    def message(self) -> Message:
        """The verdict in one sentence."""
        said, far = self.kind.message, self.distance
        if self.pair is not None:
            first, second = map(_body_words, self.pair)
            if far is None:
                said = VerdictText.PAIR(reason=said, one=first, other=second)
            elif far > 0:
                said = VerdictText.APART(reason=said, one=first, other=second, far=far)
            else:
                said = VerdictText.PENETRATING(reason=said, one=first, other=second, depth=-far)
        elif far is not None:
            said = VerdictText.AWAY(reason=said, far=far)
        return said if self.note is None else VerdictText.NOTED(verdict=said, note=self.note)

    def with_note(self, note: Message) -> "Verdict":
        """The verdict with one more remark."""
        return replace(self, note=all_of((self.note, note)))

    def __str__(self) -> str:
        return str(self.message)


def _body_words(label: str) -> FoundPart | Message | str:
    """What people call a body of a pair."""
    arm, _, body = label.partition(" ")
    return VerdictText.IN_HAND(arm=arm) if body.startswith(HELD_BODY) else found_part(label)


def kind_of(reason: Reason, *, is_apart: bool) -> Reason:
    """A reason, or that a margin is violated where bodies of a collision do not touch."""
    return Reason.WITHIN_MARGIN if reason in COLLISIONS and is_apart else reason


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Candidate(FactsRepr):
    """One detection, grasp and arm, with the latest verdict.

    `detection` is the index among the detections of the scan.  `rank` orders the choice:
    lower is better (the SE(3) distance between the arm's home TCP pose and the grasp).  `tcp` is
    the name of the tool's TCP, empty where it has none.
    """

    detection: int
    grasp: Grasp
    arm: str
    T_world_tcp: pin.SE3
    rank: float
    verdict: Verdict
    tcp: str = field(default="", metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "T_world_tcp")

    @property
    def grasp_label(self) -> str:
        """For people, by what it takes the part."""
        return label_grasp(self.grasp.name, self.tcp)

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        part, verdict = f"part-{self.detection + 1}", str(self.verdict)
        return {"part": part, "grasp": self.grasp_label, "arm": self.arm, "verdict": verdict}


def label_grasp(grasp: str, tcp: str) -> str:
    """A grasp with the TCP that takes the part, where that has a name: `top (angled)`."""
    return f"{grasp} ({tcp})" if tcp else grasp


RUBS = 0.0003
"""[m] A part whose lift gains less on what it lies against in its first 3 mm rubs along that."""


@dataclass(frozen=True, slots=True, eq=False)
class Pick:
    """A feasible candidate, with its linear motions as configurations.

    Attributes:
        T_tcp_part: pose of the part in the hand.
        approach: from pre-grasp to grasp (m, n) [rad].
        extract: from the grasp to the end of the extraction (m, n) [rad].
        place: straight down to the release (m, n) [rad].
        clearance: distance beyond the margin at the grasp [m], at most 0.01.
        seconds: lower bound of the duration of its legs [s].
        lift: name of the lift that takes the part out.
        gain: with several lifts: how far this one moves away from contacts [m], see
            `PartWays.gain`.
    """

    candidate: Candidate
    T_tcp_part: pin.SE3
    approach: Floats
    extract: Floats
    place: Floats
    clearance: float
    seconds: float
    solutions: tuple[Floats, ...] = field(default_factory=tuple)
    lift: str = ""
    gain: float = math.inf

    def __post_init__(self) -> None:
        own(self, "T_tcp_part", "approach", "extract", "place")
        put(self, solutions=tuple(frozen(q) for q in self.solutions))

    @property
    def rubs(self) -> bool:
        """Whether the part only rubs off along what it lies against, and may drag that along."""
        return self.gain < RUBS

    @property
    def q_grasp(self) -> Floats:
        """Where the fingers close, shape (n,)."""
        return np.asarray(self.approach[-1])


@dataclass(frozen=True, slots=True, eq=False)
class FoundGrip:
    """A grip that was searched for one part: `opening` [m] on arrival, `grip` [m] when closed.

    The hand arrives along the TCP's z.
    """

    T_part_tcp: pin.SE3
    opening: float
    grip: float

    def __post_init__(self) -> None:
        own(self, "T_part_tcp")
