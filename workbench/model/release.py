"""What lets a plan out to the robot, and what came back."""

from dataclasses import dataclass, field
from typing import Literal

from workbench.model.digest import digest_of
from workbench.model.geometry import put


@dataclass(frozen=True, slots=True, eq=False)
class Approval:
    """A named person's word for exactly one plan, until `until` [s since the epoch]."""

    plan_digest: str
    proof_digest: str
    cell_digest: str
    scan_digest: str
    actor: str
    at: float
    until: float
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put(self, digest=digest_of(self))


@dataclass(frozen=True, slots=True, eq=False)
class Receipt:
    """One message that went out, and what the controller had asked or answered around it.

    `at` [s since the epoch]; `sent` the text on the wire without its terminator; `kind`:
    `start`, `in`, `out` or `stop`.  `done`, `total` count messages of the whole plan.
    """

    at: float
    arm: str
    kind: Literal["start", "in", "out", "stop"]
    sent: str
    done: int
    total: int
