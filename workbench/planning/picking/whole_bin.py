"""What stands in the way of a whole bin, and which change lets most of its parts be taken."""

from collections import Counter
from collections.abc import Callable, Container, Sequence
from dataclasses import dataclass

from workbench.model.candidate import Candidate, Reason
from workbench.model.cell import Cell
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.work import ProgressText
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.bodies import carried_bodies, part_label
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.nearest_fix import Fixes

MOST_EACH = 3
"""Refused candidates of a part that changes are tried on, those that got furthest."""


@dataclass(frozen=True, slots=True)
class Blocker:
    """Something that refuses candidates: its label, how many, of which parts, and for what reasons.

    `parts` are indices of detections.
    """

    label: str
    candidates: int
    parts: tuple[int, ...]
    reasons: tuple[tuple[Reason, int], ...]


def blockers(cell: Cell, candidates: Sequence[Candidate]) -> tuple[Blocker, ...]:
    """What refuses most candidates, that first.

    Of the two bodies that come too close it is the one that the arm does not carry.  Refusals
    without such a pair, for example out of reach, are left out.

    Args:
        cell: that the candidates were judged in.
        candidates: all of them, judged.
    """
    own = _labels(cell)
    found: dict[str, list[Candidate]] = {}
    for candidate in candidates:
        label = _in_the_way(candidate, own[candidate.arm])
        if label:
            found.setdefault(label, []).append(candidate)
    rows = [
        Blocker(
            label,
            len(some),
            tuple(sorted({candidate.detection for candidate in some})),
            tuple(Counter(candidate.verdict.reason for candidate in some).most_common()),
        )
        for label, some in found.items()
    ]
    return tuple(sorted(rows, key=lambda row: (-row.candidates, row.label)))


def _labels(cell: Cell) -> dict[str, frozenset[str]]:
    """For each arm the labels of the links and the tool that it carries."""
    carried = carried_bodies(cell, Kinematics(cell))
    return {
        arm.name: frozenset(body.label for body in carried if body.arm == number)
        for number, arm in enumerate(cell.arms)
    }


def _in_the_way(candidate: Candidate, own: Container[str]) -> str:
    """The label of what refuses a candidate, of bodies not its arm's `own`; empty for nothing."""
    if candidate.verdict.is_ok or candidate.verdict.pair is None:
        return ""
    part = part_label(candidate.detection)
    others = [label for label in candidate.verdict.pair if label != part and label not in own]
    return others[0] if others else part


def common_fixes(
    cell: Cell,
    detections: tuple[Detection, ...],
    candidates: Sequence[Candidate],
    *,
    seed: int,
    obstacles: tuple[Obstacle, ...] = (),
    report: Callable[[float, Message], None] = lambda done, note: None,
) -> tuple[tuple[Message, tuple[int, ...]], ...]:
    """Changes that admit a candidate of parts that nothing takes, and of which parts: most first.

    Each change is made to every grasp alone, not to those of other parts; it is tried up to the
    place, on the `MOST_EACH` candidates of a part that got furthest.

    Args:
        cell: that the candidates were judged in.
        detections: the parts found.
        candidates: all of them, judged.
        seed: of the request.
        obstacles: other objects in the scan.
        report: progress.
    """
    taken = {candidate.detection for candidate in candidates if candidate.verdict.is_ok}
    stay = [number for number in range(len(detections)) if number not in taken]
    fixes = Fixes(cell, detections, obstacles, seed=seed)
    found: dict[Message, list[int]] = {}
    for done, number in enumerate(stay):
        report(done / len(stay), ProgressText.WHAT_TAKES(part=FoundPart(number)))
        mine = [
            candidate
            for candidate in candidates
            if candidate.detection == number and candidate.verdict.pair is not None
        ]
        best = sorted(mine, key=lambda candidate: candidate.verdict.progress, reverse=True)[
            :MOST_EACH
        ]
        works: set[Message] = set()
        for candidate in best:
            works |= {
                fix.change
                for fix in fixes.of(candidate)
                if fix.change not in works and fixes.admits(fix)
            }
        for change in sorted(works, key=str):
            found.setdefault(change, []).append(number)
    rows = sorted(found, key=lambda change: (-len(found[change]), str(change)))
    return tuple((change, tuple(found[change])) for change in rows)
