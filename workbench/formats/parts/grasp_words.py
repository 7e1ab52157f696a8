"""What differs between two grasp libraries, in words."""

from collections.abc import Iterator
from typing import Any

import numpy as np

from workbench.formats.parts.grasp_files import keys_of
from workbench.model.geometry import shift_and_turn
from workbench.model.part import Entry, GraspLibrary, GraspPair, GraspPattern

WORDS = {
    "opening_mm": ("opening", "mm"),
    "grip_mm": ("grip", "mm"),
    "approach": ("approach", ""),
    "approach_length_mm": ("approach length", "mm"),
    "retreat": ("retreat", ""),
    "retreat_length_mm": ("retreat length", "mm"),
    "priority": ("priority", ""),
    "arms": ("arms", ""),
    "tool": ("tool", ""),
    "free_rotation_deg": ("free rotation", "°"),
    "tilt_deg": ("tilt", "°"),
    "slide_mm": ("slide", "mm"),
}
"""How keys of a grasp file are called in a sentence, and their unit."""


def changes_in_words(old: GraspLibrary, new: GraspLibrary) -> tuple[str, ...]:
    """A sentence for each entry and pair in which `new` differs from `old`, in their order."""
    before = {entry.name: entry for entry in old.entries}
    after = {entry.name: entry for entry in new.entries}
    found = [f"{name} is gone" for name in before if name not in after]
    for name, entry in after.items():
        if name not in before:
            found.append(f"{name} is new, {_kind(entry)}")
        elif changes := ", ".join(_changes(before[name], entry)):
            found.append(f"{name}: {changes}")
    kept = [
        [name for name in names if name in others]
        for names, others in ((before, after), (after, before))
    ]
    if kept[0] != kept[1]:
        found.append("the order is another")
    found += [
        f"{_describe_pair(pair)} is gone" for pair in old.pairs if not _is_in(pair, new.pairs)
    ]
    found += [f"{_describe_pair(pair)} is new" for pair in new.pairs if not _is_in(pair, old.pairs)]
    return tuple(found)


def _kind(entry: Entry) -> str:
    if isinstance(entry, GraspPattern):
        return f"a pattern of {entry.count} grasps"
    return "a grasp"


def _changes(old: Entry, new: Entry) -> Iterator[str]:
    before, after = keys_of(old), keys_of(new)
    yield from _list_moves(old, new)
    if before.get("enabled", True) != after.get("enabled", True):
        yield "disabled" if "enabled" in after else "enabled"
    for key, (word, unit) in WORDS.items():
        if before.get(key) != after.get(key):
            yield f"{word} {_format(before.get(key), unit)} → {_format(after.get(key), unit)}"
    old_pattern, new_pattern = before.get("pattern"), after.get("pattern")
    if old_pattern is not None and new_pattern is None:
        yield "no pattern any more"
    elif old_pattern is None and new_pattern is not None:
        yield f"repeated as {_kind(new)}"
    elif old_pattern is not None and old_pattern != new_pattern:
        counts = [entry.count for entry in (old, new) if isinstance(entry, GraspPattern)]
        yield f"pattern changed, {counts[0]} → {counts[1]} grasps"


def _list_moves(old: Entry, new: Entry) -> Iterator[str]:
    old_grasp, new_grasp = (e.grasp if isinstance(e, GraspPattern) else e for e in (old, new))
    shift, turn = shift_and_turn(old_grasp.T_part_tcp.actInv(new_grasp.T_part_tcp))
    if shift * 1000 >= 0.005:
        yield f"moved by {shift * 1000:.2f} mm"
    if np.rad2deg(turn) >= 0.005:
        yield f"turned by {np.rad2deg(turn):.2f}°"


def _describe_pair(pair: GraspPair) -> str:
    order = "then" if pair.is_ordered else "with"
    return f"the pair {pair.first} {order} {pair.second}"


def _is_in(pair: GraspPair, pairs: tuple[GraspPair, ...]) -> bool:
    return any(_describe_pair(grasp_pair) == _describe_pair(pair) for grasp_pair in pairs)


def _format(value: Any, unit: str) -> str:
    if value is None:
        return "as usual"
    if isinstance(value, list):
        return " ".join(map(str, value)) or "any"
    return f"{value:g} {unit}".strip().replace(" °", "°") if unit else str(value)
