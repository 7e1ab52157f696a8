"""A localizer that believes only what it has found twice."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

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
        both = self._merged(first.detections, second.detections)
        surest_first = sorted(both, key=lambda detection: -detection.score)
        return LocalizationResult(tuple(surest_first), first.rejected)

    def _merged(
        self, first: tuple[Detection, ...], second: tuple[Detection, ...]
    ) -> Iterator[Detection]:
        for a in first:
            for b in second:
                shift = b.T_world_part.translation - a.T_world_part.translation
                if a.part == b.part and np.linalg.norm(shift) < self._apart:
                    middle = a.T_world_part.translation + shift / 2
                    yield Detection(
                        part=a.part,
                        T_world_part=pin.SE3(a.T_world_part.rotation, middle),
                        score=min(a.score, b.score),
                        visible=a.visible,
                        roll_known=a.roll_known and b.roll_known,
                        roll_axis=a.roll_axis,
                        covariance=a.covariance,
                        probability=a.probability,
                    )
                    break
