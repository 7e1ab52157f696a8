"""The promises of localizers, tried on a simulated scan of the cell's own parts."""

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.errors import JobCancelled
from workbench.model.scan import LocalizationResult
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize
from workbench.plugins.localizer import Localizer
from workbench.plugins.progress import never, silent
from workbench.testing.options import check_options

RIGHT_WITHIN = 0.01
"""Largest distance [m] of a found part from a real part."""


def check_localizer(
    kind: type[Localizer], cell: Cell, *, parts: int = 3, seed: int = 1
) -> LocalizationResult:
    """A localizer finds what is there, nothing that is not, the same again, and can be cancelled.

    Args:
        kind: the class that is declared.
        cell: with its options; a simulated pile of its first part is scanned.
        parts: that lie in the bin; most of them have to be found.
        seed: of the pile.

    Returns:
        What it found.
    """
    localizer = kind(check_options(kind.Options, cell.localizer.options))
    truth = pile_of(cell, "", parts, seed=seed)
    scan = synthesize(cell, truth, seed=seed)

    def find() -> LocalizationResult:
        return localizer.find(
            scan,
            cell,
            seed=seed,
            detail=1.0,
            report=silent,
            cancelled=never,
        )

    found = find()
    scores = [detection.score for detection in found.detections]
    assert scores == sorted(scores, reverse=True), "the surest comes first"
    assert all(0.0 <= score <= 1.0 for score in scores), "scores are 0..1"
    known = {part.name for part in cell.parts}
    there = [detection.T_world_part.translation for detection in truth]
    for detection in found.detections:
        assert detection.part in known, f"the cell has no part {detection.part!r}"
        off = min(float(np.linalg.norm(detection.T_world_part.translation - p)) for p in there)
        assert off < RIGHT_WITHIN, f"a part was found {off * 1000:.0f} mm from where one lies"
    assert len(found.detections) > parts / 2, f"{len(found.detections)} of {parts} were found"
    again = find()
    assert len(again.detections) == len(found.detections) and all(
        _same(detection.T_world_part, other.T_world_part)
        for detection, other in zip(found.detections, again.detections, strict=True)
    ), "the same seed finds the same"
    try:
        localizer.find(
            scan,
            cell,
            seed=seed,
            detail=1.0,
            report=silent,
            cancelled=lambda: True,
        )
    except JobCancelled:
        return found
    raise AssertionError("a search that was cancelled went on")


def _same(T: pin.SE3, other: pin.SE3) -> bool:
    return bool(np.array_equal(T.homogeneous, other.homogeneous))
