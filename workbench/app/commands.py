"""Everything that can be asked of the workbench, by a person or by a machine.

A command is a frozen value; `decide` says what it does to the state.  People's commands come
from the page, the command line or the HTTP interface; machines' commands come from the worker
process and the robot link and tell what has happened.
"""

from dataclasses import dataclass, field

from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell, PlannerName, Wishes
from workbench.model.errors import WorkbenchError
from workbench.model.plan import Plan, Proof
from workbench.model.release import Receipt
from workbench.model.scan import Detection, Obstacle, Scan


@dataclass(frozen=True, slots=True, eq=False)
class TakeScan:
    """Trigger the scanner.  `seed` and `parts` shape the simulated pile."""

    seed: int = 0
    parts: int = 2


@dataclass(frozen=True, slots=True, eq=False)
class UseScan:
    """Take a scan from a file instead of the scanner."""

    scan: Scan


@dataclass(frozen=True, slots=True, eq=False)
class FindParts:
    """Localize parts in the current scan."""

    seed: int = 0


@dataclass(frozen=True, slots=True, eq=False)
class UseDetections:
    """Take part poses from outside: a file, another matcher, a person's correction or veto.

    `says` tells people what was done; empty: poses from outside.
    """

    detections: tuple[Detection, ...]
    says: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class MakePlan:
    """Judge all candidates, plan and prove.

    `strategy`: auto, or a `Strategy` value; `threshold` [m].
    """

    strategy: str = "auto"
    threshold: float = 0.2
    seed: int = 0
    wishes: Wishes = field(default_factory=Wishes)


@dataclass(frozen=True, slots=True, eq=False)
class Approve:
    """A person's word for the plan with this digest."""

    plan_digest: str


@dataclass(frozen=True, slots=True, eq=False)
class SendPlan:
    """Send the approved plan with this digest to the robot."""

    plan_digest: str


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """Stop sending and close the link."""


@dataclass(frozen=True, slots=True, eq=False)
class CancelJob:
    """End the running task."""


@dataclass(frozen=True, slots=True, eq=False)
class AcknowledgeFault:
    """A person has seen the fault and cleared the cell."""


@dataclass(frozen=True, slots=True, eq=False)
class ChangeCell:
    """Go on with another cell; `says` tells people what was changed."""

    cell: Cell
    says: str


@dataclass(frozen=True, slots=True, eq=False)
class UndoCell:
    """Go back to the cell before the last change."""


@dataclass(frozen=True, slots=True, eq=False)
class RedoCell:
    """Take back the last undo."""


@dataclass(frozen=True, slots=True, eq=False)
class EmptyPallets:
    """What was put down has been taken away."""


@dataclass(frozen=True, slots=True, eq=False)
class SaveCell:
    """Write the changes of the cell to its file, with a remark of the one who saves."""

    remark: str


@dataclass(frozen=True, slots=True, eq=False)
class CellRead:
    """The cell file was read: what it holds now, or why that cannot be used.

    `is_saved`: it was written before, by this session.
    """

    cell: Cell | None = None
    problem: str = ""
    is_saved: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class JobEnded:
    """The worker finished job `number`.

    `result` is a `Scan`, a tuple of `Detection`, a `PlanResult`, or the error that ended it.
    """

    number: int
    result: "Scan | tuple[Detection, ...] | PlanResult | WorkbenchError"


@dataclass(frozen=True, slots=True, eq=False)
class PlanResult:
    """What a planning job brings: every candidate judged, and the plan or why there is none.

    `beside` is what the other strategy brought, where both were asked for.
    """

    candidates: tuple[Candidate, ...]
    plan: Plan | None
    proof: Proof | None
    verdict: Verdict
    seconds: dict[str, float]
    obstacles: tuple[Obstacle, ...] = ()
    planner: PlannerName = "rrtconnect"
    beside: "tuple[PlanResult, ...]" = ()


@dataclass(frozen=True, slots=True, eq=False)
class Sent:
    """The robot link reports one message that went out."""

    receipt: Receipt


@dataclass(frozen=True, slots=True, eq=False)
class LinkEnded:
    """The robot link is closed.  `fault` is empty when the controller reported the end."""

    fault: str = ""
    parts_placed: int = 0


Command = (
    TakeScan
    | UseScan
    | FindParts
    | UseDetections
    | MakePlan
    | Approve
    | SendPlan
    | Stop
    | CancelJob
    | AcknowledgeFault
    | ChangeCell
    | UndoCell
    | RedoCell
    | SaveCell
    | EmptyPallets
    | CellRead
    | JobEnded
    | Sent
    | LinkEnded
)


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A command with its number, its time [s since the epoch] and who gave it.

    The only place where clock and user enter: what follows from an entry is computed.
    """

    number: int
    at: float
    actor: str
    command: Command
