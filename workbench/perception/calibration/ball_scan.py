"""The balls of an artefact in a scan: centres, diameters and form."""

import numpy as np

from workbench.model.calibration import BallArtefact, BallScan
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.calibration import VerifyText
from workbench.model.scan import Scan
from workbench.perception.calibration.balls import FEWEST_POINTS, choose_balls, find_balls

DISTANCE_TOLERANCE, OFF_SHARE = 0.003, 0.02
"""[m, share of the longest distance] By which distances may be off, so that they are the balls'."""

CAP = 0.5
"""Cosine of the half-angle of the cap towards the scanner that is measured: no edges, no rods."""

SHELL = 0.2
"""Points within this share of the radius from a ball's surface may be measured on it."""

OUTLIER_DEVIATIONS = 3.0
"""Standard deviations from the surface beyond which a point is an outlier."""

FIT_STEPS = 8
"""Of fitting a sphere."""


def sight_balls(scan: Scan, artefact: BallArtefact, name: str, q: Floats, seed: int) -> BallScan:
    """The balls of an artefact in a scan.

    Args:
        scan: organised or not; anything else may be in it.
        artefact: what to look for.
        name: of the scan, for people.
        q: (n,) [rad] of the arm that carries the scanner; empty where it stands.
        seed: of a simulated scan.

    Raises:
        InputError: too few balls are seen, some are covered, or none have the stated distances.
    """
    found = find_balls(scan.points, artefact.radius)[0]
    count, lengths = len(artefact.centres), artefact.lengths
    off, chosen = choose_balls(found, lengths, count)
    if off > max(DISTANCE_TOLERANCE, OFF_SHARE * float(lengths.max())):
        raise InputError(
            VerifyText.NOT_SEEN(
                scan=name, found=len(found), ball=f"{artefact.radius * 2000:g}", count=count
            )
        )
    fits = [_fit_ball(scan.points, found[k], artefact.radius) for k in chosen]
    balls = [fit for fit in fits if fit is not None]
    if len(balls) < count:
        raise InputError(VerifyText.COVERED(scan=name))
    centres, diameters, forms = (np.array(values) for values in zip(*balls, strict=True))
    return BallScan(name, artefact, centres, diameters, forms, q, seed)


def _fit_ball(points: Floats, centre: Floats, radius: float) -> tuple[Floats, float, float] | None:
    """The centre (3,) of a sphere of the stated radius, and diameter and form [m] of a free one.

    None where too few points show it.
    """
    offsets = points - centre
    lengths = np.linalg.norm(offsets, axis=1)
    facing = -offsets @ centre > CAP * lengths * np.linalg.norm(centre)
    near = points[(np.abs(lengths - radius) < SHELL * radius) & facing]
    if len(near) < FEWEST_POINTS:
        return None
    fixed, _, _ = _fit_sphere(near, centre, radius, is_free=False)
    _, size, left = _fit_sphere(near, centre, radius, is_free=True)
    low, high = np.quantile(left, (0.025, 0.975))
    return fixed, 2 * size, float(high - low)


def _fit_sphere(
    points: Floats, centre: Floats, radius: float, *, is_free: bool
) -> tuple[Floats, float, Floats]:
    """Centre (3,), radius and residuals (n,) [m] by least squares without outliers."""
    gate = np.inf
    for _ in range(FIT_STEPS):
        offsets = points - centre
        lengths = np.linalg.norm(offsets, axis=1)
        left = lengths - radius
        on = np.abs(left) < gate
        rows = np.column_stack([offsets / lengths[:, None], np.full(len(points), float(is_free))])
        move = np.linalg.lstsq(rows[on], left[on], rcond=None)[0]
        centre, radius = centre + move[:3], radius + float(move[3]) * is_free
        gate = OUTLIER_DEVIATIONS * 1.4826 * float(np.median(np.abs(left))) + 1e-9
    return centre, radius, np.linalg.norm(points - centre, axis=1) - radius
