"""The bin in a scan of which nobody knows where its scanner hangs.

The surfaces that most points lie on are tried as the floor, or what the bin stands on.  What is as
high over one of them as the bin is may be its rim: the smallest rectangle around it says where.
From there on the rim is fitted as ever (`bin_check.rim_place`).
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, pose_from_rpy
from workbench.model.part import Bin
from workbench.perception.bins.bin_check import BAND, rim_place
from workbench.perception.bins.floor_search import find_floor

MOST_POINTS, PLANES_TRIED, MOST_SURFACES = 20_000, 300, 4
"""Points that are checked, planes tried for each surface, and how many surfaces."""

PLANE_WITHIN = 0.004
"""[m] A point this near to a plane lies on it."""

LEAST_SHARE = 0.02
"""Share of the points that a surface has at least."""

OUTLYING = 0.5
"""[percent] Of the points of a rim may lie further out."""

AREA_TOLERANCE = 0.15
"""Share by which the rectangle may be larger or smaller than the rim."""


BELOW, SEEN_THROUGH = 0.012, 0.1
"""[m] Points that lie deeper below a floor are seen through it; with a larger share of them it is
no floor."""


@dataclass(frozen=True, slots=True)
class FoundBin:
    """`T_scanner_bin` is where the rim is, `rim` (length, width) [m] what it measures outside.

    The pose is None where what is seen is no rim of the cell's bin.
    """

    T_scanner_bin: pin.SE3 | None
    rim: tuple[float, float] | None


def find_bin(points: Floats, bin: Bin) -> FoundBin:
    """Look for a bin anywhere in a scan.

    A bin looks alike after half a turn: of both the caller has to choose.  One without walls has no
    rim to be found.

    Args:
        points: (n, 3) [m] in the scanner's frame.
        bin: its size; not its pose.
    """
    if not bin.has_walls:
        return FoundBin(None, None)
    left = points[:: max(1, len(points) // MOST_POINTS)]
    every, rng = left, np.random.default_rng(0)
    wanted = np.sort(np.asarray(bin.size[:2]) + 2 * bin.wall)[::-1]
    seen: tuple[float, float] | None = None
    for normal, height in _floors(every, rng):
        over = every @ normal - height
        rim = every[np.abs(over - bin.size[2]) < BAND / 2]
        if len(rim) < 3 * MOST_SURFACES:
            continue
        T_scanner_guess, rectangle = rectangle_around(rim, normal, height)
        if not (np.abs(np.array(rectangle) / wanted - 1) < AREA_TOLERANCE).all():
            seen = seen or rectangle
            continue
        if _is_seen_through(every, T_scanner_guess, rectangle):
            continue
        if bin.size[0] < bin.size[1]:
            T_scanner_guess = T_scanner_guess * pose_from_rpy((0, 0, 0), (0, 0, np.pi / 2))
        T_guess = T_scanner_guess.inverse()
        T_guess_bin = rim_place(points @ T_guess.rotation.T + T_guess.translation, bin)
        seen = rectangle
        if T_guess_bin is not None:
            return FoundBin(T_scanner_guess * T_guess_bin, rectangle)
    return FoundBin(None, seen)


def _floors(points: Floats, rng: np.random.Generator) -> Iterator[tuple[Floats, float]]:
    """Planes that may be the floor, or what the bin stands on: normals and offsets [m]."""
    floor = find_floor(points)
    if floor is not None:
        normal = floor[0].rotation[:, 2]
        yield normal, float(normal @ floor[0].translation)
    left = points
    for _ in range(MOST_SURFACES):
        plane = _plane(left, rng)
        if plane is None:
            return
        normal, height, on = plane
        left = left[~on]
        yield normal, height


def _is_seen_through(
    points: Floats, T_scanner_floor: pin.SE3, rectangle: tuple[float, float]
) -> bool:
    """Whether points (n, 3) [m] lie below what would be the floor within a rectangle."""
    local = (points - T_scanner_floor.translation) @ T_scanner_floor.rotation
    inside = (np.abs(local[:, :2]) < np.array(rectangle) / 2).all(axis=1)
    return bool((local[inside, 2] < -BELOW).mean() > SEEN_THROUGH)


def _plane(points: Floats, rng: np.random.Generator) -> tuple[Floats, float, np.ndarray] | None:
    """Normal towards the scanner, offset along it [m], and which points lie on the best plane."""
    if len(points) < 100:
        return None
    best, most = None, LEAST_SHARE * len(points)
    few = points[:: max(1, len(points) // 2000)]
    for _ in range(PLANES_TRIED):
        a, b, c = few[rng.choice(len(few), 3, replace=False)]
        normal = np.cross(b - a, c - a)
        length = float(np.linalg.norm(normal))
        if length < 1e-9:
            continue
        normal = normal / length if normal @ a < 0 else -normal / length
        count = float(np.mean(np.abs((few - a) @ normal) < PLANE_WITHIN)) * len(points)
        if count > most:
            best, most = (normal, float(normal @ a)), count
    if best is None:
        return None
    normal, height = best
    for _ in range(3):
        on = np.abs(points @ normal - height) < PLANE_WITHIN
        middle = points[on].mean(axis=0)
        normal = np.linalg.svd(points[on] - middle, full_matrices=False)[2][2]
        normal = normal if normal @ middle < 0 else -normal
        height = float(normal @ middle)
    return normal, height, np.abs(points @ normal - height) < PLANE_WITHIN


def rectangle_around(
    rim: Floats, normal: Floats, height: float
) -> tuple[pin.SE3, tuple[float, float]]:
    """A frame on a plane, in the middle of the rectangle around a rim, and the sides [m] of that.

    Args:
        rim: (n, 3) [m] its points.
        normal: (3,) of the plane, which is the frame's z axis; x is along the longer side.
        height: [m] of the plane along its normal.
    """
    first = np.linalg.svd(normal[None])[2][1]
    axes = np.stack([first, np.cross(normal, first)])
    flat = rim @ axes.T
    best, least = (0.0, np.zeros(2), np.zeros(2)), np.inf
    for angle in np.deg2rad(np.arange(0.0, 90.0, 1.0)):
        turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
        low, high = np.percentile(flat @ turn.T, (OUTLYING, 100 - OUTLYING), axis=0)
        if float(np.prod(high - low)) < least:
            least, best = float(np.prod(high - low)), (angle, low, high)
    angle, low, high = best
    turn = np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]])
    x, y = turn @ axes
    sides = high - low
    middle = (low + high) / 2 @ turn @ axes + height * normal
    if sides[0] < sides[1]:
        x, y, sides = y, -x, sides[::-1]
    return pin.SE3(np.stack([x, y, normal], axis=1), middle), (float(sides[0]), float(sides[1]))
