"""Parts that stay in the bin when a planning ends without a plan, and what is in the way there."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Reason
from workbench.model.messages.changes import RemainText
from workbench.model.messages.message import FoundPart, Message, found_part
from workbench.model.scan import Detection

Hindrance = Literal["walls", "neighbours", "floor", "ways", "reach", "other"]

WALL, FLOOR = "wall", ("floor", "table")
"""What the names of such bodies contain."""

MOST_REMEMBERED = 400
"""Remaining parts that a session remembers, the latest ones."""


@dataclass(frozen=True, slots=True, eq=False)
class RemainingPart:
    """The part `number` of a pile, which no candidate could take, and what refused most of them."""

    pile: tuple[Detection, ...]
    number: int
    hindrance: Hindrance

    @property
    def part(self) -> str:
        """Which kind it is."""
        return self.pile[self.number].part


class Remaining:
    """Gathers remaining parts, planning after planning.

    A pile without a plan is planned again and again: only its last planning counts.

    Concurrency: one thread.
    """

    def __init__(self) -> None:
        self._before: tuple[RemainingPart, ...] = ()
        self._now: tuple[RemainingPart, ...] = ()

    def add(self, found: Sequence[Mapping[str, Any]], result: Mapping[str, Any]) -> None:
        """Take in a planning: the detections and what came of it, in canonical form."""
        if result["plan"] is None:
            self._now = remaining(found, result["candidates"])
        else:
            self._before, self._now = self.value, ()

    @property
    def value(self) -> tuple[RemainingPart, ...]:
        """The parts, the latest last."""
        return (*self._before, *self._now)[-MOST_REMEMBERED:]


def remaining(
    detections: Sequence[Mapping[str, Any]], candidates: Sequence[Mapping[str, Any]]
) -> tuple[RemainingPart, ...]:
    """The parts that no candidate could take, in a planning that brought no plan.

    Those outside the regions of interest are not wanted, and do not count.

    Args:
        detections: in canonical form.
        candidates: of these detections, in canonical form.
    """
    pile = tuple(
        Detection(form["part"], pin.SE3(np.array(form["T_world_part"]))) for form in detections
    )
    refused: list[Counter[Hindrance]] = [Counter() for _ in pile]
    others: set[int] = set()
    for candidate in candidates:
        number, verdict = candidate["detection"], candidate["verdict"]
        if verdict["reason"] in (Reason.OK, Reason.OUTSIDE_REGIONS):
            others.add(number)
        elif verdict["reason"] != Reason.DISABLED:
            refused[number][_hindrance(verdict)] += 1
    return tuple(
        RemainingPart(pile, number, _main(refused[number]))
        for number in range(len(pile))
        if number not in others
    )


def remaining_words(parts: Sequence[RemainingPart]) -> list[Message]:
    """How many parts of which kind stayed, and what is in the way; the most first."""
    counts = Counter((left.part, left.hindrance) for left in parts)
    ordered = sorted(counts.items(), key=lambda item: (-item[1], item[0]))
    return [
        RemainText[hindrance.upper()](count=count, part=part)
        for (part, hindrance), count in ordered
    ]


def _hindrance(verdict: Mapping[str, Any]) -> Hindrance:
    match verdict["reason"]:
        case Reason.OUT_OF_REACH:
            return "reach"
        case Reason.APPROACH_BLOCKED | Reason.EXTRACT_BLOCKED:
            return "ways"
        case Reason.TOOL_COLLISION | Reason.IN_COLLISION:
            return _find_hindrance(verdict["pair"] or ())
        case _:
            return "other"


def _find_hindrance(pair: Sequence[str]) -> Hindrance:
    """What a tool or an arm meets, by the names of two bodies."""
    if any(WALL in body for body in pair):
        return "walls"
    if any(isinstance(found_part(body), FoundPart) for body in pair):
        return "neighbours"
    return "floor" if any(word in body for body in pair for word in FLOOR) else "other"


def _main(refused: Counter[Hindrance]) -> Hindrance:
    """What refused most; the floor alone where nothing else did.

    Grasps that would come from below meet the floor at every part, wherever it lies.
    """
    for kind, _ in refused.most_common():
        if kind != "floor":
            return kind
    return "floor" if refused else "other"
