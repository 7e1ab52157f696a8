"""How sure a calibration is: its covariance, each pose predicted by the others, errors of points.

A robot is less exact than a scanner of balls is: where it holds the plate is off by some tenths of
a millimetre; how it turns it is off by some hundredths of a degree, for all three balls of a pose
alike.  Nine numbers of a pose are therefore no nine measurements.  They are taken as one shift
and one turn of the plate, which four kinds of errors make (`pose_errors`) and their variances
weigh.  Errors of real robots are not all of that form: where poses predict each other clearly
better without turns of the flange, these are left out.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv

from workbench.model.geometry import Floats
from workbench.perception.calibration.plate_poses import Answer, PlatePose, crosses, moved
from workbench.perception.calibration.pose_errors import (
    bent_squares,
    estimate_variances,
    inverse,
    rigid_errors,
    weigh,
)

BEGIN = 0.0001
"""[m] Deviation of each kind of error at the beginning."""

FIT_ROUNDS = 10
"""Of weighing and fitting."""

ERROR_KINDS, FEWER_KINDS = (0, 1, 2), (0, 2)
"""Errors of `error_covariances` that are estimated, and those without turns of the flange."""

CLEARLY_BETTER, FEWEST_POSES = 0.85, 12
"""Predictions are clearly better where they are off by less than this share, where there are at
least as many poses: a few predict each other well by chance."""

ALONE = 1e-6
"""Of a direction of a pose no more than this share is known without it: nothing is."""

CONFIDENCE = 0.95
"""Confidence level of the stated errors of points."""


@dataclass(frozen=True, slots=True, eq=False)
class PlateFit:
    """The best answer, and what is not known of it.

    `variances` (4,) [m2] are those of the kinds of errors, in the order of `error_covariances`.
    `information` (12, 12) [1/m2, 1/rad2] is that of the motion of `moved`.  `widening` is by how
    much a covariance is larger since the variances are known by a few poses only.
    """

    answer: Answer
    variances: Floats
    information: Floats
    widening: float

    @property
    def covariance(self) -> Floats:
        """Of the scanner's pose (6, 6) [m, rad], as `Calibration` has it."""
        return self.covariance_with(np.zeros((6, 12)))

    def covariance_with(self, rows: Floats) -> Floats:
        """Of the scanner's pose if one more pose had the rows (6, 12) of `weighed_slopes`."""
        R = np.kron(np.eye(2), self.answer[0].rotation)
        known = inverse(self.information + rows.T @ rows)[:6, :6]
        found = self.widening * R @ known @ R.T
        return (found + found.T) / 2


def best_fit(poses: Sequence[PlatePose], start: Answer, centres: Floats) -> PlateFit:
    """Weighed least squares over the shifts and turns of the plate, from a fit that is near.

    Args:
        poses: 4 or more, whose flange turns about two axes.
        start: least squares over the balls, or better.
        centres: (3, 3) [m] of the balls in the plate's frame.
    """
    fit = _fit_kinds(poses, start, centres, ERROR_KINDS)
    if len(poses) < FEWEST_POSES:
        return fit
    simpler = _fit_kinds(poses, fit.answer, centres, FEWER_KINDS)
    off, simpler_off = (
        sum(predicted[0] ** 2 for predicted in predicted_offsets(poses, each, centres) if predicted)
        for each in (fit, simpler)
    )
    return simpler if simpler_off < CLEARLY_BETTER**2 * off else fit


def _fit_kinds(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, kinds: tuple[int, ...]
) -> PlateFit:
    """The best answer if the errors, besides those of the balls, are of these kinds."""
    variances = np.zeros(4)
    variances[[*kinds, 3]] = BEGIN**2
    for _ in range(FIT_ROUNDS):
        rows, off, _ = weigh(poses, answer, centres, variances)
        bread = inverse(np.einsum("nik,nil->kl", rows, rows))
        answer = moved(answer, -bread @ np.einsum("nik,ni->k", rows, off))
        variances = estimate_variances(poses, answer, centres, variances, kinds)
    rows, _, _ = weigh(poses, answer, centres, variances)
    # As the 95 % quantile of Fisher's distribution is larger than that of the chi-square; most
    # poses are off by one kind of error, which half of their numbers show.
    freedom = 3 * len(poses) - 6
    widening = (freedom + 2) / (freedom - 2)
    return PlateFit(answer, variances, np.einsum("nik,nil->kl", rows, rows), widening)


def weighed_slopes(pose: PlatePose, fit: PlateFit, centres: Floats) -> Floats:
    """Rows (6, 12), no unit, for shift and turn of the plate in a pose, by the errors of a fit."""
    return weigh([pose], fit.answer, centres, fit.variances)[0][0]


def predicted_offsets(
    poses: Sequence[PlatePose], fit: PlateFit, centres: Floats
) -> list[tuple[float, float] | None]:
    """How far each pose is from where all the others predict it.

    By the leverage of the linear problem (Cook and Weisberg, Residuals and influence in regression,
    1982, section 2.2), not by fitting again.

    Args:
        poses: those that were fitted.
        fit: what came of them.
        centres: (3, 3) [m] of the balls in the plate's frame.

    Returns:
        RMS over the balls [m] and the plate's turn [rad]; None of a pose that the others alone
        leave open.
    """
    rows, off, roots = weigh(poses, fit.answer, centres, fit.variances)
    bread = inverse(fit.information)
    _, seen, to_turns = rigid_errors(poses, fit.answer, centres)
    bent = bent_squares(poses, fit.answer, centres, seen)
    found: list[tuple[float, float] | None] = []
    for k in range(len(poses)):
        left = np.eye(6) - rows[k] @ bread @ rows[k].T
        if np.linalg.eigvalsh((left + left.T) / 2)[0] < ALONE:
            found.append(None)
            continue
        ahead = roots[k] @ np.linalg.solve(left, off[k])
        distance = float(np.sqrt((ahead @ ahead + bent[k]) / 3))
        found.append((distance, float(np.linalg.norm(to_turns[k] @ ahead[3:]))))
    return found


def point_errors(covariance: Floats, origin: Floats, points: Floats) -> Floats:
    """How far off points are seen by what is not known of the scanner's pose, (n,) [m].

    In 95 % of calibrations a point is no further off.  Its squared error is a sum of three squares
    of different size.  It is taken as one chi-square of the same mean and variance (Box, Annals of
    Mathematical Statistics 25, 1954).

    Args:
        covariance: (6, 6) [m, rad] of shifts of the scanner and turns about it, along the world's
            axes.
        origin: (3,) [m] of the scanner, in the world.
        points: (n, 3) [m], in the world.
    """
    turned = -crosses(points - origin)
    moves = np.concatenate([np.broadcast_to(np.eye(3), turned.shape), turned], axis=2)
    each = moves @ covariance @ moves.transpose(0, 2, 1)
    mean = np.trace(each, axis1=1, axis2=2)
    squares = (each**2).sum(axis=(1, 2))
    # From 1, where one direction has it all, to 3; also where nothing is unsure.
    freedom = np.maximum(mean**2 / np.maximum(squares, 1e-300), 1.0)
    return np.sqrt(squares / np.maximum(mean, 1e-300) * 2 * gammaincinv(freedom / 2, CONFIDENCE))
