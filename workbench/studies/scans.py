"""Scans that somebody brought, searched one after the other: what is found, and what is not."""

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from workbench.app.runtime.work import find_parts
from workbench.model.cell import Cell
from workbench.model.scan import LocalizationResult, Scan
from workbench.planning.planners.clock import processor_time
from workbench.plugins.progress import never, silent

SURE_PROBABILITY = 0.5
"""The chance with which a part counts as surely found."""


@dataclass(frozen=True, slots=True, eq=False)
class SearchedScan:
    """One scan, what was found in it, and the processor time [s] of the search.

    `why` counts the rejected hypotheses by their reasons.
    """

    name: str
    scan: Scan
    result: LocalizationResult
    why: Mapping[str, int]
    processor_seconds: float

    @property
    def sure(self) -> int:
        """How many parts are rather there than not."""
        return sum(
            (detection.probability or 0.0) >= SURE_PROBABILITY
            for detection in self.result.detections
        )


def searched_scans(
    cell: Cell,
    named: Sequence[tuple[str, Callable[[], Scan]]],
    *,
    seed: int,
    step: Callable[[float, str], None] = silent,
) -> list[SearchedScan]:
    """Search each scan as `workbench localize` does.

    Args:
        cell: its parts are searched for.
        named: the name of each scan, and what reads it.
        seed: of the search.
        step: called with the share done and the scan that is next.
    """
    searched: list[SearchedScan] = []
    for number, (name, read) in enumerate(named):
        step(number / len(named), name)
        scan = read()
        began = processor_time()
        result = find_parts(cell, {"scan": scan, "seed": seed}, silent, never)
        seconds = processor_time() - began
        why = Counter(rejection.reason.value for rejection in result.rejected)
        searched.append(SearchedScan(name, scan, result, dict(why.most_common()), seconds))
    return searched
