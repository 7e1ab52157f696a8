"""How good the points of a scan are, by the scan itself: its noise where surfaces are smooth.

A smooth surface is locally a quadratic one.  In windows all over the image such surfaces are fitted
to the depths; what is left is noise.  Over edges more is left, so the windows in which least is
left stand for all.  Narrow windows tell how neighbouring points differ; wide ones also what cameras
smooth and quantise: errors that neighbours share, and that a part would be off by.

The deviation grows with the square of the depth and with the angle at which a surface is met, as
that of triangulating scanners does; a window states what it would be at 1 m, met head-on.
"""

from dataclasses import dataclass

import numpy as np
from numba import njit

from workbench.model.geometry import Floats
from workbench.perception.views.camera import are_within, picture_bounds, picture_of

NARROW_WINDOWS, WIDE_WINDOWS = (40, 160), (16, 1000)
"""Windows along the longer side of the image, and about how many points are taken in each."""

MOST_POINTS = 100_000
"""Points that are checked; of more every second, third, ..."""

FEWEST_POINTS = 16
"""Points that a window needs."""

FEWEST_WINDOWS = 12
"""With fewer the scan shows nothing of its noise."""

SMOOTH = 0.25
"""This share of the windows, with the least noise, is taken for smooth: its highest counts."""

TIMES = 2.0
"""Wide windows with more than this over the narrow ones' noise show shapes: none is smooth."""

STRAY = 8.0
"""Points that are more deviations off are mistakes, and no noise."""

STEEP = 0.3
"""Cosine below which a surface is met too flatly to tell."""

COARSEST = 0.01
"""[m] Noise at 1 m is never taken for more: it is no scan of surfaces, then."""


@dataclass(frozen=True, slots=True)
class SensorModel:
    """`noise` [m] is the deviation of depths at 1 m, met head-on; None when nothing shows it."""

    noise: float | None

    def deviation(self, depth: float, *, otherwise: float) -> float:
        """Deviation [m] at a depth [m]; by the noise `otherwise` at 1 m where none is known."""
        return (otherwise if self.noise is None else self.noise) * depth**2


def sensor_model(points: Floats) -> SensorModel:
    """Estimate a scanner's noise from one of its scans.

    Args:
        points: (n, 3) [m] in the scanner's frame, organised or not; those before it count.
    """
    before = points[:: max(1, len(points) // MOST_POINTS)]
    before = before[before[:, 2] > 0]
    if len(before) < FEWEST_WINDOWS * FEWEST_POINTS:
        return SensorModel(None)
    image = picture_of(before)
    low, high = picture_bounds(image)
    shown = before[are_within(image, low, high)]
    side = float((high - low).max())
    narrow = _noise(shown, low, side, NARROW_WINDOWS, stray=np.inf)
    if narrow is None:
        return SensorModel(None)
    wide = _noise(shown, low, side, WIDE_WINDOWS, stray=STRAY * narrow)
    noise = narrow if wide is None or wide > TIMES * narrow else max(wide, narrow)
    # Rounded, so that it is the same on any machine.
    return SensorModel(min(round(noise, 6), COARSEST))


def _noise(
    points: Floats, low: Floats, side: float, windows: tuple[int, int], *, stray: float
) -> float | None:
    """Noise [m] at 1 m by windows of one size, None where too few are smooth.

    `low` (2,) and `side` are corner and width of the picture that holds the points (n, 3) [m].
    """
    count, wanted = windows
    step = side / count
    if not step > 0:
        return None
    fits = np.zeros((count + 1, count + 1, 7))
    sums = _fit(points, low, step, wanted, np.inf, fits)
    if np.isfinite(stray):
        sums = _fit(points, low, step, wanted, stray, fits)
        sums = _fit(points, low, step, wanted, stray, fits)
    deviations = _deviations(fits, sums, low, step)
    known = np.sort(deviations[np.isfinite(deviations)])
    return float(known[int(SMOOTH * (len(known) - 1))]) if len(known) >= FEWEST_WINDOWS else None


@njit(cache=True)
def _fit(
    points: Floats, low: Floats, step: float, wanted: int, stray: float, fits: Floats
) -> Floats:  # pragma: no cover (compiled)
    """Fit 1/z in each window, to points no more than `stray` [m] at 1 m off the fits before.

    Writes `fits` (rows, columns, 7): six coefficients over the window, and half its size in steps.

    Returns:
        (rows, columns, 2): how many points, and the sum of squares that is left over.
    """
    rows, columns = fits.shape[:2]
    places, halves = np.empty((len(points), 2)), np.zeros((rows, columns))
    _divide(points, low, step, wanted, places, halves)
    normal, pulls = np.zeros((rows, columns, 6, 6)), np.zeros((rows, columns, 6))
    left = np.zeros((rows, columns, 2))
    middle = np.zeros((rows, columns))
    row = np.empty(6)
    for n in range(len(points)):
        a, b = places[n, 0], places[n, 1]
        i, j = int(a), int(b)
        half = halves[j, i]
        x, y = (a - i - 0.5) / half, (b - j - 0.5) / half
        if abs(x) > 1.0 or abs(y) > 1.0:
            continue
        nearness = 1.0 / points[n, 2]
        row[0], row[1], row[2], row[3], row[4], row[5] = 1.0, x, y, x * x, x * y, y * y
        if stray < np.inf:
            off = nearness
            for k in range(6):
                off -= fits[j, i, k] * row[k]
            if abs(off) > stray:
                continue
        if left[j, i, 0] == 0.0:
            middle[j, i] = nearness
        value = nearness - middle[j, i]  # small numbers: squares of them are subtracted
        for k in range(6):
            pulls[j, i, k] += row[k] * value
            for m in range(k + 1):
                normal[j, i, k, m] += row[k] * row[m]
        left[j, i, 0] += 1.0
        left[j, i, 1] += value * value
    for j in range(rows):
        for i in range(columns):
            count = left[j, i, 0]
            if count < FEWEST_POINTS:
                left[j, i, 0] = 0.0
                continue
            for k in range(6):
                normal[j, i, k, k] += 1e-9 * count
                for m in range(k):
                    normal[j, i, m, k] = normal[j, i, k, m]
            found = np.linalg.solve(normal[j, i], pulls[j, i])
            for k in range(6):
                fits[j, i, k] = found[k]
                left[j, i, 1] -= found[k] * pulls[j, i, k]
            fits[j, i, 0] += middle[j, i]
            fits[j, i, 6] = halves[j, i]
    return left


@njit(cache=True)
def _divide(
    points: Floats, low: Floats, step: float, wanted: int, places: Floats, halves: Floats
) -> None:  # pragma: no cover (compiled)
    """Write where the points lie, and half the size of each window (rows, columns), in steps."""
    held = np.zeros(halves.shape)
    for n in range(len(points)):
        for k in range(2):
            places[n, k] = (points[n, k] / points[n, 2] - low[k]) / step
        held[int(places[n, 1]), int(places[n, 0])] += 1.0
    for j in range(halves.shape[0]):
        for i in range(halves.shape[1]):
            if held[j, i] > 0.0:
                halves[j, i] = 0.5 * min(1.0, np.sqrt(wanted / held[j, i]))


@njit(cache=True)
def _deviations(
    fits: Floats, left: Floats, low: Floats, step: float
) -> Floats:  # pragma: no cover (compiled)
    """Deviation [m] at 1 m, met head-on, in each window (n,); NaN where it is not known."""
    rows, columns = fits.shape[:2]
    deviations = np.full(rows * columns, np.nan)
    for j in range(rows):
        for i in range(columns):
            n, deep = left[j, i, 0], fits[j, i, 0]
            if n == 0.0 or deep <= 0.0:
                continue
            half = fits[j, i, 6] * step
            u, v = low[0] + (i + 0.5) * step, low[1] + (j + 0.5) * step
            # Over the image of a plane 1/z is linear, and its slopes are the normal.
            nx, ny = fits[j, i, 1] / half, fits[j, i, 2] / half
            nz = deep - nx * u - ny * v
            length = np.sqrt((nx * nx + ny * ny + nz * nz) * (u * u + v * v + 1.0))
            cosine = deep / length
            if cosine >= STEEP:
                # A change of z is z squared times that of 1/z: over the square of the depth, that.
                deviations[j * columns + i] = cosine * np.sqrt(max(left[j, i, 1], 0.0) / (n - 6.0))
    return deviations
