"""Why a part stayed in the bin, and the smallest change of a grasp that would take it."""

import re
from collections import Counter
from collections.abc import Sequence

import numpy as np

from workbench.app.core.outcomes import MOST_FAILURES, SAME_PLACE
from workbench.app.picking.pipeline import judge
from workbench.model.candidate import Candidate, Reason, Verdict
from workbench.model.cell import Cell
from workbench.model.prediction import LeftPart
from workbench.model.scan import Detection
from workbench.planning.picking.nearest_fix import nearest_fix

TOUCHING = (Reason.TOOL_COLLISION, Reason.IN_COLLISION)
"""Bodies that meet, or do not keep their margin."""

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
        seed: of the judging.
        is_stopped: failed picks have ended it, whatever else could have been taken.
        fixes: whether the nearest fix is looked for, which takes a second for each part.
    """
    detections = tuple(one for _, one in lying)
    if not detections:
        return ()
    judged = judge(cell, detections, seed=seed)
    names = [f"part-{number + 1}" for number, _ in lying]
    found: list[LeftPart] = []
    for index, name in enumerate(names):
        mine = tuple(one for one in judged if one.detection == index)
        if any(one.verdict.is_ok for one in mine):
            if is_stopped:
                kind, why = "stopped", f"it was stopped after {MOST_FAILURES} failed picks in a row"
            elif refusal is None:
                kind, why = _as_found(lying, index, looked)
            else:
                kind, why = str(refusal.reason), f"no plan came out: {refusal}"
            found.append(LeftPart(name, kind, f"a grasp of it works, but {why}", ""))
            continue
        best = max((one.verdict for one in mine), key=lambda one: one.progress)
        fix = nearest_fix(cell, detections, mine, seed=seed, may_move_bin=False) if fixes else None
        sentence = _renamed(_sentence(mine, best), names)
        found.append(LeftPart(name, str(best.reason), sentence, "" if fix is None else fix.change))
    return tuple(found)


def _as_found(lying: Numbered, index: int, looked: Looked) -> tuple[str, str]:
    """Why a part that could be taken as it lies was not taken as it was found, if it was."""

    def is_same(found: Detection, one: Detection) -> bool:
        off = found.T_world_part.translation - one.T_world_part.translation
        return found.part == one.part and bool(np.linalg.norm(off) < SAME_PLACE)

    def name(found: Detection) -> str:
        fell = (f"part-{number + 1}" for number, one in lying if is_same(found, one))
        return next(fell, "what was taken for a part")

    for found, verdict in looked:
        if is_same(found, lying[index][1]):
            said = _renamed(str(verdict), [name(one) for one, _ in looked])
            why = f"not as the last scan shows it and what is near: {said}"
            return str(verdict.reason), why
    return "not found", "it was not found"


def _sentence(mine: Sequence[Candidate], best: Verdict) -> str:
    counted = Counter(one.verdict.reason for one in mine)
    told = ", ".join(f"{count} {reason}" for reason, count in counted.most_common())
    how = str(best)
    if best.reason is not Reason.OUT_OF_REACH and best.distance is not None and best.distance < 0:
        how += " into each other"
    elif best.distance is not None and best.reason in TOUCHING:
        how += ", nearer than the margin"
    return f"none of {len(mine)} candidates works ({told}); the one that got furthest: {how}"


def _renamed(text: str, names: Sequence[str]) -> str:
    """The text with the labels of parts as they fell, not as they were judged."""

    def name(match: re.Match[str]) -> str:
        index = int(match[1]) - 1
        return names[index] if 0 <= index < len(names) else match[0]

    return re.sub(r"\bpart-(\d+)\b", name, text)
