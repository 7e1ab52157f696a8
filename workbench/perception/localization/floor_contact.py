"""Size errors of parts that lie on the floor, from the height of their underside.

The visible side of a part is fitted to the scan; its underside follows from the CAD file.  A part
on the floor must end at the floor.  If it ends below or above, its height differs from the file.
Parts that lie on others end above the floor, too, at any height, so several must agree.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats
from workbench.perception.localization.choice import PartSearch

FEWEST_SHARE = 1 / 3
"""Of the parts asked at least this share has to agree."""


@dataclass(frozen=True, slots=True)
class Agreement:
    """What several parts show alike: its value, the deviation of that, and how many show it."""

    value: float
    deviation: float
    count: int


def agree(values: Sequence[float], within: float, fewest: int) -> Agreement | None:
    """What most of the values show, None where too few are within one distance of each other."""
    shown = np.sort(np.asarray(values, np.float64))
    if len(shown) < fewest:
        return None
    ends = np.searchsorted(shown, shown + within, side="right")
    first = int(np.argmax(ends - np.arange(len(shown))))
    alike = shown[first : ends[first]]
    if len(alike) < max(fewest, FEWEST_SHARE * len(shown)):
        return None
    deviation = float(np.std(alike) / np.sqrt(len(alike)))
    return Agreement(float(np.median(alike)), deviation, len(alike))


def shown_offsets(search: PartSearch, poses: Sequence[Floats] | Floats) -> list[float]:
    """How far outside of the CAD file the surface lies [m] of parts that end at the floor.

    Args:
        search: its surface may have grown already.
        poses: (4, 4) [m] in the scanner's frame, each fitted to what is seen; none where the floor
            is not seen.
    """
    # Both sides of a part lie off: it floats by twice as much.
    return [search.grown + lowest / 2 for lowest, _ in _reaches(search, poses)]


def shown_scales(search: PartSearch, poses: Sequence[Floats] | Floats) -> list[float]:
    """How large parts at poses (4, 4) are over their CAD file, no unit; see `shown_offsets`."""
    return [search.scaled * high / (high - low) for low, high in _reaches(search, poses)]


def _reaches(search: PartSearch, poses: Sequence[Floats] | Floats) -> list[tuple[float, float]]:
    """The lowest and the highest point over the floor [m] of a part at each pose (4, 4).

    Of turns that the scan may not tell apart that counts which reaches down least.
    """
    if search.heights is None:
        return []
    turns = search.surface.symmetry.turns
    turns = np.eye(4)[None] if len(turns) == 0 else turns
    reaches: list[tuple[float, float]] = []
    for pose in poses:
        T = pose @ turns
        points = search.surface.vertices @ T[:, :3, :3].transpose(0, 2, 1) + T[:, None, :3, 3]
        heights = search.heights(points.reshape(-1, 3)).reshape(len(turns), -1)
        best = int(heights.min(axis=1).argmax())
        reaches.append((float(heights[best].min()), float(heights[best].max())))
    return reaches
