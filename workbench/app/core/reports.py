"""Commands that machines give: they tell what has happened."""

from dataclasses import dataclass, field

from workbench.app.provenance.inventory import Inventory
from workbench.model.calibration import PlateObservation
from workbench.model.cell import Cell, Tool
from workbench.model.digest import LATER
from workbench.model.errors import WorkbenchError
from workbench.model.geometry import put
from workbench.model.part import Part
from workbench.model.plan import PlanResult
from workbench.model.prediction import Emptying
from workbench.model.release import PartReport, Receipt
from workbench.model.scan import Detection, Scan


@dataclass(frozen=True, slots=True, eq=False)
class Started:
    """The workbench has begun with this session, and `ran` tells with what.

    `changes` says what is otherwise than at the start before, which `since` names, and what nobody
    had acknowledged then.  `is_trial`: a demonstration, which no later start is compared with.
    """

    ran: Inventory
    changes: tuple[str, ...] = ()
    since: str = ""
    is_trial: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class Opened:
    """A bench goes on with this session: by a new start, or with a copy of it elsewhere.

    Words and approvals belong to one start of one bench: those given before have ended.
    """


@dataclass(frozen=True, slots=True, eq=False)
class CellRead:
    """The cell file was read: what it holds now, or why that cannot be used.

    `is_saved`: this session had written it before, from the cell with the digest `written`, and
    `says` tells people what was written (both empty in older sessions, which did not record it).
    """

    cell: Cell | None = None
    problem: str = ""
    is_saved: bool = False
    written: str = ""
    says: str = field(default_factory=str, metadata=LATER)

    def __post_init__(self) -> None:
        # It may name a file whose name is no text.
        put(self, problem=self.problem.encode(errors="replace").decode())


@dataclass(frozen=True, slots=True, eq=False)
class PosesRefused:
    """A file that came into the watched folder cannot be used; `problem` says why."""

    problem: str


@dataclass(frozen=True, slots=True, eq=False)
class JobEnded:
    """The worker finished job `number`.

    `result` is a `Scan`, a tuple of `Detection`, a `PlanResult`, a `PlateObservation`, a `Part`, a
    `Tool`, an `Emptying`, or the error that ended it.
    """

    number: int
    result: (
        Scan
        | tuple[Detection, ...]
        | PlanResult
        | PlateObservation
        | Part
        | Tool
        | Emptying
        | WorkbenchError
    )


@dataclass(frozen=True, slots=True, eq=False)
class Sent:
    """The robot link reports one message that went out."""

    receipt: Receipt


@dataclass(frozen=True, slots=True, eq=False)
class LinkEnded:
    """The robot link is closed.  `fault` is empty when the controller reported the end.

    `parts` says of each part of the plan what the controller told of it; `placed` are the parts
    that lie on pallets now, or may lie there, None as long as nobody has worked that out.
    `row_ends` says why no plan of a row may follow, as the link or the bench knows it.
    """

    fault: str = ""
    parts_placed: int = 0
    parts: tuple[PartReport, ...] = ()
    placed: tuple[Detection, ...] | None = None
    row_ends: str = field(default_factory=str, metadata=LATER)
