"""How much likelier what is seen is if the part stands there than if something unknown does.

Each pixel of the part's picture speaks for one of both.  A part is met as exactly as the scanner
measures; something unknown to which the part was fitted, only within the tolerance.  The scan
looks through a part's middle hardly ever, and through its rim as scanners measure edges; what lies
closely in front of it is another part that was found, or no part stands there.
"""

import numpy as np

from workbench.model.geometry import Bools
from workbench.perception.matching.sightings import Sighting

SPREAD_OVER_NOISE, LEAST_SPREAD = 1.5, 0.2
"""Deviation of a part's points from its surface: over the noise that the scan shows, and over the
tolerance at least, since no part is as its drawing and no scanner without bias."""

STRAY = 0.1
"""Share of a part's points that lie anywhere within the tolerance."""

MOST_FOR_PART = 0.5
"""[nat] A pixel on the part speaks for it by no more than this in the mean: neighbours share their
errors, and what was fitted to a face lies on all of it."""

THROUGH, THROUGH_RIM = 6.0, 1.5
"""[nat] By which a pixel speaks against it where the scan looks through its middle or its rim."""

CLOSE_AHEAD, AHEAD, ODD = 2.0, 0.5, 1.0
"""[nat] And where something that is not known lies closely in front, or further so, or where what
is measured on the part faces elsewhere."""

CLOSE_IN_FRONT = 4.0
"""Tolerances up to which what lies in front is close: it goes on where the part would end."""


def log_likelihood_ratio(
    sighting: Sighting,
    is_other: Bools,
    spread: float,
    tolerance: float,
    *,
    is_all_known: bool,
    most: float = MOST_FOR_PART,
) -> float:
    """Log likelihood ratio [nat] of a pixel: of this part against something unknown.

    That is the mean over the pixels that this part alone explains, at most `most`, minus the summed
    penalties divided by their number.

    Args:
        sighting: what the pixels of the part's picture say.
        is_other: (pixels,) which of all pixels other parts explain.
        spread: [m] deviation of a part's points from its surface.
        tolerance: [m] see `sightings.look`.
        is_all_known: whether `is_other` is of all parts; if not, what lies in front says nothing.
        most: [nat] by which a pixel on the part may speak for it in the mean.
    """
    off = sighting.off[~is_other[sighting.explained]]
    if len(off) == 0:
        return -np.inf
    exact = np.exp(-((off / spread) ** 2) / 2) * 2 * tolerance / (spread * np.sqrt(2 * np.pi))
    fit = float(np.log((1.0 - STRAY) * exact + STRAY).mean())
    against = looked_through(sighting)
    if is_all_known:
        ahead = sighting.ahead[~is_other[sighting.hidden]]
        close = int(np.count_nonzero((ahead > tolerance) & (ahead <= CLOSE_IN_FRONT * tolerance)))
        far = int(np.count_nonzero(ahead > CLOSE_IN_FRONT * tolerance))
        odd = int(np.count_nonzero(ahead <= tolerance))
        against += CLOSE_AHEAD * close + AHEAD * far + ODD * odd
    return min(fit, most) - against / len(off)


def looked_through(sighting: Sighting) -> float:
    """What speaks against a part [nat], all pixels together, where the scan looks through it."""
    rim = int(np.count_nonzero(sighting.is_rim))
    return THROUGH * (len(sighting.violated) - rim) + THROUGH_RIM * rim
