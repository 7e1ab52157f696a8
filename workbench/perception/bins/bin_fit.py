"""The bin as a scan shows it: floor and walls, fitted near where the cell has them.

Scanners are calibrated to some millimetres, and floors of real bins are bent.  What a fixed plane
leaves over of the floor looks like thin parts, so floor and walls are fitted in each scan.  The
floor is a quadratic surface, each wall a plane.  Both are what nothing lies behind: of two levels
that many points share, the one is taken that has none below it.
"""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.geometry import Floats, own, sampled
from workbench.model.part import Bin

SEARCHED_WITHIN, MOST_TILTED = 0.008, float(np.deg2rad(2.0))
"""[m, rad] Floor and walls are searched for this near to where the cell has them."""

SURFACE_WITHIN, SURFACE_DEVIATIONS = 0.002, 4.0
"""[m] A point this near to a surface belongs to it, or this many deviations of the noise."""

BEHIND = 5.0
"""What a point behind a surface counts against one on it: nothing can be seen there, but scanners
make mistakes."""

MOST_SEARCHED, MOST_FITTED = 1000, 20_000
"""Points that the search for a surface, and its fit, look at; of more every second, third, ..."""

OFFSET_STEP, TILT_STEP = 0.001, float(np.deg2rad(0.5))
"""[m, rad] Steps of the search."""

FITS = 8
"""Steps of the fit, each with weights from the one before (Tukey's)."""

AGAINST_TILT, AGAINST_BEND = 0.001, 0.002
"""Share of all points that speaks for a surface as in the cell: against a tilt, and a bend.  What
is seen in a corner only is not continued steeply."""

TILES = 16
"""A surface is divided into this many pieces along each side, each seen or not."""

FEWEST_POINTS = 4
"""Points on a piece with which it is seen."""

SEEN_FLOOR, SEEN_WALL = 0.04, 0.15
"""Shares of its pieces in which floor or wall must be seen to be believed."""

RAISED, MEASURED = 0.004, 0.5
"""[m] A floor that seems higher than in the cell by more is believed where anything is measured in
this share of its pieces: in a cloud cropped to the parts, their flat tops seem to be a floor."""

SEEN_RAISED = 0.25
"""Or where it is seen in this share of them."""

OPEN = 1e3
"""Distance [m] of the walls of a bin that has none."""

CORNER = 0.006
"""[m] Nearer than this to where floor and walls meet, scanners smooth them into each other."""

ROUNDED_TO = 1e-6
"""[m] Results are rounded to this, so that they are the same on any machine."""


@dataclass(frozen=True, slots=True, eq=False)
class SeenBin:
    """Inner surfaces of a bin in a scan, in the frame of the bin as the cell has it.

    `floor` (6,) [m]: its height is (1, u, v, uu, uv, vv) @ floor, where u and v go from -1 to 1
    along the inside's length and width.  `walls` (4, 3) [m]: how far the sides x+, x-, y+, y- lie
    further out than in the cell: (1, along, up) @ wall, where `along` goes from -1 to 1 and `up`
    from 0 to 1.  `noise` [m] is the deviation of the floor's points.  `floor_share` and
    `wall_shares` (4,) tell how much of them is seen; what is seen too little of is as in the cell.
    Walls that the bin has not are `OPEN`, and nothing is missing of them.
    """

    floor: Floats
    walls: Floats
    noise: float
    floor_share: float
    wall_shares: Floats

    def __post_init__(self) -> None:
        own(self, "floor", "walls", "wall_shares")

    @property
    def is_floor_seen(self) -> bool:
        """Whether enough of the floor is seen to say where it is."""
        return self.floor_share >= SEEN_FLOOR


def as_in_cell() -> SeenBin:
    """A bin of which the scan says nothing."""
    return SeenBin(np.zeros(6), np.zeros((4, 3)), 0.0, 0.0, np.zeros(4))


def fit_bin(points: Floats, T_bin_points: pin.SE3, bin: Bin, *, noise: float) -> SeenBin:
    """Fit floor and walls of a bin.

    Args:
        points: (n, 3) [m] of a scan, in any frame.
        T_bin_points: that frame in the bin as the cell has it.
        bin: its size, and the frame in which it is searched for.
        noise: [m] deviation of the points as far as it is known.
    """
    gate = max(SURFACE_WITHIN, SURFACE_DEVIATIONS * noise)
    slack = SEARCHED_WITHIN + np.tan(MOST_TILTED) * float(np.linalg.norm(bin.size)) / 2 + gate
    reach = np.array([*(bin.size[:2] / 2 + slack), bin.size[2]])
    near = _near(points, np.ascontiguousarray(T_bin_points.homogeneous), reach, -slack)
    floor, share, deviation = _floor(near, bin.size, gate, slack)
    if not bin.has_walls:
        return SeenBin(floor, np.tile((OPEN, 0.0, 0.0), (4, 1)), deviation, share, np.ones(4))
    walls, shares = np.zeros((4, 3)), np.zeros(4)
    for side in range(4):
        walls[side], shares[side] = _wall(near, bin.size, floor, side, gate, slack)
    return SeenBin(floor, walls, deviation, share, shares)


def above_floor(seen: SeenBin, size: Floats, p_bin: Floats) -> Floats:
    """Height (n,) [m] over the floor of points (n, 3) [m] in the frame of the cell's bin."""
    u, v = (2 * p_bin[:, :2] / size[:2]).T
    return p_bin[:, 2] - _quadratic(u, v) @ seen.floor


@njit(cache=True)
def inside_by(
    floor: Floats, walls: Floats, size: Floats, x: float, y: float, z: float
) -> tuple[float, float]:  # pragma: no cover (compiled)
    """Height of a point over the floor, and way to the nearest wall, negative outside [m].

    `floor` (6,) and `walls` (4, 3) are those of `SeenBin`.
    """
    u, v, up = 2.0 * x / size[0], 2.0 * y / size[1], z / size[2]
    height = z - (
        floor[0] + u * (floor[1] + floor[3] * u + floor[4] * v) + v * (floor[2] + floor[5] * v)
    )
    half = size[0] / 2.0
    left = half - x + walls[0, 0] + walls[0, 1] * v + walls[0, 2] * up
    left = min(left, half + x + walls[1, 0] + walls[1, 1] * v + walls[1, 2] * up)
    half = size[1] / 2.0
    left = min(left, half - y + walls[2, 0] + walls[2, 1] * u + walls[2, 2] * up)
    left = min(left, half + y + walls[3, 0] + walls[3, 1] * u + walls[3, 2] * up)
    return height, left


def _floor(near: Floats, size: Floats, gate: float, slack: float) -> tuple[Floats, float, float]:
    """Coefficients (6,), share seen, and deviation [m] of what is on it."""
    inner = size[:2] / 2 - CORNER
    x, y, z = np.abs(near).T
    points = sampled(near[(x < inner[0]) & (y < inner[1]) & (z < slack)], MOST_FITTED)
    u, v = (2 * points[:, :2] / size[:2]).T
    rows = _quadratic(u, v)
    tilts = np.tan(MOST_TILTED) * size[:2] / 2
    found = _fit(rows, points[:, 2], tilts, gate, 3)
    if found is None:
        return np.zeros(6), 0.0, 0.0
    off = points[:, 2] - rows @ found
    on = np.abs(off) < gate
    share = _share(u, v, on)
    if share < SEEN_FLOOR or (
        found[0] > RAISED and share < SEEN_RAISED and _share_measured(near, size) < MEASURED
    ):
        return np.zeros(6), 0.0, 0.0
    return _round(found), share, float(1.4826 * np.median(np.abs(off[on])))


def _wall(
    near: Floats, size: Floats, floor: Floats, side: int, gate: float, slack: float
) -> tuple[Floats, float]:
    """Coefficients (3,) of one side, and share seen."""
    across, sign = side // 2, 1.0 - 2.0 * (side % 2)
    near = near[np.abs(sign * near[:, across] - size[across] / 2) < slack]
    out = sign * near[:, across] - size[across] / 2
    along = 2 * near[:, 1 - across] / size[1 - across]
    u, v = (2 * near[:, :2] / size[:2]).T
    height = near[:, 2] - _quadratic(u, v) @ floor
    there = (
        (np.abs(along) < 1 - 2 * CORNER / size[1 - across])
        & (height > CORNER)
        & (height < size[2] - CORNER)
    )
    values = sampled(np.column_stack([out, along, height / size[2]])[there], MOST_FITTED)
    rows = np.column_stack([np.ones(len(values)), values[:, 1], values[:, 2]])
    tilts = np.tan(MOST_TILTED) * np.array([size[1 - across] / 2, size[2]])
    # What lies outside of a wall is behind it: the same as below the floor, upside down.
    found = _fit(rows, -values[:, 0], tilts, gate, 3)
    if found is None:
        return np.zeros(3), 0.0
    on = np.abs(-values[:, 0] - rows @ found) < gate
    share = _share(values[:, 1], 2 * values[:, 2] - 1, on)
    return (_round(-found), share) if share >= SEEN_WALL else (np.zeros(3), share)


def _quadratic(u: Floats, v: Floats) -> Floats:
    return np.stack([np.ones_like(u), u, v, u * u, u * v, v * v], axis=-1)


def _round(values: Floats) -> Floats:
    return np.round(values / ROUNDED_TO) * ROUNDED_TO + 0.0


def _share(u: Floats, v: Floats, on: np.ndarray) -> float:
    """The share of tiles over -1..1 in which most of what is seen is `on` the surface."""
    index = [np.clip(((x + 1) / 2 * TILES).astype(int), 0, TILES - 1) for x in (u, v)]
    tile = index[0] * TILES + index[1]
    total = np.bincount(tile, minlength=TILES**2)
    there = np.bincount(tile[on], minlength=TILES**2)
    return float(np.mean((there >= FEWEST_POINTS) & (2 * there >= total)))


def _share_measured(near: Floats, size: Floats) -> float:
    """The share of the floor's tiles over which anything is measured."""
    u, v = (2 * near[:, :2] / size[:2]).T
    is_inside = (np.abs(u) < 1.0) & (np.abs(v) < 1.0)
    u, v = u[is_inside], v[is_inside]
    return _share(u, v, np.ones(len(u), np.bool_))


def _fit(rows: Floats, values: Floats, tilts: Floats, gate: float, linear: int) -> Floats | None:
    """Coefficients with which rows (n, m) give most of the values (n,) [m], and few lower ones.

    The first `linear` columns are searched for (offset and two tilts), then all are fitted.
    """
    if len(values) < 10 * linear:
        return None
    values = np.ascontiguousarray(values)
    step = max(1, -(-len(values) // MOST_SEARCHED))
    offsets = np.arange(-SEARCHED_WITHIN, SEARCHED_WITHIN + 1e-9, OFFSET_STEP)
    count = round(MOST_TILTED / TILT_STEP)
    steps = np.arange(-count, count + 1) / count
    best = _search(
        np.ascontiguousarray(rows[::step, :linear]), values[::step].copy(), offsets,
        steps * tilts[0], steps * tilts[1], gate,
    )  # fmt: skip
    found = np.zeros(rows.shape[1])
    found[:linear] = best
    hold = (
        np.array([0.0, AGAINST_TILT, AGAINST_TILT, AGAINST_BEND, AGAINST_BEND, AGAINST_BEND])
        * len(values)
        + 1e-9
    )
    for number in range(FITS):
        k = linear if number < 2 else rows.shape[1]
        sums, pulls = _weigh(rows, values, found, k, gate)
        found[:k] = np.linalg.solve(sums + np.diag(hold[:k]), pulls)
    return found


@njit(cache=True)
def _near(
    points: Floats, T: Floats, reach: Floats, lowest: float
) -> Floats:  # pragma: no cover (compiled)
    """The points in a box around the inside of the bin, in its frame."""
    near = np.empty((len(points), 3))
    n = 0
    for k in range(len(points)):
        a, b, c = points[k, 0], points[k, 1], points[k, 2]
        x = T[0, 0] * a + T[0, 1] * b + T[0, 2] * c + T[0, 3]
        y = T[1, 0] * a + T[1, 1] * b + T[1, 2] * c + T[1, 3]
        z = T[2, 0] * a + T[2, 1] * b + T[2, 2] * c + T[2, 3]
        if abs(x) < reach[0] and abs(y) < reach[1] and lowest < z < reach[2]:
            near[n, 0], near[n, 1], near[n, 2] = x, y, z
            n += 1
    return near[:n]


@njit(cache=True)
def _weigh(
    rows: Floats, values: Floats, found: Floats, k: int, gate: float
) -> tuple[Floats, Floats]:  # pragma: no cover (compiled)
    """Normal equations of the first `k` coefficients; points count less the further they are off.

    Nothing lies behind a surface, so what seems to is believed from twice as far away.
    """
    sums, pulls = np.zeros((k, k)), np.zeros(k)
    for n in range(len(values)):
        off = values[n]
        for i in range(len(found)):
            off -= rows[n, i] * found[i]
        share = off / gate if off > 0 else 0.5 * off / gate
        if abs(share) >= 1.0:
            continue
        weight = (1.0 - share * share) ** 2
        for i in range(k):
            pulls[i] += weight * rows[n, i] * values[n]
            for j in range(k):
                sums[i, j] += weight * rows[n, i] * rows[n, j]
    return sums, pulls


@njit(cache=True)
def _search(
    rows: Floats,
    values: Floats,
    offsets: Floats,
    first: Floats,
    second: Floats,
    gate: float,
) -> Floats:  # pragma: no cover (compiled)
    """Offset and two tilts (3,) [m] of the plane on which most values lie, and few below."""
    best, found = -np.inf, np.zeros(3)
    for b in first:
        for c in second:
            for a in offsets:
                total = 0.0
                for k in range(len(values)):
                    off = values[k] - a - b * rows[k, 1] - c * rows[k, 2]
                    if off < -gate:
                        total -= BEHIND
                    elif off < gate:
                        total += 1.0 - (off / gate) ** 2
                # Of equal ones the nearest to the cell's.
                total -= 1e-3 * (abs(a) + abs(b) + abs(c)) / gate
                if total > best:
                    best = total
                    found[0], found[1], found[2] = a, b, c
    return found
