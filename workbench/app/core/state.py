"""The one state of the workbench: an immutable value, made by `decide` and nothing else."""

import dataclasses
import enum
from dataclasses import dataclass, field
from typing import Any

from workbench.model.calibration import PlateSighting
from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell
from workbench.model.digest import LATER
from workbench.model.plan import Plan, Proof
from workbench.model.release import Approval, PartReport, Receipt, Word
from workbench.model.scan import Detection, Obstacle, Remark, Scan, Search, SearchWishes


class Phase(enum.StrEnum):
    """Where the cycle stands."""

    IDLE = "idle"
    SCANNED = "scanned"
    LOCALIZED = "localized"
    PLANNED = "planned"
    APPROVED = "approved"
    SENDING = "sending"
    DONE = "done"
    FAULT = "fault"


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """Long work under way in the worker process.

    `number` is that of the entry that began it, `at` [s since the epoch] when; `threshold` [m] is
    that of a planning.  A search for parts has its `seed` and `wishes`.
    """

    number: int
    name: str
    at: float = 0.0
    threshold: float | None = None
    seed: int = 0
    wishes: SearchWishes = field(default_factory=SearchWishes)


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """What came of one planning, to be compared with the next.

    `planning` and `cycle` [s]; `apart` [m] the smallest distance between the arms; `verdict` says
    why there is no plan, or what speaks against it.
    """

    planner: str
    planning: float
    strategy: str = ""
    guarantee: str = ""
    parts: int = 0
    cycle: float | None = None
    clearance: float | None = None
    apart: float | None = None
    digest: str = ""
    verdict: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Outcome:
    """What became of a part of the plan, and who says so; `detection` is its index there."""

    detection: int
    is_picked: bool
    by: str
    why: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class Avoided:
    """Where a pick has failed: a part of that kind there is left alone for a while.

    `p_bin` (3,) [m] in the bin's frame; it ends at `until` [s since the epoch], or after so many
    more `scans`, whichever comes first.
    """

    part: str
    p_bin: tuple[float, float, float]
    until: float
    scans: int
    why: str = ""


LASTS = {"outlives_scan": True}
"""Metadata of a field of the state that outlives the scan."""

VOID = {"outlives_scan": False}
"""Of one that a new scan, or another cell, makes void: back to its default."""


@dataclass(frozen=True, slots=True, eq=False)
class State:
    """All that an auditor would ask for.

    What a stage made stays until a newer value of an earlier stage makes it stale: then it is
    dropped, so that what is here always belongs together.  `scene_digest` is what a plan must
    have been made from: that of the scan, or of the detections when they came from outside.
    `part_reports` say what the controller told of each part of the plan, once it was sent.
    `outlines` are of all plannings for these detections, the latest last.
    `fault` is set exactly in phase fault; `message` tells a person what happened last.
    `before` are the cells that an undo goes back to, the last one first to be taken, `undone` those
    of a redo; `placed` are parts on pallets, or where they may be since a fault; `saved` is the
    digest of the cell as its file has it, and `cell_problem` says why the file cannot be used as
    it is now.
    `stale` says what the last plan was overtaken by.  `planned_threshold` [m] is that of the plan,
    `wanted_threshold` the one that is wanted now.  `watched` names those before whose eyes the
    plan was played to its end, `told` those of them of whom only a program says so; `words` are
    given for it, enough of them or not.
    `outcomes` are of this plan's parts; `failures` counts failed picks in a row, over all cycles,
    and `avoided` says where.
    `searches` are those in this scan, the latest last, and `remarks` what people have done to what
    was found.  `sightings` are those of a calibration that is being made.
    `control` is the name of who is in control, empty while nobody is; `asking` are those who have
    asked for it, the first one first.
    """

    cell: Cell = field(metadata=LASTS)
    phase: Phase = field(default=Phase.IDLE, metadata=VOID)
    # Of the cell and of the whole session:
    number: int = field(default=0, metadata=LASTS)
    before: tuple[Cell, ...] = field(default=(), metadata=LASTS)
    undone: tuple[Cell, ...] = field(default=(), metadata=LASTS)
    saved: str = field(default="", metadata=LASTS)
    cell_problem: str = field(default="", metadata=LASTS)
    placed: tuple[Detection, ...] = field(default=(), metadata=LASTS)
    failures: int = field(default=0, metadata=LASTS)
    avoided: tuple[Avoided, ...] = field(default=(), metadata=LASTS)
    sightings: tuple[PlateSighting, ...] = field(default=(), metadata=LASTS)
    # Who is in control:
    control: str = field(default="", metadata=LASTS)
    asking: tuple[str, ...] = field(default=(), metadata=LASTS)
    # Of the scan, and of the parts that were found in it:
    scan: Scan | None = field(default=None, metadata=VOID)
    detections: tuple[Detection, ...] | None = field(default=None, metadata=VOID)
    scene_digest: str = field(default="", metadata=VOID)
    searches: tuple[Search, ...] = field(default=(), metadata=VOID)
    remarks: tuple[Remark, ...] = field(default=(), metadata=VOID)
    # Of the planning:
    candidates: tuple[Candidate, ...] | None = field(default=None, metadata=VOID)
    plan: Plan | None = field(default=None, metadata=VOID)
    proof: Proof | None = field(default=None, metadata=VOID)
    verdict: Verdict | None = field(default=None, metadata=VOID)
    seconds: tuple[tuple[str, float], ...] = field(default=(), metadata=VOID)
    obstacles: tuple[Obstacle, ...] = field(default=(), metadata=VOID)
    outlines: tuple[Outline, ...] = field(default=(), metadata=VOID)
    planned_threshold: float | None = field(default=None, metadata=VOID)
    wanted_threshold: float | None = field(default=None, metadata=VOID)
    stale: str = field(default="", metadata=VOID)
    # Of letting the plan out, and of what the robot did with it:
    watched: tuple[str, ...] = field(default=(), metadata=VOID)
    told: tuple[str, ...] = field(default_factory=tuple, metadata=VOID | LATER)
    words: tuple[Word, ...] = field(default=(), metadata=VOID)
    approval: Approval | None = field(default=None, metadata=VOID)
    receipts: tuple[Receipt, ...] = field(default=(), metadata=VOID)
    parts_placed: int = field(default=0, metadata=VOID)
    part_reports: tuple[PartReport, ...] = field(default=(), metadata=VOID)
    outcomes: tuple[Outcome, ...] = field(default=(), metadata=VOID)
    # Of this moment:
    job: Job | None = field(default=None, metadata=VOID)
    fault: str = field(default="", metadata=VOID)
    message: str = field(default="", metadata=VOID)


LASTING = tuple(one.name for one in dataclasses.fields(State) if one.metadata["outlives_scan"])
"""The fields that a new scan leaves as they are: each field says so of itself."""


def anew(state: State, phase: Phase = Phase.IDLE, **fields: Any) -> State:
    """The state once nothing of the scan counts any more, with `fields`."""
    values: dict[str, Any] = {name: getattr(state, name) for name in LASTING}
    values |= {"phase": phase} | fields
    return State(**values)


def overtaken_by(state: State, by: str) -> str:
    """What to tell about the plan that goes, if there was one."""
    return f"plan {state.plan.digest[:12]} is stale: {by}" if state.plan is not None else ""


def counted(number: int, noun: str) -> str:
    """So many of something, as sentences have it."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
