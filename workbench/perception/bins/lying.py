"""Where parts lie in a scan that shows no rim: on a floor, or over one that was cut away.

A floor is a plane with a connected patch that is wider than any part.  A narrower patch is one
between the parts where the scan has no holes and nothing lies lower; otherwise it is a face of a
part, and the floor lies below the lowest of these.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pinocchio as pin
from scipy.ndimage import find_objects, label
from scipy.spatial import ConvexHull, QhullError

from workbench.model.geometry import Bools, Floats, Ints, sampled
from workbench.perception.bins.floor_search import find_floor

MOST_POINTS = 40_000
"""Points that are checked; of more every second, third, ..."""

ON_FLOOR = 0.006
"""[m] Points this near to the plane are of the floor."""

PIECE, POINTS_A_PIECE = 0.006, 6.0
"""[m] The floor is divided into pieces of this width, or so wide that they hold as many points."""

WIDER, LARGER = 1.5, 0.5
"""A floor's patch is this many times as wide as the largest part, and has this share of the square
of its diameter."""

FILLED, LOWER = 0.8, 0.01
"""Or the scan fills this share of its outline as seen from above.  A smaller share of its points
than the second lies lower than the floor."""

HIGHEST = 0.4
"""[m] What stands higher over the floor is no part on it."""

LEAST_THING = 0.15
"""Things that are narrower than this share of the largest part are no parts."""

BORDER = 0.02
"""[m] Around the parts, at each side of the region."""

OUTLYING = 0.5
"""[percent] Of the points may lie deeper than the lowest parts, or beyond any side of their
region."""

LOWEST_TOP = 0.02
"""[m] Height of the region at least."""

WIDEST = 1.2
"""[m] Things that lie over more than this are not all parts."""


@dataclass(frozen=True, slots=True, eq=False)
class Lying:
    """Where parts lie in a scan.

    `T_scanner_region` is the middle of their region on the floor, z towards the scanner and x
    along the scanner's; `size` (3,) [m] are its length, width and height.  `is_floor_seen` is
    False where the floor was cut away: it is then `below` [m] under the lowest points.
    """

    T_scanner_region: pin.SE3
    size: Floats
    is_floor_seen: bool
    below: float = 0.0


def find_lying(points: Floats, largest: float) -> Lying | None:
    """Find the floor and the parts on it, None where there are too few points.

    Args:
        points: (n, 3) [m] in the scanner's frame.
        largest: [m] diameter of the largest part that may lie there.
    """
    few, floor = sampled(points, MOST_POINTS), find_floor(points)
    if floor is not None:
        T_scanner_floor, sides = floor
        p_floor = (few - T_scanner_floor.translation) @ T_scanner_floor.rotation
        patch = _Patch.around(p_floor)
        if patch is not None and patch.is_wide(largest):
            return _on(T_scanner_floor, p_floor, patch, largest)
        if patch is not None and _is_between_parts(patch, p_floor):
            top = float(np.percentile(p_floor[:, 2], 100 - OUTLYING))
            return _region(T_scanner_floor, -sides / 2, sides / 2, top)
    return _without_floor(few, largest) if len(few) >= 3 else None


@dataclass(frozen=True, slots=True, eq=False)
class _Patch:
    """The part of a floor that hangs together: a grid over it.

    `low` (2,) [m] is its corner, `step` [m] the width of its pieces; `box` its first and last
    piece along both sides, `area` [m2] that of its pieces.
    """

    low: Floats
    step: float
    shape: tuple[int, int]
    box: tuple[slice, slice]
    area: float

    @staticmethod
    def around(p_floor: Floats) -> "_Patch | None":
        """The largest patch of points (n, 3) [m] on the floor, None where none is on it."""
        low, high = (np.percentile(p_floor[:, :2], q, axis=0) for q in (0.2, 99.8))
        on = p_floor[np.abs(p_floor[:, 2]) < ON_FLOOR]
        area = float(np.prod(np.maximum(high - low, 1e-3)))
        step = max(PIECE, np.sqrt(area * POINTS_A_PIECE / len(p_floor)))
        shape = tuple(int(n) + 1 for n in (high - low) / step)
        patch = _Patch(low, float(step), (shape[0], shape[1]), (slice(0), slice(0)), 0.0)
        grid = patch.count(on) > 0
        labels = _labelled(grid)
        if not labels.any():
            return None
        counts = np.bincount(labels.ravel())[1:]
        first, second = find_objects(labels)[int(np.argmax(counts))]
        area = float(counts.max()) * float(step) ** 2
        return _Patch(low, float(step), patch.shape, (first, second), area)

    @property
    def sides(self) -> Floats:
        """Length and width (2,) [m]."""
        return self.step * np.array([each.stop - each.start for each in self.box], np.float64)

    def is_wide(self, largest: float) -> bool:
        """Whether it is larger than any face of the largest part, of that diameter [m]."""
        width = float(np.linalg.norm(self.sides))
        return width > WIDER * largest and self.area > LARGER * largest**2

    def count(self, p_floor: Floats) -> np.ndarray:
        """How many of the points (n, 3) [m] lie in each piece (rows, columns)."""
        index = np.floor((p_floor[:, :2] - self.low) / self.step).astype(np.int64)
        is_in = ((index >= 0) & (index < self.shape)).all(axis=1)
        at = index[is_in] @ np.array([self.shape[1], 1])
        return np.bincount(at, minlength=self.shape[0] * self.shape[1]).reshape(self.shape)

    def contains(self, p_floor: Floats) -> Bools:
        """Which of the points (n, 3) [m] lie over the patch's rectangle."""
        first = np.array([each.start for each in self.box])
        last = np.array([each.stop for each in self.box])
        at = (p_floor[:, :2] - self.low) / self.step
        inside: Bools = np.asarray(((at >= first) & (at <= last)).all(axis=1))
        return inside


def _is_between_parts(patch: _Patch, p_floor: Floats) -> bool:
    """Whether a narrow patch is a floor that parts cover, by points (n, 3) [m] over it."""
    filled = np.argwhere(patch.count(p_floor) > 0)
    corners = np.concatenate([filled, filled + [0, 1], filled + [1, 0], filled + [1, 1]])
    try:
        outline = ConvexHull(corners).volume
    except QhullError:
        return False
    lower = float(np.mean(p_floor[:, 2] < -1.5 * ON_FLOOR))
    return bool(len(filled) > FILLED * outline and lower < LOWER)


def _on(T_scanner_floor: pin.SE3, p_floor: Floats, patch: _Patch, largest: float) -> Lying:
    """The region of the things on a patch of a floor; of all of the patch where nothing is."""
    height = p_floor[:, 2]
    over = p_floor[(height > ON_FLOOR) & (height < HIGHEST) & patch.contains(p_floor)]
    labels = _labelled(patch.count(over) > 0)
    things = np.zeros(patch.shape, np.bool_)
    for number, box in enumerate(find_objects(labels)):
        sides = [patch.step * (each.stop - each.start) for each in box]
        if max(sides) > LEAST_THING * largest and min(sides) > patch.step:
            things[box] |= labels[box] == number + 1
    if things.any():
        at = np.argwhere(things)
        low = patch.low + patch.step * at.min(axis=0)
        high = patch.low + patch.step * (at.max(axis=0) + 1)
        top = float(np.percentile(over[:, 2], 99.5))
    else:
        low = patch.low + patch.step * np.array([each.start for each in patch.box])
        high = patch.low + patch.step * np.array([each.stop for each in patch.box])
        top = largest
    # The region of a thing that shows itself in part holds the whole of it.
    missing = np.maximum(largest - (high - low), 0.0) / 2
    return _region(T_scanner_floor, low - missing, high + missing, top)


def _without_floor(points: Floats, largest: float) -> Lying | None:
    """The region of points (n, 3) [m] of parts alone; the scanner is taken to look straight down.

    None where they are spread as parts are not.
    """
    deepest = float(np.percentile(points[:, 2], 100 - OUTLYING))
    below = round(largest, 3)
    T_scanner_floor = pin.SE3(np.diag([1.0, -1.0, -1.0]), np.array([0.0, 0.0, deepest + below]))
    p_floor = (points - T_scanner_floor.translation) @ T_scanner_floor.rotation
    low, high = np.percentile(p_floor, (OUTLYING, 100 - OUTLYING), axis=0)
    if high[2] - low[2] > HIGHEST or max(high[:2] - low[:2]) > WIDEST:
        return None
    lying = _region(T_scanner_floor, low[:2], high[:2], float(high[2]))
    return Lying(lying.T_scanner_region, lying.size, False, below)


def _region(T_scanner_floor: pin.SE3, low: Floats, high: Floats, top: float) -> Lying:
    """The region between two corners (2,) [m] on a floor, to whole centimetres."""
    middle = (low + high) / 2
    sides = np.minimum(high - low + 2 * BORDER, WIDEST)
    size = np.ceil(np.array([*sides, max(top, LOWEST_TOP)]) * 100 - 1e-6) / 100
    T_floor_region = pin.SE3(np.eye(3), np.array([*middle, 0.0]))
    return Lying(T_scanner_floor * T_floor_region, size, True)


def _labelled(grid: Bools) -> Ints:
    """The number of its patch for each piece (rows, columns) of a grid, 0 in none."""
    found: Any = label(grid, np.ones((3, 3)))
    return np.asarray(found[0], np.int64)
