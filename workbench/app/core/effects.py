"""What a decision sets in motion outside the state: small frozen values, carried out by `Bench`."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from workbench.model.cell import Cell
from workbench.model.part import Part
from workbench.model.plan import Plan
from workbench.model.release import Approval


@dataclass(frozen=True, slots=True, eq=False)
class StartJob:
    """Begin long work in the worker process; it answers with `JobEnded(number, ...)`.

    `number` is that of the entry that began it; `arguments` go to the job function `name`.
    """

    number: int
    name: str
    arguments: Mapping[str, Any]


@dataclass(frozen=True, slots=True, eq=False)
class StopJob:
    """End the work with this number, if it still goes on."""

    number: int


@dataclass(frozen=True, slots=True, eq=False)
class Send:
    """Send a plan to the robot; answered by `Sent` for each message and one `LinkEnded`.

    `following` is the next plan of the row.  The sending has ended when the robot reports that it
    stands at the start of that plan.
    """

    plan: Plan
    approval: Approval
    following: Plan | None = None


@dataclass(frozen=True, slots=True, eq=False)
class LetStep:
    """Let the robot run this step of the plan that is being sent, and none after it."""

    number: int


@dataclass(frozen=True, slots=True, eq=False)
class StopSending:
    """Send nothing more and close the link; answered by the `LinkEnded` of the sending."""


@dataclass(frozen=True, slots=True, eq=False)
class UseCell:
    """Jobs and robot link use this cell from now on."""

    cell: Cell


@dataclass(frozen=True, slots=True, eq=False)
class WriteCell:
    """Write a cell to the file that it came from; answered by one `CellRead`.

    `saved` is the digest of the cell as the file was read last: a file that holds another one by
    now is not written.
    """

    cell: Cell
    remark: str
    actor: str
    at: float
    saved: str


@dataclass(frozen=True, slots=True, eq=False)
class KeepDrafts:
    """Keep the grasps of parts that differ from their files, in case nobody saves them."""

    parts: tuple[Part, ...]


@dataclass(frozen=True, slots=True, eq=False)
class RemoveDraft:
    """Remove what was kept of a part."""

    part: str


Effect = (
    StartJob
    | StopJob
    | Send
    | LetStep
    | StopSending
    | UseCell
    | WriteCell
    | KeepDrafts
    | RemoveDraft
)
