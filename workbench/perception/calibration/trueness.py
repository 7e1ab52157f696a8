"""Whether a scanner measures lengths truly: balls of known distances, in several places.

The terms are those of VDI/VDE 2634 part 2 and ISO 10360-13.  The sphere-spacing error is a measured
distance of two centres less the stated one.  The probing size error is a fitted diameter less the
stated one, the probing form error the spread of a ball's points about the fit.  Centres are those
of spheres of the stated diameter; form is the band of 95 % of the points, as outliers are many.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import stdtrit

from workbench.model.calibration import BallScan, Light
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.calibration import VerifyText
from workbench.model.messages.message import Message

CONFIDENCE = 0.99
"""Confidence level of a scale error."""

LEAST_SCALE = 0.0005
"""Errors of the scale below this matter to no pick, however sure they are."""

ADVISED = 3
"""Scans in different places."""

SAME_PLACE_WITHIN = 0.01
"""[m] Balls that all lie nearer to those of another scan, for the scanner, are in its place."""


@dataclass(frozen=True, slots=True, eq=False)
class Trueness:
    """What scans of an artefact say of a scanner.

    `spacings` (s,) [m] are the sphere-spacing errors of all scans in order; `largest` that of them
    with the largest absolute value, in the scan `at`.  `scale` is the error of the scale (0.001:
    lengths come out 0.1 % too long), `scale_error` its half-width at a confidence of 99 %, infinite
    where one distance leaves it open.  `size` [m] is the mean probing size error, `form` [m] the
    largest probing form error.
    """

    spacings: Floats
    largest: float
    at: str
    scale: float
    scale_error: float
    size: float
    form: float
    light: Light
    says: Message


def assess_trueness(scans: Sequence[BallScan], limit: float) -> Trueness:
    """Compare the distances in scans with the stated ones.

    Args:
        scans: one or more; in different places of the scanner's field.
        limit: [m] of the sphere-spacing errors.

    Raises:
        InputError: there is no scan, or the limit is no length above zero.
    """
    if not scans:
        raise InputError(VerifyText.NO_SCAN())
    if not 0 < limit < 1:
        raise InputError(VerifyText.LIMIT())
    stated = np.concatenate([scan.artefact.lengths for scan in scans])
    measured = np.concatenate([scan.measured for scan in scans])
    names = [scan.name for scan in scans for _ in scan.artefact.lengths]
    spacings = measured - stated
    worst = int(np.argmax(np.abs(spacings)))
    scale, scale_error = _fit_scale(stated, spacings)
    sizes = np.concatenate([scan.diameters - 2 * scan.artefact.radius for scan in scans])
    form = max(float(scan.forms.max()) for scan in scans)
    largest, size = float(spacings[worst]), float(sizes.mean())
    light: Light = "good"
    says = VerifyText.TRUE(off=abs(largest), limit=limit)
    if abs(largest) > limit:
        light, says = "bad", VerifyText.NOT_TRUE(off=abs(largest), limit=limit, scan=names[worst])
    elif abs(scale) > max(scale_error, LEAST_SCALE):
        light, says = "warning", VerifyText.SCALED(off=abs(largest), limit=limit)
    elif len(scans) - len(repeated := _find_repeated(scans)) < ADVISED:
        light, says = "warning", VerifyText.FEW_SCANS(true=says, advised=ADVISED)
        if repeated:
            name, other = repeated[0]
            says = VerifyText.SAME_PLACE(few=says, scan=name, other=other)
    return Trueness(spacings, largest, names[worst], scale, scale_error, size, form, light, says)


def _find_repeated(scans: Sequence[BallScan]) -> list[tuple[str, str]]:
    """Scans that add no place: each with the earlier scan whose balls lie where its own do."""
    repeated: list[tuple[str, str]] = []
    for number, scan in enumerate(scans):
        for other in scans[:number]:
            if scan.balls.shape != other.balls.shape:
                continue
            # Two balls can be found in either order.
            orders = (scan.balls, scan.balls[::-1]) if len(scan.balls) == 2 else (scan.balls,)
            if min(np.abs(balls - other.balls).max() for balls in orders) < SAME_PLACE_WITHIN:
                repeated.append((scan.name, other.name))
                break
    return repeated


def _fit_scale(stated: Floats, spacings: Floats) -> tuple[float, float]:
    """The error of the scale by least squares, and its half-width; infinite with one distance."""
    weight = float(stated @ stated)
    scale = float(stated @ spacings) / weight
    freedom = len(stated) - 1
    if freedom < 1:
        return scale, np.inf
    left = spacings - scale * stated
    deviation = np.sqrt(float(left @ left) / freedom / weight)
    return scale, float(stdtrit(freedom, (1 + CONFIDENCE) / 2) * deviation)
