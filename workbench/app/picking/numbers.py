"""What is said of a later plan of a row, by the numbers that parts have in the first one."""

from collections.abc import Sequence

from workbench.model.derived.row_parts import number_in
from workbench.model.messages.message import FoundPart, Message, found_part
from workbench.model.plan import Plan
from workbench.model.scan import Detection


def renumber(message: Message, first: Plan, detections: Sequence[Detection]) -> Message:
    """A message about a later plan, of its own `detections`, by the numbers of the row's first."""
    return message.renumber(lambda index: _index_in(first, detections, index))


def label_in(label: str, first: Plan, detections: Sequence[Detection]) -> str:
    """What a body of a later plan, of its own `detections`, is called in the row's first."""
    part = found_part(label)
    if isinstance(part, str):
        return label
    return str(FoundPart(_index_in(first, detections, part.index)))


def _index_in(first: Plan, detections: Sequence[Detection], index: int) -> int:
    return number_in(first, detections[index]) if index < len(detections) else index
