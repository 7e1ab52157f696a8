"""Plans in a row: parts they take or leave, by their numbers in the first, and what is no row."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.candidate import Candidate
from workbench.model.messages.message import FoundPart, Message, found_part
from workbench.model.messages.refusals import ChangeRefusal
from workbench.model.plan import Plan
from workbench.model.scan import Detection


def number_in(first: Plan, detection: Detection) -> int:
    """The index of a part in the list of the first plan of a row.

    Later plans have lists without what those before take, or with it on a station; digits of a file
    may differ in the last place.
    """
    T = (detection.T_world_found or detection.T_world_part).homogeneous
    away = [np.abs(known.T_world_part.homogeneous - T).max() for known in first.detections]
    return int(np.argmin(away))


def parts_taken(first: Plan, plan: Plan) -> tuple[int, ...]:
    """Indices of the parts that a plan of a row takes, in the list of the first one of the row."""
    if plan is first:
        return tuple(arm.detection for arm in plan.picks)
    return tuple(number_in(first, plan.detections[arm.detection]) for arm in plan.picks)


def count_taken(plans: Sequence[Plan]) -> int:
    """How many parts plans in a row take; one that goes over a station counts once."""
    return len({number for plan in plans for number in parts_taken(plans[0], plan)})


@dataclass(frozen=True, slots=True, eq=False)
class PartFate:
    """What plans in a row do with a part that was found.

    Attributes:
        taken_by: the arms that take the part, in order; none: the part is left.
        tried: the candidates of the part, of all arms, with their verdicts.
    """

    taken_by: tuple[str, ...]
    tried: tuple[Candidate, ...]

    @property
    def feasible(self) -> int:
        """How many candidates work, of arms that now take other parts, too."""
        return sum(candidate.verdict.is_ok for candidate in self.tried)

    @property
    def refused(self) -> Candidate | None:
        """The candidate that got farthest; None where some work, or where none was tried."""
        if self.feasible or not self.tried:
            return None
        return max(self.tried, key=lambda candidate: candidate.verdict.progress)


def fates_of(
    plans: Sequence[Plan], candidates: Sequence[Candidate], count: int
) -> tuple[PartFate, ...]:
    """What plans in a row do with each of `count` parts that were found, in their order."""
    arms: dict[int, list[str]] = {}
    picking = [plan for plan in plans if plan.picks]
    for plan in picking:
        for number, pick in zip(parts_taken(picking[0], plan), plan.picks, strict=True):
            arms.setdefault(number, []).append(pick.arm)
    tried: dict[int, list[Candidate]] = {}
    for candidate in candidates:
        tried.setdefault(candidate.detection, []).append(candidate)
    return tuple(
        PartFate(tuple(arms.get(number, ())), tuple(tried.get(number, ())))
        for number in range(count)
    )


def renumber(message: Message, first: Plan, detections: Sequence[Detection]) -> Message:
    """A message about a later plan, of its own `detections`, by the numbers of the row's first."""
    return message.renumber(lambda index: _index_in(first, detections, index))


def label_in(label: str, first: Plan, detections: Sequence[Detection]) -> str:
    """What a body of a later plan, of its own `detections`, is called in the row's first."""
    part = found_part(label)
    if isinstance(part, str):
        return label
    return str(FoundPart(_index_in(first, detections, part.index)))


def tool_change_in_row(plans: Sequence[Plan]) -> Message | None:
    """Why plans are no row, as one of several changes a tool; None when none does.

    Plans after it need the cell with the other tool.
    """
    changes = [number for number, plan in enumerate(plans, 1) if plan.is_tool_plan]
    return ChangeRefusal.TOOL_ROW(number=changes[0]) if changes and len(plans) > 1 else None


def _index_in(first: Plan, detections: Sequence[Detection], index: int) -> int:
    return number_in(first, detections[index]) if index < len(detections) else index
