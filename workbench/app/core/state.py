"""The one state of the workbench: an immutable value, made by `decide` and nothing else."""

import enum
from dataclasses import dataclass, field
from typing import Any

from workbench.model.calibration import PlateSighting
from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell
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
    plan was played to its end, `words` are given for it, enough of them or not.
    `outcomes` are of this plan's parts; `failures` counts failed picks in a row, over all cycles,
    and `avoided` says where.
    `searches` are those in this scan, the latest last, and `remarks` what people have done to what
    was found.  `sightings` are those of a calibration that is being made.
    `control` is the name of who is in control, empty while nobody is; `asking` are those who have
    asked for it, the first one first.
    """

    cell: Cell
    phase: Phase = Phase.IDLE
    number: int = 0
    scan: Scan | None = None
    detections: tuple[Detection, ...] | None = None
    scene_digest: str = ""
    candidates: tuple[Candidate, ...] | None = None
    plan: Plan | None = None
    proof: Proof | None = None
    verdict: Verdict | None = None
    seconds: tuple[tuple[str, float], ...] = ()
    obstacles: tuple[Obstacle, ...] = ()
    outlines: tuple[Outline, ...] = ()
    approval: Approval | None = None
    receipts: tuple[Receipt, ...] = ()
    parts_placed: int = 0
    part_reports: tuple[PartReport, ...] = ()
    job: Job | None = None
    fault: str = ""
    message: str = ""
    before: tuple[Cell, ...] = ()
    undone: tuple[Cell, ...] = ()
    saved: str = ""
    placed: tuple[Detection, ...] = ()
    cell_problem: str = ""
    stale: str = ""
    planned_threshold: float | None = None
    wanted_threshold: float | None = None
    watched: tuple[str, ...] = ()
    words: tuple[Word, ...] = ()
    outcomes: tuple[Outcome, ...] = ()
    failures: int = 0
    avoided: tuple[Avoided, ...] = ()
    searches: tuple[Search, ...] = ()
    remarks: tuple[Remark, ...] = ()
    sightings: tuple[PlateSighting, ...] = ()
    control: str = ""
    asking: tuple[str, ...] = ()


def anew(state: State, phase: Phase = Phase.IDLE, **fields: Any) -> State:
    """A new state with `fields`, which keeps the cell, what is counted, and who is in control."""
    return State(
        state.cell,
        phase,
        state.number,
        before=state.before,
        undone=state.undone,
        saved=state.saved,
        placed=state.placed,
        cell_problem=state.cell_problem,
        failures=state.failures,
        avoided=state.avoided,
        sightings=state.sightings,
        control=state.control,
        asking=state.asking,
        **fields,
    )


def overtaken_by(state: State, by: str) -> str:
    """What to tell about the plan that goes, if there was one."""
    return f"plan {state.plan.digest[:12]} is stale: {by}" if state.plan is not None else ""


def counted(number: int, noun: str) -> str:
    """So many of something, as sentences have it."""
    return f"{number} {noun}" if number == 1 else f"{number} {noun}s"
