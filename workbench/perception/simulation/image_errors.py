"""Errors that neighbouring pixels of a depth image share: blurred, fattened, bent, sheared."""

import numpy as np
from scipy import ndimage

from workbench.model.geometry import Floats

LIGHT_PIXELS = 6
"""[pixels] From how far around light is thrown into concave corners."""


def fattened(depth: Floats, by: int, step: float) -> Floats:
    """Extend near objects over far ones by some pixels, as stereo window matching does.

    A slope stays where it is: half of its window is nearer and half further away.

    Args:
        depth: (rows, columns) [m], infinite where nothing is hit.
        by: the number of pixels.
        step: [m] depth difference that counts as an edge.
    """
    near = ndimage.minimum_filter(depth, 2 * by + 1)
    return np.where(np.isfinite(depth) & (depth > near + step), near, depth)


def lengthened(depth: Floats, share: float) -> Floats:
    """Depths with the light that comes by way of what is around: longer in concave corners.

    Args:
        depth: (rows, columns) [m], infinite where nothing is hit.
        share: of how much deeper a place lies than what surrounds it, that is added.
    """
    held = np.isfinite(depth)
    size = 2 * LIGHT_PIXELS + 1
    count = ndimage.uniform_filter(held.astype(float), size)
    total = ndimage.uniform_filter(np.where(held, depth, 0.0), size)
    around = total / np.maximum(count, 1e-9)
    deeper = np.where(held, depth, 0.0) - around
    return depth + share * np.where(held, np.maximum(deeper, 0.0), 0.0)


def waved(depth: Floats, height: float, length: float) -> Floats:
    """Depths with the wave that fringes leave which are not quite sinusoidal.

    Args:
        depth: (rows, columns) [m].
        height: [m] of the wave, at 1 m.
        length: [m] by which the depth grows from one crest to the next.
    """
    finite = np.where(np.isfinite(depth), depth, 0.0)
    return depth + height * finite**2 * np.sin(2 * np.pi * finite / length)


def smoothed(depth: Floats, spread: float, step: float) -> Floats:
    """Depths averaged over their surroundings, edges that are lower than `step` with them.

    Args:
        depth: (rows, columns) [m], NaN or infinite where nothing is measured; stays so.
        spread: [pixels] standard deviation of the weights.
        step: [m] neighbours that are further off do not count.
    """
    held = np.isfinite(depth)
    finite = np.where(held, depth, np.inf)
    half = int(np.ceil(2 * spread))
    wide = np.pad(finite, half, constant_values=np.inf)
    total, weights = np.zeros(depth.shape), np.zeros(depth.shape)
    rows, columns = depth.shape
    for j in range(2 * half + 1):
        for i in range(2 * half + 1):
            there = wide[j : j + rows, i : i + columns]
            with np.errstate(invalid="ignore"):
                counts = np.abs(there - finite) < step
            weight = np.exp(-((j - half) ** 2 + (i - half) ** 2) / (2 * spread**2))
            total += np.where(counts, weight * there, 0.0)
            weights += weight * counts
    return np.where(held, total / np.maximum(weights, 1e-9), depth)


def sheared(image: Floats, by: float) -> Floats:
    """An image whose scene has moved while it was measured, row after row.

    Args:
        image: (rows, columns), depths [m] or cosines (no unit).
        by: [pixels] along the rows, of the last one; whole ones are moved, what comes in from the
            side is as what was there.
    """
    rows, columns = image.shape
    shift = np.round(by * np.arange(rows) / max(rows - 1, 1)).astype(int)
    source = np.clip(np.arange(columns) - shift[:, None], 0, columns - 1)
    return np.take_along_axis(image, source, axis=1)


def stepped(depth: Floats, step: float) -> Floats:
    """Depths of which only every so large a step of 1/z is reported, as of whole disparities.

    Args:
        depth: (rows, columns) [m], NaN or infinite where nothing is measured.
        step: [m] at 1 m.
    """
    with np.errstate(divide="ignore", invalid="ignore"):
        return np.where(np.isfinite(depth), 1.0 / (np.round(1.0 / depth / step) * step), depth)
