"""Colours under a light that nobody knows: how far those seen are from those that a part has.

A light and the white balance of a camera multiply red and blue against green, for a whole picture
(von Kries).  Exposure multiplies all three, and so does shading, for each point: ratios of channels
are compared as the paint would have them as bright as it is seen, and the brightness loosely.
"""

from itertools import product
from typing import Any

import numpy as np
from scipy.spatial import KDTree

from workbench.model.geometry import Bools, Floats
from workbench.perception.views.srgb import linear

DARK_OFFSET = 0.02
"""Added to each channel, whose brightest is 1: the ratios of what is black mean nothing."""

SPREAD = (0.1, 0.1, 0.5)
"""How far red over green, blue over green, and brightness of one paint in one picture lie apart
though nothing is wrong, as logarithms: gloss and neighbours, and for brightness the shading."""

TINTS: Floats = np.array(list(product(np.linspace(-0.3, 0.3, 5), repeat=2)))
"""Logarithms (t, 2) by which a light may change red and blue over green."""

EXPOSURES: Floats = np.linspace(-1.5, 1.5, 13)
"""And (e,) the brightness.  A light is a tint with an exposure."""

MOST_DIFFERENT = 16.0
"""A squared distance that is larger counts as this: two colours are not more different than that,
and a point of something else says little."""

UNLIKE = 6.0
"""Squared distance, in deviations, from which two colours are different."""


def features(shares: Floats) -> Floats:
    """Logarithms (..., 3), no unit, of red and blue over green and of brightness of light."""
    red, green, blue = np.moveaxis(shares + DARK_OFFSET, -1, 0)
    return np.log(np.stack([red / green, blue / green, (red + green + blue) / 3.0], axis=-1))


def spread(points: Floats, colours: np.ndarray) -> Floats:
    """Deviation (3,) of a point's features by which a scan is to be judged.

    Neighbours nearly always have the same paint: by how much they differ is the noise of the scan.

    Args:
        points: (n, 3) [m], n > 1.
        colours: (n, 3) in sRGB, 0 to 255.
    """
    seen = features(linear(colours))
    nearest: Any = KDTree(points).query(points, k=2)[1]
    apart = np.median(np.abs(seen - seen[nearest[:, 1]]), axis=0)
    # The median of such differences is 0.954 deviations of the noise, were it normal.
    return np.sqrt(np.square(SPREAD) + np.square(apart / 0.954))


def are_unlike(first: Floats, second: Floats, deviation: Floats) -> Bools:
    """Which paints (n, 3), shares of light 0..1, have different colours, by deviations (3,)."""
    off = (features(first) - features(second)) / deviation
    return np.asarray(np.sum(off**2, axis=1) >= UNLIKE)


def distances(seen: Floats, paints: Floats, deviation: Floats) -> Floats:
    """Squared distances (n, p, t * e) of light that is seen from paints under each light.

    Args:
        seen: (n, 3) shares of light, 0..1.
        paints: (p, 3) shares of white light that they send back.
        deviation: (3,) of features, the unit of the distances, which are `MOST_DIFFERENT` at most.
    """
    tints = np.exp(np.stack([TINTS[:, 0], np.zeros(len(TINTS)), TINTS[:, 1]], axis=1))
    tinted = paints[:, None] * tints
    bright, expected = seen.mean(axis=1), tinted.mean(axis=2)
    scale = bright[:, None, None] / np.maximum(expected, DARK_OFFSET / 10.0)
    ratios = features(tinted * scale[..., None])[..., :2]
    off = (features(seen)[:, None, None, :2] - ratios) / deviation[:2]
    brighter = features(seen)[:, None, None, 2] - features(tinted)[..., 2]
    lighter = (brighter[..., None] - EXPOSURES) / deviation[2]
    squares = np.sum(off**2, axis=-1)[..., None] + lighter**2
    return np.minimum(squares, MOST_DIFFERENT).reshape(len(seen), len(paints), -1)
