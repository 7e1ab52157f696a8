"""Cycles and picks as they are counted, and how often picks of one kind have succeeded."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

from workbench.model.release import PickResult

Result = PickResult | Literal["unknown"]


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
    """How many picks of one kind have which result; those of unknown result do not count."""

    name: str
    picked: int
    failed: int
    dropped: int = 0
    double: int = 0

    @property
    def counts(self) -> Mapping[str, int]:
        """The number of picks by result."""
        return {str(result): getattr(self, result) for result in PickResult}

    @property
    def known(self) -> int:
        """How many results are known."""
        return sum(self.counts.values())

    @property
    def share(self) -> float:
        """Share of the known picks that brought their part alone to its place, 0..1."""
        return self.picked / max(self.known, 1)
