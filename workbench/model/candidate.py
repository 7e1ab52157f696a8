"""Candidates for a pick, the closed vocabulary of verdicts, and picks."""

import enum
import math
from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from workbench.model.digest import Told
from workbench.model.geometry import Floats, copied, frozen, put
from workbench.model.part import Grasp


class Reason(enum.StrEnum):
    """Why a candidate, a pick or a plan was admitted or refused."""

    OK = "ok"
    DISABLED = "disabled"
    OUTSIDE_REGIONS = "outside of the regions of interest"
    ARM_NOT_ALLOWED = "arm not allowed"
    TOOL_COLLISION = "tool collision"
    ROLL_UNKNOWN = "roll unknown"
    OUT_OF_REACH = "out of reach"
    IN_COLLISION = "in collision"
    APPROACH_BLOCKED = "approach blocked"
    EXTRACT_BLOCKED = "extract blocked"
    NO_PATH = "no path"
    NO_RETURN = "no return"
    NO_PLACE = "no place"
    OUT_OF_TIME = "out of time"


MARGIN_NOT_KEPT = "margin not kept"
"""What is said of bodies that do not touch, and are nearer to each other than was asked."""


class Stage(enum.StrEnum):
    """Where in the line a verdict was given, in the order of the line."""

    PROPOSE = "propose"
    GRASP = "grasp"
    APPROACH = "approach"
    EXTRACT = "extract"
    PLACE = "place"
    ROUTE = "route"

    @property
    def words(self) -> str:
        """For people: the first one looks at the hand alone, before any arm is asked."""
        return "preselection" if self is Stage.PROPOSE else str(self)


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """A reason with its evidence.

    `pair` names the two bodies that come too close, `distance` [m] how close (negative:
    penetration depth), None where nobody has measured it, or, when out of reach, how far the TCP
    stays away; `q` (n,) [rad] is the configuration (of the candidate's arm) where it happened, so
    that the page can draw it.
    """

    reason: Reason
    stage: Stage
    pair: tuple[str, str] | None = None
    distance: float | None = None
    q: Floats | None = None
    note: str = ""

    def __post_init__(self) -> None:
        put(self, q=None if self.q is None else frozen(self.q))

    @property
    def is_ok(self) -> bool:
        """Whether it admits."""
        return self.reason is Reason.OK

    @property
    def progress(self) -> tuple[int, float]:
        """How far it got: number of the stage, and distance [m]; the larger the further."""
        return list(Stage).index(self.stage), self.distance or 0.0

    def __str__(self) -> str:
        text = str(self.reason)
        if self.pair is not None:
            text += f": {self.pair[0]} and {self.pair[1]}"
        if self.distance is not None:
            text += f", {self.distance * 1000:.1f} mm"
        return f"{text} ({self.note})" if self.note else text


def kind_of(verdict: Verdict) -> str:
    """What is said of a candidate: its reason, unless that is a collision that is none."""
    is_apart = verdict.distance is not None and verdict.distance > 0
    return kind_said(verdict.reason, is_apart=is_apart)


def kind_said(reason: str, *, is_apart: bool) -> str:
    """As `kind_of`, where all that is known besides is whether the distance is above 0."""
    touching = reason in (Reason.TOOL_COLLISION, Reason.IN_COLLISION)
    return MARGIN_NOT_KEPT if touching and is_apart else str(reason)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Candidate(Told):
    """One detection taken by one grasp with one arm, with the verdict so far.

    `detection` is the index among the detections of the scan.  `rank` orders the choice:
    lower is better (the SE(3) distance between the arm's home TCP pose and the grasp).
    """

    detection: int
    grasp: Grasp
    arm: str
    T_world_tcp: pin.SE3
    rank: float
    verdict: Verdict

    def __post_init__(self) -> None:
        put(self, T_world_tcp=copied(self.T_world_tcp))

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        part, verdict = f"part-{self.detection + 1}", str(self.verdict)
        return {"part": part, "grasp": self.grasp.name, "arm": self.arm, "verdict": verdict}


RUBS = 0.0003
"""[m] A part whose lift gains less on what it lies against in its first 3 mm rubs along that."""


@dataclass(frozen=True, slots=True, eq=False)
class Pick:
    """A candidate that works: the straight legs and the place, as configurations.

    `approach` (m, n) [rad] runs from pre-grasp to grasp, `extract` (m, n) from grasp to the
    end of the extraction; `place` (n,) releases the part.  `T_tcp_part` is the part in the
    hand, `lift` the name of the way in which it is taken out, `gain` [m] how much that leads away
    from what the part lies against (`PartWays.gain`), told where there are several lifts.
    `clearance` [m] is the smallest found over them, `seconds` what its legs take at least, each
    straight from rest to rest.
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
        put(
            self,
            T_tcp_part=copied(self.T_tcp_part),
            approach=frozen(self.approach),
            extract=frozen(self.extract),
            place=frozen(self.place),
            solutions=tuple(frozen(q) for q in self.solutions),
        )

    @property
    def rubs(self) -> bool:
        """Whether the part only rubs off along what it lies against, and may drag that along."""
        return self.gain < RUBS

    @property
    def q_grasp(self) -> Floats:
        """Where the fingers close, shape (n,)."""
        return np.asarray(self.approach[-1])
