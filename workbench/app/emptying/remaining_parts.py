"""Why a part stayed in the bin, and the smallest change of a grasp that would take it."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.app.core.cycle.outcomes import MOST_FAILURES, SAME_PLACE
from workbench.app.picking.judging import furthest_verdict, judge
from workbench.model.candidate import Candidate, Verdict
from workbench.model.cell import Cell
from workbench.model.messages.message import FoundPart, Message
from workbench.model.messages.states import LeftText
from workbench.model.plan import PlanResult
from workbench.model.prediction import NOT_FOUND, STOPPED, LeftPart
from workbench.model.scan import Detection, Obstacle
from workbench.planning.picking.nearest_fix import nearest_fix

Numbered = Sequence[tuple[int, Detection]]
"""Parts with the number under which they fell."""

Looked = Sequence[tuple[Detection, Verdict]]
"""What a look has found, each with its verdict that got furthest."""


def left_in(
    cell: Cell,
    lying: Numbered,
    *,
    refusal: Verdict | None,
    looked: Looked = (),
    obstacles: tuple[Obstacle, ...] = (),
    seed: int,
    is_stopped: bool = False,
    fixes: bool = True,
) -> tuple[LeftPart, ...]:
    """Each part that lies in the bin, with why it was not taken.

    Args:
        cell: that it was tried in.
        lying: what is left, as it truly lies.
        refusal: what the last plan was refused for, if there was a pick for it.
        looked: what the last look has found, numbered otherwise than `lying`.
        obstacles: what else was in the way.
        seed: of the judging.
        is_stopped: failed picks have ended it, whatever else could have been taken.
        fixes: whether the nearest fix is searched for, which takes a second for each part.
    """
    detections = tuple(detection for _, detection in lying)
    if not detections:
        return ()
    judged = judge(cell, detections, obstacles=obstacles, seed=seed)
    found: list[LeftPart] = []
    for index, (number, _) in enumerate(lying):
        label = str(FoundPart(number))
        mine = tuple(candidate for candidate in judged if candidate.detection == index)
        if any(candidate.verdict.is_ok for candidate in mine):
            if is_stopped:
                kind, why = STOPPED, LeftText.WAS_STOPPED(count=MOST_FAILURES)
            elif refusal is None:
                kind, why = _as_found(lying, index, looked)
            else:
                kind, why = str(refusal.reason), LeftText.NO_PLAN(verdict=refusal.message)
            found.append(LeftPart(label, kind, LeftText.WORKS_BUT(why=why), ""))
            continue
        searches = cell.part(detections[index].part).library.searches
        verdicts = [candidate.verdict for candidate in mine]
        best = max(
            verdicts,
            key=lambda verdict: verdict.progress,
            default=furthest_verdict((), is_searched=searches),
        )
        fix = None
        if fixes:
            fix = nearest_fix(
                cell, detections, mine, seed=seed, obstacles=obstacles, may_move_bin=False
            )
        why = _none_works(mine, best).renumber(lambda index: lying[index][0])
        found.append(LeftPart(label, str(best.reason), why, "" if fix is None else fix.change))
    return tuple(found)


def _as_found(lying: Numbered, index: int, looked: Looked) -> tuple[str, Message]:
    """Why a part that could be taken as it lies was not taken as it was found, if it was."""

    def is_same(found: Detection, detection: Detection) -> bool:
        off = found.T_world_part.translation - detection.T_world_part.translation
        return found.part == detection.part and bool(np.linalg.norm(off) < SAME_PLACE)

    def as_fallen(index: int) -> int | Message:
        fell = (number for number, detection in lying if is_same(looked[index][0], detection))
        return next(fell, LeftText.FALSE_PART())

    for found, verdict in looked:
        if is_same(found, lying[index][1]):
            said = verdict.message.renumber(as_fallen)
            return str(verdict.reason), LeftText.AS_SCANNED(verdict=said)
    return NOT_FOUND, LeftText.WAS_NOT_FOUND()


def _none_works(mine: Sequence[Candidate], best: Verdict) -> Message:
    if not mine:
        return best.message
    counted = Counter(candidate.verdict.kind for candidate in mine)
    reasons = (
        LeftText.COUNTED(count=count, reason=reason.message)
        for reason, count in counted.most_common()
    )
    return LeftText.NONE_WORKS(count=len(mine), reasons=reasons, verdict=best.message)


def as_seen(
    lying: Sequence[tuple[int, Detection]], seen: Sequence[Detection]
) -> list[tuple[int, Detection]]:
    """What lies in the bin as it lies, its roll unknown where the last scan does not show it."""

    def of(detection: Detection) -> Detection:
        for found in seen:
            off = found.T_world_part.translation - detection.T_world_part.translation
            if (
                not found.roll_known
                and found.part == detection.part
                and np.linalg.norm(off) < SAME_PLACE
            ):
                return replace(detection, roll_known=False, roll_axis=found.roll_axis)
        return detection

    return [(number, of(detection)) for number, detection in lying]


def summarize(seen: Sequence[Detection], result: PlanResult | None) -> Looked:
    """What the last scan showed and what was said of it; nothing where poses are true ones."""
    verdicts: dict[int, Verdict] = {}
    for candidate in () if result is None else result.candidates:
        best = verdicts.setdefault(candidate.detection, candidate.verdict)
        verdicts[candidate.detection] = max(
            best, candidate.verdict, key=lambda verdict: verdict.progress
        )
    return [
        (detection, verdicts[number]) for number, detection in enumerate(seen) if number in verdicts
    ]


def left_alone(
    detections: Sequence[Detection], failed: Sequence[Detection]
) -> Mapping[int, Message]:
    """Numbers of the parts whose pick has failed a short while ago, and why they are left."""
    return {
        number: LeftText.PICK_FAILED()
        for number, detection in enumerate(detections)
        for other in failed
        if detection.part == other.part
        and np.linalg.norm(detection.T_world_part.translation - other.T_world_part.translation)
        <= SAME_PLACE
    }
