"""What a pose predicts the scanner to see, pixel by pixel, held against what it saw."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numba import njit, uint64

from workbench.model.geometry import Bools, Floats, Ints, frozen, own, put
from workbench.perception.matching.maps import DepthMap, Seen
from workbench.perception.matching.registration import transformed
from workbench.perception.parts.part_surface import PartSurface
from workbench.perception.views.motions import Triple, dot
from workbench.perception.views.rendering import rendered


class Drawing(NamedTuple):
    """What compiled code takes to hold poses of a part against a scan.

    `vertices` (n, 3) [m] and `triangles` (m, 3) are those of the part, which `is_closed` or not;
    `tolerance` [m] is how far from the predicted surface a measured point may lie.
    """

    seen: Seen
    vertices: Floats
    triangles: Ints
    is_closed: bool
    tolerance: float


AGREEING = 0.5
"""Cosine between predicted and measured normal above which a pixel is explained."""

AGAINST = 2.0
"""What a pixel where the scan looks through the part counts against one that it explains."""

EXPLAINED, VIOLATED, HIDDEN = 1, 2, 3
"""What a pixel says of a pose; see `Sighting`."""

ROUGHLY = 0.025
"""From this tolerance on, over the diameter, the part's rough surface is drawn."""

SQUARES = 0
"""Column of a tally that sums the squares of the distances of explained points; the others count
the pixels of each state."""


X, Y, Z = uint64(0), uint64(1), uint64(2)
"""Indices without a sign: of others compiled code asks whether they count from the end."""


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """The pixels (flat indices) in which a pose shows the part, classified by the measured depth.

    Attributes:
        explained: pixels measured on the predicted surface (n,).
        off: their distance from the surface along its normal (n,) [m].
        violated: pixels measured behind the surface (m,), so that the part cannot be there.
        is_rim: whether they are so near the image edge that they may see past the part (m,).
        hidden: pixels measured in front of the surface, on it with another normal, or not (k,).
        ahead: their distance in front of the surface along its normal (k,) [m]; NaN: unmeasured.
    """

    explained: np.ndarray
    off: Floats
    violated: np.ndarray
    is_rim: Bools
    hidden: np.ndarray
    ahead: Floats

    def __post_init__(self) -> None:
        own(self, "off", "ahead")
        put(
            self,
            explained=frozen(self.explained, np.int64),
            violated=frozen(self.violated, np.int64),
            is_rim=frozen(self.is_rim, np.bool_),
            hidden=frozen(self.hidden, np.int64),
        )

    @property
    def shown(self) -> int:
        """Pixels in which the pose shows the part, if nothing were in the way."""
        return len(self.explained) + len(self.violated) + len(self.hidden)

    @property
    def visible(self) -> float:
        """Share of the surface facing the scanner that was seen, 0..1."""
        return len(self.explained) / max(self.shown, 1)

    @property
    def gain(self) -> float:
        """Pixels that speak for the pose less those that speak against it."""
        return len(self.explained) - AGAINST * len(self.violated)

    @property
    def score(self) -> float:
        """The gain over all pixels that the pose shows, 0..1."""
        return max(self.gain, 0.0) / max(self.shown, 1)


def look(depth_map: DepthMap, surface: PartSurface, pose: Floats, tolerance: float) -> Sighting:
    """Render the part at `pose` (4, 4) in the scanner's frame, and compare pixel by pixel.

    Args:
        depth_map: the scan.
        surface: the part.
        pose: where it is thought to be.
        tolerance: [m] how far from the predicted surface a measured point may lie.
    """
    pixels, states, off, is_rim = _look(
        drawing(depth_map, surface, tolerance), np.array(pose, order="C"), depth_map.mixed
    )
    explained, violated, hidden = (states == k for k in (EXPLAINED, VIOLATED, HIDDEN))
    return Sighting(
        pixels[explained],
        off[explained],
        pixels[violated],
        is_rim[violated],
        pixels[hidden],
        off[hidden],
    )


def tally(depth_map: DepthMap, surface: PartSurface, poses: Floats, tolerance: float) -> Floats:
    """The same for many poses (k, 4, 4) [m], counted only: (k, 4).

    Columns are `EXPLAINED`, `VIOLATED`, `HIDDEN` [px], and `SQUARES`, the sum of the squares
    of the distances of the explained points over the tolerance.
    """
    return _tally(drawing(depth_map, surface, tolerance), np.array(poses, order="C"))


def pull(
    depth_map: DepthMap, surface: PartSurface, pose: Floats, tolerance: float
) -> tuple[Floats, Floats]:
    """How the explained points pull at the part: A x = b of a point-to-plane fit.

    The unknowns x (6,) [m] are turns about the part's middle times its radius, and shifts.
    Points count less the further they are off (Tukey's biweight).

    Returns:
        A (6, 6) and b (6,) [m].
    """
    centre = transformed(pose, surface.middle)
    it = drawing(depth_map, surface, tolerance)
    return pulled(it, np.array(pose, order="C"), centre, surface.diameter / 2)


def gains(tallies: Floats) -> Floats:
    """`Sighting.gain` (k,) [px] of each tally (k, 4)."""
    return tallies[:, EXPLAINED] - AGAINST * tallies[:, VIOLATED]


def closeness(tallies: Floats) -> Floats:
    """The gains (k,) [px], with explained pixels counting less the further they are off."""
    return gains(tallies) - tallies[:, SQUARES]


def drawing(depth_map: DepthMap, surface: PartSurface, tolerance: float) -> Drawing:
    """A part to be held against a scan."""
    if tolerance >= ROUGHLY * surface.diameter:
        vertices, triangles = surface.rough_vertices, surface.rough_triangles
    else:
        vertices, triangles = surface.vertices, surface.triangles
    return Drawing(depth_map.seen, vertices, triangles, surface.is_closed, tolerance)


@njit(cache=True)
def predicted(
    drawing: Drawing, T: Floats
) -> tuple[int, int, Floats, Ints, Floats]:  # pragma: no cover (compiled)
    """What the scanner would see of the part at `T` (4, 4), depths (h, w) [m]; see `rendered`."""
    seen = drawing.seen
    return rendered(
        T, drawing.vertices, drawing.triangles, drawing.is_closed,
        seen.rays, seen.focal, seen.column, seen.row,
    )  # fmt: skip


@njit(cache=True)
def _look(
    drawing: Drawing, T: Floats, mixed: int
) -> tuple[Ints, Ints, Floats, Bools]:  # pragma: no cover (compiled)
    """Pixels (n,) that show the part, what each says, how far off it is [m], and which are rim."""
    rays, depths, measured, foreground = drawing.seen[:4]
    first_v, first_u, shown, hit, normals = predicted(drawing, T)
    high, wide = shown.shape
    pixels = np.empty(high * wide, np.int64)
    states = np.empty(high * wide, np.int8)
    off = np.empty(high * wide)
    is_rim = np.empty(high * wide, np.bool_)
    n = 0
    for j in range(high):
        for i in range(wide):
            if shown[j, i] < np.inf:
                v, u, k = first_v + j, first_u + i, hit[j, i]
                pixels[n] = v * depths.shape[1] + u
                states[n], off[n] = _says(
                    depths[v, u],
                    shown[j, i],
                    (rays[v, u, 0], rays[v, u, 1], rays[v, u, 2]),
                    (normals[k, 0], normals[k, 1], normals[k, 2]),
                    (measured[v, u, 0], measured[v, u, 1], measured[v, u, 2]),
                    foreground[v, u],
                    drawing.tolerance,
                )
                is_rim[n] = states[n] == VIOLATED and _is_rim(shown, j, i, mixed)
                n += 1
    return pixels[:n], states[:n], off[:n], is_rim[:n]


@njit(cache=True)
def _is_rim(shown: Floats, j: int, i: int, width: int) -> bool:  # pragma: no cover (compiled)
    """Whether the picture (h, w) [m] ends within that many pixels."""
    for b in range(j - width, j + width + 1):
        for a in range(i - width, i + width + 1):
            is_in = 0 <= b < shown.shape[0] and 0 <= a < shown.shape[1]
            if not is_in or shown[b, a] == np.inf:
                return True
    return False


@njit(cache=True)
def _tally(drawing: Drawing, poses: Floats) -> Floats:  # pragma: no cover (compiled)
    tallies = np.empty((len(poses), 4))
    for k in range(len(poses)):
        tally = counted(drawing, poses[k])
        for i in range(4):
            tallies[k, i] = tally[i]
    return tallies


@njit(cache=True)
def counted(drawing: Drawing, T: Floats) -> Floats:  # pragma: no cover (compiled)
    """The tally (4,) of one pose (4, 4): how many pixels say what, no unit."""
    tally, tolerance = np.zeros(4), drawing.tolerance
    rays, depths, measured, foreground = drawing.seen[:4]
    first_v, first_u, shown, hit, normals = predicted(drawing, T)
    explained, violated, hidden, squares = 0, 0, 0, 0.0
    for j in range(uint64(shown.shape[0])):
        for i in range(uint64(shown.shape[1])):
            if shown[j, i] == np.inf:
                continue
            v, u, k = uint64(first_v) + j, uint64(first_u) + i, uint64(hit[j, i])
            state, off = _says(
                depths[v, u],
                shown[j, i],
                (rays[v, u, X], rays[v, u, Y], rays[v, u, Z]),
                (normals[k, X], normals[k, Y], normals[k, Z]),
                (measured[v, u, X], measured[v, u, Y], measured[v, u, Z]),
                foreground[v, u],
                tolerance,
            )
            if state == EXPLAINED:
                explained += 1
                squares += (off / tolerance) ** 2
            elif state == VIOLATED:
                violated += 1
            else:
                hidden += 1
    tally[EXPLAINED], tally[VIOLATED], tally[HIDDEN] = explained, violated, hidden
    tally[SQUARES] = squares
    return tally


@njit(cache=True)
def pulled(
    drawing: Drawing, T: Floats, centre: Triple, radius: float
) -> tuple[Floats, Floats]:  # pragma: no cover (compiled)
    """See `pull`; `centre` (3,) [m] is the part's middle, `radius` [m] its radius."""
    rays, depths, measured, foreground = drawing.seen[:4]
    A, b, x = np.zeros((6, 6)), np.zeros(6), np.empty(6)
    first_v, first_u, shown, hit, normals = predicted(drawing, T)
    for j in range(uint64(shown.shape[0])):
        for i in range(uint64(shown.shape[1])):
            if shown[j, i] == np.inf:
                continue
            v, u, triangle = uint64(first_v) + j, uint64(first_u) + i, uint64(hit[j, i])
            n0, n1, n2 = n = normals[triangle, X], normals[triangle, Y], normals[triangle, Z]
            ray = rays[v, u, X], rays[v, u, Y], rays[v, u, Z]
            state, off = _says(
                depths[v, u],
                shown[j, i],
                ray,
                n,
                (measured[v, u, X], measured[v, u, Y], measured[v, u, Z]),
                foreground[v, u],
                drawing.tolerance,
            )
            if state != EXPLAINED:
                continue
            a0 = ray[0] * depths[v, u] - centre[0]
            a1 = ray[1] * depths[v, u] - centre[1]
            a2 = depths[v, u] - centre[2]
            x[0], x[1] = (a1 * n2 - a2 * n1) / radius, (a2 * n0 - a0 * n2) / radius
            x[2], x[3], x[4], x[5] = (a0 * n1 - a1 * n0) / radius, n0, n1, n2
            weight = (1.0 - (off / drawing.tolerance) ** 2) ** 2
            for k in range(6):
                b[k] += weight * x[k] * off
                for m in range(k + 1):
                    A[k, m] += weight * x[k] * x[m]
    for k in range(6):
        for m in range(k):
            A[m, k] = A[k, m]
    return A, b


@njit(cache=True)
def _says(
    depth: float,
    predicted: float,
    ray: Triple,
    n: Triple,
    measured: Triple,
    is_foreground: bool,
    tolerance: float,
) -> tuple[int, float]:  # pragma: no cover (compiled)
    """What a pixel says, and how far off the surface its measurement is [m], NaN if none.

    `n` is the normal that a pose predicts there, which faces the scanner.  All are numbers: to
    pass arrays on for each pixel takes three times as long as to compare them.
    """
    if depth == 0.0:
        return HIDDEN, np.nan
    # Along the normal; negative is behind the surface.
    off = dot(n, ray) * (depth - predicted)
    if off < -tolerance:
        return VIOLATED, off
    if off <= tolerance and is_foreground and dot(n, measured) > AGREEING:
        return EXPLAINED, off
    return HIDDEN, off if is_foreground else np.nan
