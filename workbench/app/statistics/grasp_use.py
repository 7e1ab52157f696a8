"""How each grasp of a part has done: tried, planned with, taken by, failed with."""

from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from workbench.model.part import TURN_MARK
from workbench.model.release import PickResult

FAILED = set(PickResult) - {PickResult.PICKED}


@dataclass(frozen=True, slots=True)
class GraspUse:
    """Use of one grasp, or of several together.

    Attributes:
        tried: how often it was checked for a part in the bin.
        possible: how often it was feasible.
        planned: how often a plan used it.
        picked: how often such a pick succeeded.
        failed: how often such a pick failed; dropped parts and double picks count as failed.
    """

    tried: int = 0
    possible: int = 0
    planned: int = 0
    picked: int = 0
    failed: int = 0

    def __add__(self, other: "GraspUse") -> "GraspUse":
        """Both together."""
        return GraspUse(
            self.tried + other.tried,
            self.possible + other.possible,
            self.planned + other.planned,
            self.picked + other.picked,
            self.failed + other.failed,
        )


Uses = Mapping[tuple[str, str], GraspUse]
"""By part and grasp, the turns of a symmetry together."""

NO_USES: Uses = MappingProxyType({})


def count_judged(parts: Sequence[str], candidates: Iterable[Mapping[str, Any]]) -> Uses:
    """How often each grasp was tried and would have worked, from recorded candidates.

    Args:
        parts: the part of each detection, by its index.
        candidates: in canonical form.
    """
    tried: Counter[tuple[str, str]] = Counter()
    possible: Counter[tuple[str, str]] = Counter()
    for candidate in candidates:
        number: int = candidate["detection"]
        key = (parts[number], candidate["grasp"]["name"].partition(TURN_MARK)[0])
        tried[key] += 1
        possible[key] += candidate["verdict"]["reason"] == "ok"
    return {key: GraspUse(count, possible[key]) for key, count in tried.items()}


def count_taken(picks: Iterable[tuple[str, str, str]]) -> Uses:
    """How often plans went by each grasp, and what became of it.

    Args:
        picks: part, grasp, and a `PickResult` or anything else.
    """
    uses: dict[tuple[str, str], GraspUse] = {}
    for part, grasp, result in picks:
        use = GraspUse(planned=1, picked=result == "picked", failed=result in FAILED)
        key = (part, grasp.partition(TURN_MARK)[0])
        uses[key] = uses.get(key, GraspUse()) + use
    return uses


def add_uses(*several: Uses) -> dict[tuple[str, str], GraspUse]:
    """All of them together."""
    sums: dict[tuple[str, str], GraspUse] = {}
    for uses in several:
        for key, use in uses.items():
            sums[key] = sums.get(key, GraspUse()) + use
    return sums
