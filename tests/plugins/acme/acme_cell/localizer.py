"""A localizer that believes only what it has found twice."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from workbench.model.cell import Cell
from workbench.model.scan import Detection, LocalizationResult, Scan
from workbench.perception.built_in import PointPairs
from workbench.plugins.options import NoOptions, option


class Twice:
    """Searches with two seeds; what only one of them finds is left out."""

    @dataclass(frozen=True)
    class Options:
        """Keys in `[localizer.options]`."""

        apart_mm: float = option(2.0, low=0.1, high=20.0, says="farther apart is not the same")

    def __init__(self, options: Options) -> None:
        self._apart = options.apart_mm / 1000

    def find(
        self,
        scan: Scan,
        cell: Cell,
        *,
        seed: int,
        detail: float,
        report: Callable[[float, str], None],
        cancelled: Callable[[], bool],
    ) -> LocalizationResult:
        """The parts that both searches have found."""

        def search(number: int) -> LocalizationResult:
            return PointPairs(NoOptions()).find(
                scan,
                cell,
                seed=seed + number,
                detail=detail,
                report=lambda done, note: report((number + done) / 2, note),
                cancelled=cancelled,
            )

        first, second = search(0), search(1)
        both = [one for one in first.detections if self._is_in(one, second.detections)]
        return LocalizationResult(tuple(both), first.rejected)

    def _is_in(self, one: Detection, others: tuple[Detection, ...]) -> bool:
        p = one.T_world_part.translation
        return any(
            other.part == one.part
            and np.linalg.norm(other.T_world_part.translation - p) < self._apart
            for other in others
        )
