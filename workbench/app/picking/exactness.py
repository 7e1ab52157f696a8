"""Refusals that may be caused by collision bodies larger than the part's mesh."""

from collections.abc import Iterator, Sequence
from dataclasses import replace

from workbench.app.picking.part_import import excess_of
from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.scan import Detection
from workbench.planning.collision.bodies import part_label


def with_exactness(
    cell: Cell, detections: Sequence[Detection], candidates: Sequence[Candidate]
) -> tuple[Candidate, ...]:
    """The candidates, with a remark on refusals where the mesh itself may keep the distance.

    Args:
        cell: with its parts and policy.
        detections: the parts found.
        candidates: with their verdicts.
    """
    return tuple(
        replace(candidate, verdict=_note_excess(cell, detections, candidate.verdict))
        for candidate in candidates
    )


def _note_excess(cell: Cell, detections: Sequence[Detection], verdict: Verdict) -> Verdict:
    if verdict.is_ok or verdict.pair is None or verdict.distance is None:
        return verdict
    excess = sum(
        excess_of(cell.part(detections[number].part)) for number in _parts(verdict, detections)
    )
    needed = cell.policy.near_margin
    if verdict.distance >= needed:
        needed = cell.policy.margin
    if verdict.distance + excess < needed or excess == 0:
        return verdict
    return verdict.with_note(VerdictNote.INEXACT(excess=excess))


def _parts(verdict: Verdict, detections: Sequence[Detection]) -> Iterator[int]:
    """Indices of the detections that a verdict names."""
    numbers = {part_label(number): number for number in range(len(detections))}
    for label in verdict.pair or ():
        if label in numbers:
            yield numbers[label]
