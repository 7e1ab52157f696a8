"""A plan: what each arm does, exactly as it will be sent; its proof; the result of a planning."""

import enum
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import ClassVar, Literal

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Candidate, FoundGrip, Verdict
from workbench.model.cell import ARM_NAME
from workbench.model.digest import LATER, FactsRepr, Shared, called, digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, frozen, own, put
from workbench.model.load import Loads
from workbench.model.messages.cells import CellText
from workbench.model.messages.message import Message, plain
from workbench.model.messages.plans import PlanNote, StepText, leg_message, strategy_message
from workbench.model.messages.proofs import violation_message
from workbench.model.motion import LegName, SpeedBound, at_least
from workbench.model.scan import Detection, Obstacle, Scene

PLAN_FORMAT = "workbench-plan/1"

UNSIGNED = frozenset({"seconds", "notes", "digest"})
"""Fields outside a plan's digest: computing times and remarks do not change what moves."""

NO_PART = -1
"""`ArmPlan.detection` of an arm that takes no part."""

STRATEGY_WORDS = ("auto", "alternated", "coordinated", "both", "single")
"""Strategies other than the name of an arm; no arm may have such a name."""


class Strategy(str):
    """Which arms work, and whether at once: `alternated`, `coordinated`, or one arm alone.

    Its text, in files, messages and digests, is one of the two words or the name of the arm.
    """

    __slots__ = ()

    ALTERNATED: ClassVar["Strategy"]
    COORDINATED: ClassVar["Strategy"]

    def __new__(cls, text: str) -> "Strategy":
        """The strategy with this text.

        Raises:
            InputError: it is neither one of the two words nor what an arm can be called.
        """
        if not re.fullmatch(ARM_NAME, text):
            raise InputError(CellText.STRATEGY(strategy=f"{text!r:.60}"))
        return super().__new__(cls, text)

    @classmethod
    def single(cls, arm: str) -> "Strategy":
        """That arm alone."""
        return cls(arm)

    @property
    def arm(self) -> str:
        """The name of the arm that works alone; empty where two arms work."""
        return "" if self in (Strategy.ALTERNATED, Strategy.COORDINATED) else str(self)

    @property
    def words(self) -> str:
        """For people: `right arm only`."""
        return str(strategy_message(self))


Strategy.ALTERNATED = Strategy("alternated")
Strategy.COORDINATED = Strategy("coordinated")


class Guarantee(enum.StrEnum):
    """Under which condition the arms stay apart."""

    ONE_AT_A_TIME = "one-at-a-time"
    TIME_INDEPENDENT = "time-independent"
    SYNCHRONISED = "synchronised"


@dataclass(frozen=True, slots=True, eq=False)
class Leg(Shared):
    """One motion of one arm through waypoints.

    `q` (n, dof) [rad] are the waypoints in chain order, the first at the start.  `t` (n,) [s] are
    the times at the waypoints, from the start of the leg.  `opening` [m] is that of the fingers
    during the leg; `holding` states whether the hand holds the part.
    """

    name: LegName
    motion: Literal["joint", "linear"]
    holding: bool
    opening: float
    q: Floats
    t: Floats

    def __post_init__(self) -> None:
        own(self, "q", "t")
        put(self, opening=float(self.opening))

    @property
    def seconds(self) -> float:
        """Duration of the leg."""
        return float(self.t[-1])

    def at(self, t: float) -> Floats:
        """The configuration (n,) [rad] at a time [s], straight between waypoints."""
        return np.array([np.interp(t, self.t, column) for column in self.q.T])


def are_in_step(legs: Sequence[Leg]) -> bool:
    """Whether all legs pass their waypoints at the same times."""
    return all(np.array_equal(leg.t, legs[0].t) for leg in legs[1:])


@dataclass(frozen=True, slots=True, eq=False)
class ArmPlan:
    """All that one arm does with one part: `detection` is an index into the plan's list.

    `detection` is `NO_PART` and `grasp` empty when an arm moves its scanner to the view, stirs,
    changes to `tool`, or drops what it holds: `held` (`tools.held_body.HeldAmount`).
    `station` names where the part is regrasped; empty: it goes to a place.  `loads` of tool and
    part go to the controller; None if the tool's mass is unknown.  `found` is the grip if the
    part's library has no such grasp.  `tcp` is the name of the tool's TCP; empty: the first.
    """

    arm: str
    detection: int
    grasp: str
    T_tcp_part: pin.SE3
    joints: tuple[str, ...]
    legs: tuple[Leg, ...]
    station: str = field(default="", metadata=LATER)
    loads: Loads | None = field(default=None, metadata=LATER)
    found: FoundGrip | None = field(default=None, metadata=LATER)
    tcp: str = field(default="", metadata=LATER)
    tool: str = field(default="", metadata=LATER)
    held: str = field(default="", metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "T_tcp_part")

    @property
    def takes_part(self) -> bool:
        """Whether the arm takes a part."""
        return self.detection != NO_PART

    @property
    def seconds(self) -> float:
        """Duration of all legs of the arm."""
        return sum(leg.seconds for leg in self.legs)

    def leg(self, name: str) -> Leg:
        """The leg of that name; KeyError when the arm has none."""
        return {leg.name: leg for leg in reversed(self.legs)}[name]


@dataclass(frozen=True, slots=True, eq=False)
class Step:
    """Legs that run at the same time: pairs of (arm, leg name)."""

    runs: tuple[tuple[str, LegName], ...]

    @property
    def words(self) -> Message:
        """What moves, for people: `right extract and left home`."""
        runs = [StepText.RUN(arm=arm, leg=leg_message(leg)) for arm, leg in self.runs]
        return StepText.RUNS(runs=runs)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Plan(FactsRepr):
    """What will be sent, and everything from which it was made.

    `detections` are all known parts in the bin: those to be picked, and those that are obstacles.
    `obstacles` are other objects in the scan.
    `scan_digest` is that of the scan, or of the detections when they came from a file.
    `note` is a remark from another program or from an older version.
    `seconds` (stage -> computing time) and the planner's `notes` are not part of the digest.
    """

    cell: str
    cell_digest: str
    scan_digest: str
    seed: int
    strategy: Strategy
    guarantee: Guarantee
    detections: tuple[Detection, ...]
    arms: tuple[ArmPlan, ...]
    sequence: tuple[Step, ...]
    note: str = ""
    obstacles: tuple[Obstacle, ...] = ()
    seconds: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[Message, ...] = field(default=(), metadata=LATER)
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put(self, seconds=dict(self.seconds), digest=digest_of(self, without=UNSIGNED))

    @property
    def remarks(self) -> tuple[Message, ...]:
        """All remarks for people: the plan's note, and those of the planner."""
        return (plain(self.note), *self.notes) if self.note else self.notes

    @property
    def goes_unseen(self) -> bool:
        """Whether it may collide with an object that the scan does not show."""
        return any(note.text is PlanNote.GOES_UNSEEN for note in self.notes)

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        taken = ", ".join(f"{a.arm} arm part-{a.detection + 1} by {a.grasp}" for a in self.picks)
        cycle, digest = f"{self.cycle_seconds:.1f} s", self.digest[:12]
        return {"strategy": self.strategy, "takes": taken, "cycle": cycle, "digest": digest}

    def arm(self, name: str) -> ArmPlan:
        """That arm's part of the plan; KeyError when the arm does not take part."""
        return {arm.arm: arm for arm in reversed(self.arms)}[name]

    @property
    def picks(self) -> tuple[ArmPlan, ...]:
        """What the arms do that take parts."""
        return tuple(arm for arm in self.arms if arm.takes_part)

    @property
    def is_view_plan(self) -> bool:
        """Whether it only moves a scanner to its view."""
        is_other = self.is_stir_plan or self.is_tool_plan or self.is_drop_plan
        return bool(self.arms) and not self.picks and not is_other

    @property
    def is_stir_plan(self) -> bool:
        """Whether an arm only stirs the parts in the bin."""
        return any(leg.name == "stir" for arm in self.arms for leg in arm.legs)

    @property
    def is_tool_plan(self) -> bool:
        """Whether an arm only changes its tool."""
        return any(arm.tool for arm in self.arms)

    @property
    def is_drop_plan(self) -> bool:
        """Whether an arm only drops back what it holds."""
        return any(arm.held for arm in self.arms)

    @property
    def stations(self) -> tuple[str, ...]:
        """Where it puts parts that the plan after it has to take anew."""
        return tuple(arm.station for arm in self.arms if arm.station)

    @property
    def scene(self) -> Scene:
        """What is in the bin according to the plan."""
        return Scene(self.scan_digest, self.detections, self.obstacles)

    @property
    def cycle_seconds(self) -> float:
        """Predicted time of the whole motion, the steps one after the other."""
        return sum(
            max(self.arm(arm).leg(leg).seconds for arm, leg in step.runs) for step in self.sequence
        )


@dataclass(frozen=True, slots=True, eq=False)
class Violation:
    """A violation found by a proof: where, which pair, and their distance [m].

    `q` (n,) [rad] is the configuration of the arm there.  `Proof.nearest` has the same form: the
    place of the smallest clearance.
    """

    problem: Message
    arm: str = ""
    leg: str = ""
    waypoint: int | None = None
    pair: tuple[str, str] | None = None
    distance: float | None = None
    q: Floats | None = None

    def __post_init__(self) -> None:
        own(self, "q")

    @property
    def message(self) -> Message:
        """The violation in one sentence."""
        place = self.arm, self.leg, self.waypoint
        return violation_message(self.problem, *place, self.pair, self.distance)

    def __str__(self) -> str:
        return str(self.message)


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class Proof(FactsRepr):
    """Result of the independent check of the plan that will be sent.

    - `checks`: number of states; between two of them no point of the robot moves further than its
      distance to the nearest obstacle allows, down to `resolution` [m]
    - `zone`: largest rounding of corners that was checked, together with sharp corners; 0: the
      proof holds only if the robot stops at every waypoint
    - `clearance` [m], `nearest`: lower bound over all free legs, and its place
    - `clearances` (steps,) [m]: the same for each arm and leg after each waypoint, for the plot
    - `apart` (steps,) [m]: the same between the arms, up to `claims.walk.FAR_SIGHT`
    - `speeds`: bounds of the speed of points on each leg, in a cell that limits it
    """

    plan_digest: str
    cell_digest: str
    scan_digest: str
    checks: int
    resolution: float
    clearance: float
    nearest: Violation | None
    violations: tuple[Violation, ...] = field(metadata=called("findings"))
    clearances: tuple[tuple[str, str, Floats], ...] = ()
    apart: tuple[tuple[str, str, Floats], ...] = ()
    zone: float = 0.0
    speeds: tuple[SpeedBound, ...] = field(default=(), metadata=LATER)
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put(
            self,
            clearances=tuple((arm, leg, frozen(d)) for arm, leg, d in self.clearances),
            apart=tuple((arm, leg, frozen(d)) for arm, leg, d in self.apart),
            digest=digest_of(self),
        )

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        if not self.holds:
            return {"holds": "no", "violations": len(self.violations), "first": self.violations[0]}
        return {
            "holds": "yes",
            "clearance": at_least(self.clearance),
            "plan": self.plan_digest[:12],
        }

    @property
    def holds(self) -> bool:
        """Whether nothing was found against the plan."""
        return not self.violations


@dataclass(frozen=True, slots=True, eq=False)
class Proven:
    """A plan with its proof."""

    plan: Plan
    proof: Proof


@dataclass(frozen=True, slots=True, eq=False, repr=False)
class PlanResult(FactsRepr):
    """Result of a planning: all candidates with their verdicts, and the plan or why there is none.

    `bound` [s] is a lower bound of the cycle time for the same parts, from the feasible candidates;
    0: not computed.  `beside` is the result of the other strategy if both were requested.  `row`
    are the plans that follow the plan, each proven in the scene that the plans before leave.
    `row_ends` states why the row has no further plan; None: it has the requested length.
    """

    candidates: tuple[Candidate, ...]
    plan: Plan | None
    proof: Proof | None
    verdict: Verdict
    seconds: dict[str, float]
    obstacles: tuple[Obstacle, ...] = ()
    planner: str = "rrtconnect"
    beside: "tuple[PlanResult, ...]" = ()
    bound: float = field(default=0.0, metadata=LATER)
    row: tuple[Proven, ...] = field(default=(), metadata=LATER)
    row_ends: Message | None = field(default=None, metadata=LATER)

    @property
    def is_proven(self) -> bool:
        """Whether there is a plan, and its proof holds."""
        return self.plan is not None and self.proof is not None and self.proof.holds

    @property
    def facts(self) -> Mapping[str, object]:
        """What people want to know of it."""
        works = sum(candidate.verdict.is_ok for candidate in self.candidates)
        counts = {"candidates": f"{works} of {len(self.candidates)} work"}
        if self.plan is None or self.proof is None:
            return {**counts, "no plan": self.verdict}
        return {**counts, **self.plan.facts, **self.proof.facts}

    @property
    def plans(self) -> tuple[Plan, ...]:
        """The plan and those after it."""
        return () if self.plan is None else (self.plan, *(entry.plan for entry in self.row))
