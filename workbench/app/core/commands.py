"""Everything that can be asked of the workbench, by a person or by a machine.

A command is a frozen value; `decide` says what it does to the state.  People's commands come
from page, command line or HTTP; machines' tell what has happened in the worker or on the link.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from workbench.app.core.people import (
    AskForControl,
    DenyControl,
    GiveControl,
    ReleaseControl,
    Role,
    TakeControl,
)
from workbench.app.core.reports import (
    CellRead,
    JobEnded,
    LinkEnded,
    Opened,
    PosesRefused,
    Sent,
    Started,
)
from workbench.formats.cells.drawn_tools import Bytes, DrawnTool
from workbench.model.calibration import BallPlate, PlateObservation
from workbench.model.cell import Cell, PlanOverrides
from workbench.model.digest import LATER, called
from workbench.model.geometry import Floats, frozen, put
from workbench.model.part import Entry as GraspEntry
from workbench.model.part import GraspPair
from workbench.model.prediction import Seen
from workbench.model.scan import Detection, Scan, SearchOverrides
from workbench.model.symmetry import Symmetry


@dataclass(frozen=True, slots=True, eq=False)
class TakeScan:
    """Trigger the scanner.  `seed`, `parts` and `part` shape the simulated pile.

    `part` is which kind falls, of those that the cell picks; empty: the first; "all": one of
    each in turn.
    """

    seed: int = 0
    parts: int = 2
    part: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class UseScan:
    """Take a scan from a file instead of the scanner."""

    scan: Scan


@dataclass(frozen=True, slots=True, eq=False)
class FindParts:
    """Localize parts in the current scan.

    `is_compared`: they stand beside those that were found before, until somebody takes them.
    """

    seed: int = 0
    overrides: SearchOverrides = field(default_factory=SearchOverrides, metadata=called("wishes"))
    is_compared: bool = field(default_factory=bool, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class UseDetections:
    """Take part poses from outside: a file, another matcher, a person's correction or veto.

    `says` tells people what was done; empty: poses from outside.
    """

    detections: tuple[Detection, ...]
    says: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class SightPlate:
    """Scan the reference plate that an arm at `q` (n,) [rad], chain order, holds.

    `seed` is that of the simulated scanner's noise.
    """

    arm: str
    q: Floats
    plate: BallPlate
    seed: int = 0

    def __post_init__(self) -> None:
        put(self, q=frozen(self.q))


@dataclass(frozen=True, slots=True, eq=False)
class UseObservations:
    """Go on with these observations of the plate, some left out; `says` tells people so."""

    observations: tuple[PlateObservation, ...] = field(metadata=called("sightings"))
    says: str


@dataclass(frozen=True, slots=True, eq=False)
class MakePlan:
    """Judge all candidates, plan and prove.

    `strategy`: one of `value_checks.strategies_of` the cell; `threshold` [m].
    """

    strategy: str = "auto"
    threshold: float = 0.2
    seed: int = 0
    overrides: PlanOverrides = field(default_factory=PlanOverrides, metadata=called("wishes"))


@dataclass(frozen=True, slots=True, eq=False)
class GoOn:
    """After a finished cycle: scan, find parts and plan, each as soon as the one before is done.

    It ends with a plan that waits for its approval, or earlier: with whatever needs a person, and
    when who has asked for it gives control away or has gone.  It approves and sends nothing.

    Given while something is sent, it begins with the last plan's step `sees_from`, from 1, where
    the scanner sees past the arms (0: with its end).  `placed` will lie on pallets by then.
    """

    scan: TakeScan = field(default_factory=TakeScan)
    find: FindParts = field(default_factory=FindParts)
    plan: MakePlan = field(default_factory=MakePlan)
    sees_from: int | None = field(default_factory=lambda: None, metadata=LATER)
    placed: tuple[Detection, ...] | None = field(default_factory=lambda: None, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class WantThreshold:
    """A person wants this threshold [m]; while the plan has another one, the plan is stale."""

    threshold: float


@dataclass(frozen=True, slots=True, eq=False)
class ShortenRow:
    """Carry out only the first `picks` plans of the row that begins with the plan of this digest.

    What was left out so comes back with a larger number.
    """

    plan_digest: str
    picks: int


@dataclass(frozen=True, slots=True, eq=False)
class WatchPlan:
    """The plan with this digest was played to its end before somebody's eyes, and its row with it.

    `row` are the digests of the plans after it.  `is_told`: a program says so, and no browser has
    confirmed that it has drawn it.
    """

    plan_digest: str
    is_told: bool = field(default_factory=bool, metadata=LATER)
    row: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class Approve:
    """A person's vote for the plan with this digest, sent in this manner; see `Approval`.

    It is for those after it as well, the digests of which are its `row`.
    """

    plan_digest: str
    speed_share: float = field(default_factory=lambda: 1.0, metadata=LATER)
    is_stepped: bool = field(default_factory=bool, metadata=LATER)
    row: tuple[str, ...] = field(default_factory=tuple, metadata=LATER)


@dataclass(frozen=True, slots=True, eq=False)
class SendPlan:
    """Send the approved plan with this digest to the robot, and its row as far as all is well."""

    plan_digest: str


@dataclass(frozen=True, slots=True, eq=False)
class NextStep:
    """Let the step of the plan run that the robot waits before, which is `number`, from 1 on."""

    number: int


@dataclass(frozen=True, slots=True, eq=False)
class Stop:
    """Stop sending and close the link."""


@dataclass(frozen=True, slots=True, eq=False)
class ReportPick:
    """What became of a part of the plan, as a person saw it or a gripper felt it.

    `detection` is the part's index in the plan, of a row in the first one; `why` is what is known
    about a failure.
    """

    detection: int
    is_picked: bool
    why: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class ForgetAvoided:
    """No part is avoided any more because its pick has failed."""


@dataclass(frozen=True, slots=True, eq=False)
class CancelJob:
    """End the running task."""


@dataclass(frozen=True, slots=True, eq=False)
class AcknowledgeFault:
    """A person has seen the fault and cleared the cell."""


@dataclass(frozen=True, slots=True, eq=False)
class AcknowledgeChanges:
    """How software, machine or people differ from the start before was seen: `ran`, its digest."""

    ran: str


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
class EditPart:
    """Change the grasps of a part, or its symmetry; undone and redone with the cell.

    `was` are the entries as the one who edits has seen them, `now` what shall stand in their
    place: who edits something that was changed meanwhile is refused.  None: as it is.
    """

    part: str
    was: tuple[GraspEntry, ...] = ()
    now: tuple[GraspEntry, ...] = ()
    pairs: tuple[GraspPair, ...] | None = None
    symmetry: Symmetry | None = None
    says: str = ""


@dataclass(frozen=True, slots=True, eq=False)
class ImportPart:
    """Make a part of a CAD file, and have the cell pick it too.

    `content` (n,) are the bytes of `file`; `unit` mm, m, inch, or empty when the file or its size
    says it; `density` [kg/m3] makes the mass; `is_mended`: close what is open; `is_symmetric`:
    state its symmetry; `solid`: which of several, empty for all as one rigid part.
    """

    name: str
    file: str
    content: Bytes
    unit: str = ""
    density: float = 1200.0
    is_mended: bool = False
    is_symmetric: bool = False
    solid: str = field(default_factory=str, metadata=LATER)

    def __post_init__(self) -> None:
        put(self, content=frozen(self.content, np.uint8))


@dataclass(frozen=True, slots=True, eq=False)
class AddTool:
    """Make a tool of drawings, and have the arm of that name carry it."""

    arm: str
    drawn: DrawnTool


@dataclass(frozen=True, slots=True, eq=False)
class TryEmptying:
    """Empty piles in simulation, in the cell as it is; nothing real has to do with it.

    `kinds` are the parts that fall, one of each in turn, of those that the cell picks; empty: all
    of them.  `count` of them make a pile, and of `piles` each has the next seed.  `changes` are
    kinds of single changes of the cell (`CHANGE_KINDS`) with which the same piles are emptied too.
    """

    kinds: tuple[str, ...] = ()
    count: int = 15
    piles: int = 3
    seed: int = 0
    seen: Seen = "truth"
    changes: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class DropDraft:
    """Forget the changes of a part's grasps that an earlier session has not saved."""

    part: str


@dataclass(frozen=True, slots=True, eq=False)
class EmptyPallets:
    """What was put down has been taken away."""


@dataclass(frozen=True, slots=True, eq=False)
class SaveCell:
    """Write the changes of the cell and its parts to their files, with a remark of who saves."""

    remark: str


Command = (
    TakeScan
    | UseScan
    | FindParts
    | UseDetections
    | SightPlate
    | UseObservations
    | MakePlan
    | GoOn
    | WantThreshold
    | ShortenRow
    | WatchPlan
    | Approve
    | SendPlan
    | NextStep
    | Stop
    | ReportPick
    | ForgetAvoided
    | CancelJob
    | AcknowledgeFault
    | ChangeCell
    | UndoCell
    | RedoCell
    | EditPart
    | ImportPart
    | AddTool
    | TryEmptying
    | DropDraft
    | SaveCell
    | EmptyPallets
    | AskForControl
    | TakeControl
    | GiveControl
    | DenyControl
    | ReleaseControl
    | AcknowledgeChanges
    | Started
    | Opened
    | CellRead
    | PosesRefused
    | JobEnded
    | Sent
    | LinkEnded
)


@dataclass(frozen=True, slots=True, eq=False)
class Entry:
    """A command with its number, its time [s since the epoch] and who gave it, in which role.

    The only place where clock, user and the robot's pose enter: what follows from an entry is
    computed.  `joints` (name -> rad) is how the robot stood by its own report when a plan was
    approved or sent, empty for other commands and where nothing was reported.  A machine's `role`
    says nothing.
    """

    number: int
    at: float
    actor: str
    command: Command
    joints: Mapping[str, float] = field(default_factory=dict[str, float])
    role: Role = Role.ENGINEER
