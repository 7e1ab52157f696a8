"""The one state of the workbench: an immutable value, made by `decide` and nothing else."""

import enum
from dataclasses import dataclass

from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell, PlannerName
from workbench.model.plan import Plan, Proof
from workbench.model.release import Approval, Receipt
from workbench.model.scan import Detection, Obstacle, Scan


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

    `number` is that of the entry that began it, `inputs_digest` covers what it works on.
    """

    number: int
    name: str
    inputs_digest: str


@dataclass(frozen=True, slots=True, eq=False)
class Outline:
    """What came of one planning, to be compared with the next.

    `planning` and `cycle` [s]; `apart` [m] the smallest distance between the arms; `verdict` says
    why there is no plan, or what speaks against it.
    """

    planner: PlannerName
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
class State:
    """All that an auditor would ask for.

    What a stage made stays until a newer value of an earlier stage makes it stale: then it is
    dropped, so that what is here always belongs together.  `scene_digest` is what a plan must
    have been made from: that of the scan, or of the detections when they came from outside.
    `outlines` are of all plannings for these detections, the latest last.
    `fault` is set exactly in phase fault; `message` tells a person what happened last.
    `before` are the cells that an undo goes back to, the last one first to be taken, `undone` those
    of a redo; `placed` are parts on pallets, or where they may be since a fault; `saved` is the
    digest of the cell as its file has it, and `cell_problem` says why the file cannot be used as
    it is now.
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
    job: Job | None = None
    fault: str = ""
    message: str = ""
    before: tuple[Cell, ...] = ()
    undone: tuple[Cell, ...] = ()
    saved: str = ""
    placed: tuple[Detection, ...] = ()
    cell_problem: str = ""
