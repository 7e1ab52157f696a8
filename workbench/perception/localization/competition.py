"""The hypotheses of all kinds compete: one after the other is taken, the largest first.

A bolt fits on the side of a cylinder, and a small plate on every face.  Where a part of another
kind explains the same and much more of the scan, nobody needs to look closely.  Should that part
fall when all are held together (`judging`), its surface is searched again with the next effort.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats
from workbench.model.scan import Objection
from workbench.perception.localization.assessment import Assessment, assess
from workbench.perception.localization.choice import Hypothesis, Rejection, enough, gain, take
from workbench.perception.localization.judging import Sought
from workbench.perception.localization.sightings import look

OUTDONE = 1.5
"""A part speaks for so much more area than one of another kind that lies in it: what it leaves is
all that counts of the other."""


@dataclass(slots=True, eq=False)
class Entry:
    """The hypotheses of one kind that are left.

    `gains` (k,) [m2] is the area that speaks for each of them, `largest` (pixels,) [m2] that of
    the largest part of another kind that explains a pixel of this kind's maps, 0 where none does.
    """

    one: Sought
    left: list[Hypothesis]
    gains: Floats
    largest: Floats

    def weigh(self) -> None:
        """The gains anew, when something was taken."""
        claimed, area = self.one.choice.claimed, self.one.maps.pitch**2
        self.gains = np.array([area * gain(each.sighting, claimed) for each in self.left])


def compete(
    brought: Sequence[Sought], found: Sequence[list[Hypothesis]], step: Callable[[str], None]
) -> None:
    """Take the hypotheses that hold together after a close look, those that gain most first.

    Args:
        brought: the kinds; what is taken and what is not is added to their choices.
        found: the possible poses of each, fitted roughly.
        step: told what is being done; it may raise to give up.
    """
    entries = [
        Entry(one, list(poses), np.empty(0), np.zeros(one.maps.depth.size))
        for one, poses in zip(brought, found, strict=True)
        if poses
    ]
    for entry in entries:
        entry.weigh()
    while entries := [entry for entry in entries if entry.left]:
        entry = max(entries, key=lambda each: float(each.gains.max()))
        best = int(entry.gains.argmax())
        hypothesis = entry.left.pop(best)
        entry.gains = np.delete(entry.gains, best)
        taken = _taken(entry, hypothesis, step)
        if taken is None:
            continue
        entry.weigh()
        for other in entries:
            if other is not entry:
                _cover(other, entry.one, taken)


def _taken(entry: Entry, hypothesis: Hypothesis, step: Callable[[str], None]) -> Assessment | None:
    one = entry.one

    def closely(pose: Floats) -> Assessment:
        step("look closely")
        return assess(one.maps, one.glance, one.surface, pose, one.tolerance)

    if _is_outdone(entry, hypothesis):
        one.choice.rejected.append(
            Rejection(hypothesis.pose, hypothesis.sighting, Objection.OUTDONE)
        )
        return None
    return take(one.choice, one.surface, hypothesis, closely, one.spread, one.tolerance)


def _is_outdone(entry: Entry, hypothesis: Hypothesis) -> bool:
    """Whether much larger parts of other kinds leave too little of what it explains."""
    seen = hypothesis.sighting
    area = max(seen.gain, 0.0) * entry.one.maps.pitch**2
    outdone = entry.largest[seen.explained] > OUTDONE * area
    left = len(outdone) - int(np.count_nonzero(outdone))
    return left < len(outdone) and left < enough(seen)


def _cover(entry: Entry, kind: Sought, taken: Assessment) -> None:
    """What a part of another kind that was taken explains in this kind's maps."""
    area = taken.sighting.gain * kind.maps.pitch**2
    explained = look(entry.one.maps, kind.surface, taken.pose, kind.tolerance).explained
    entry.largest[explained] = np.maximum(entry.largest[explained], area)
