"""What differs between two grasp libraries, in words."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from workbench.formats.parts.grasp_files import keys_of
from workbench.model.geometry import shift_and_turn
from workbench.model.messages.changes import GraspChange
from workbench.model.messages.message import Message
from workbench.model.part import Entry, GraspLibrary, GraspPair, GraspPattern
from workbench.model.part_edits import grasp_of

KEYS = (
    "opening_mm", "grip_mm", "approach", "approach_length_mm", "retreat", "retreat_length_mm",
    "priority", "arms", "tool", "free_rotation_deg", "tilt_deg", "slide_mm",
)  # fmt: skip
"""Of a grasp file, in the order in which changes of them are listed; each has a `GraspChange`."""


def changes_in_words(old: GraspLibrary, new: GraspLibrary) -> tuple[Message, ...]:
    """A message for each thing in which `new` differs from `old`, in their order."""
    before = {entry.name: entry for entry in old.entries}
    after = {entry.name: entry for entry in new.entries}
    found = [GraspChange.GONE(name=name) for name in before if name not in after]
    for name, entry in after.items():
        if name not in before:
            found.append(GraspChange.NEW_KIND(name=name, kind=_kind(entry)))
        elif changes := tuple(_changes(before[name], entry)):
            found.append(GraspChange.CHANGED(name=name, changes=changes))
    kept = [
        [name for name in names if name in others]
        for names, others in ((before, after), (after, before))
    ]
    if kept[0] != kept[1]:
        found.append(GraspChange.ORDER())
    if old.searches != new.searches:
        found.append(GraspChange.SEARCH() if new.searches else GraspChange.NO_SEARCH())
    found += [
        GraspChange.GONE(name=_describe_pair(pair))
        for pair in old.pairs
        if not _is_in(pair, new.pairs)
    ]
    found += [
        GraspChange.NEW(name=_describe_pair(pair))
        for pair in new.pairs
        if not _is_in(pair, old.pairs)
    ]
    return tuple(found)


def _kind(entry: Entry) -> Message:
    if isinstance(entry, GraspPattern):
        return GraspChange.PATTERN(count=entry.count)
    return GraspChange.GRASP()


def _changes(old: Entry, new: Entry) -> Iterator[Message]:
    before, after = keys_of(old), keys_of(new)
    yield from _list_moves(old, new)
    if before.get("enabled", True) != after.get("enabled", True):
        yield GraspChange.DISABLED() if "enabled" in after else GraspChange.ENABLED()
    for key in KEYS:
        if before.get(key) != after.get(key):
            text = GraspChange[key.upper()]
            yield text(before=_format(before.get(key)), after=_format(after.get(key)))
    old_pattern, new_pattern = before.get("pattern"), after.get("pattern")
    if old_pattern is not None and new_pattern is None:
        yield GraspChange.NO_PATTERN()
    elif old_pattern is None and new_pattern is not None:
        yield GraspChange.REPEATED(kind=_kind(new))
    elif old_pattern is not None and old_pattern != new_pattern:
        counts = [entry.count for entry in (old, new) if isinstance(entry, GraspPattern)]
        yield GraspChange.PATTERN_CHANGED(before=counts[0], after=counts[1])


def _list_moves(old: Entry, new: Entry) -> Iterator[Message]:
    old_grasp, new_grasp = map(grasp_of, (old, new))
    shift, turn = shift_and_turn(old_grasp.T_part_tcp.actInv(new_grasp.T_part_tcp))
    if shift * 1000 >= 0.005:
        yield GraspChange.MOVED(by=shift)
    if np.rad2deg(turn) >= 0.005:
        yield GraspChange.TURNED(by=turn)


def _describe_pair(pair: GraspPair) -> Message:
    text = GraspChange.PAIR_ORDERED if pair.is_ordered else GraspChange.PAIR
    return text(first=pair.first, second=pair.second)


def _is_in(pair: GraspPair, pairs: tuple[GraspPair, ...]) -> bool:
    return any(_describe_pair(grasp_pair) == _describe_pair(pair) for grasp_pair in pairs)


def _format(value: Any) -> "Message | str":
    if value is None:
        return GraspChange.AS_USUAL()
    if isinstance(value, list):
        return " ".join(map(str, value)) or GraspChange.ANY()
    return f"{value:g}" if isinstance(value, int | float) else str(value)
