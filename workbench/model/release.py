"""What lets a plan out to the robot, and what came back."""

from dataclasses import dataclass, field
from typing import Literal

from workbench.model.digest import digest_of
from workbench.model.geometry import put


@dataclass(frozen=True, slots=True, eq=False)
class Word:
    """One person's agreement to a plan, `at` [s since the epoch]; a cell may want several."""

    plan_digest: str
    actor: str
    at: float


@dataclass(frozen=True, slots=True, eq=False)
class Approval:
    """A named person's word for exactly one plan, until `until` [s since the epoch].

    Where a cell wants several people, `before` are the words of the others.
    """

    plan_digest: str
    proof_digest: str
    cell_digest: str
    scan_digest: str
    actor: str
    at: float
    until: float
    before: tuple[Word, ...] = ()
    digest: str = field(init=False, repr=False)

    def __post_init__(self) -> None:
        put(self, digest=digest_of(self))

    @property
    def people(self) -> tuple[str, ...]:
        """Everybody whose word it is, in the order in which they gave it."""
        return (*(word.actor for word in self.before), self.actor)


@dataclass(frozen=True, slots=True, eq=False)
class PartReport:
    """What became of one part, as the gripper's signal has it.

    `detection` is an index into the plan's list.  `is_picked` is None while nobody knows: the
    cycle broke off before the hand let go, or the protocol reports no parts.
    """

    arm: str
    detection: int
    is_picked: bool | None
    why: str = ""


MessageKind = Literal[
    "start",
    "in",
    "out",
    "stop",
    "hello",
    "plan",
    "ticket",
    "leg",
    "to",
    "end",
    "run",
    "heard",
]
"""Words of both protocols; `heard` is what the controller said unasked."""


@dataclass(frozen=True, slots=True, eq=False)
class Receipt:
    """One message on the wire: what went out, and what the controller answered or said.

    `at` [s since the epoch]; `sent` the text without padding, empty when the controller spoke
    unasked; `heard` its answer, empty where the protocol has none or none came.  `done`, `total`
    count messages of the whole plan.  `part` is set when it reported what became of a part.
    """

    at: float
    arm: str
    kind: MessageKind
    sent: str
    done: int
    total: int
    heard: str = ""
    part: PartReport | None = None
