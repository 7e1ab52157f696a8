"""Cycles and picks as they are counted, and how often picks of one kind have succeeded."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

Result = Literal["picked", "failed", "unknown"]


@dataclass(frozen=True, slots=True)
class PickRecord:
    """One part that was to be taken: how, and what became of it."""

    detection: int
    part: str
    grasp: str
    arm: str
    result: Result = "unknown"
    why: str = ""


@dataclass(frozen=True, slots=True)
class CycleRecord:
    """One cycle, from its scan on.

    `number` is that of its first entry, `at` and `until` [s since the epoch] are those of its
    first and last; `end` is empty while it goes on or when it was given up.  `seconds`: stage ->
    how long it took; that of `approve` is the time that people took.
    """

    number: int
    at: float
    until: float
    strategy: str = ""
    end: Literal["", "done", "fault", "no plan"] = ""
    picks: tuple[PickRecord, ...] = ()
    seconds: Mapping[str, float] = field(default_factory=dict[str, float])


@dataclass(frozen=True, slots=True)
class Rate:
    """How often picks of one kind have succeeded; those of unknown result do not count."""

    name: str
    picked: int
    failed: int

    @property
    def share(self) -> float:
        """Of those that are known, 0..1."""
        return self.picked / max(self.picked + self.failed, 1)
