"""How sure a calibration is: its covariance, each pose predicted by the others, errors of points.

A robot is less exact than a scanner of balls is: where it holds the plate is off by some tenths of
a millimetre; how it turns it is off by some hundredths of a degree, for all three balls of a pose
alike.  Nine numbers of a pose are therefore no nine measurements.  They are taken as one shift
and one turn of the plate.  Their two variances are estimated from the poses themselves by their
second moments (Rao, Journal of Multivariate Analysis 1, 1971), and by which both are weighed.
Balls that are each off by themselves are the case of equal variances.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.special import gammaincinv

from workbench.model.geometry import Floats
from workbench.perception.calibration.plate_poses import (
    Answer,
    PlatePose,
    crosses,
    moved,
    offsets,
    slopes,
)

NOISE = 0.00005
"""[m] Nobody measures a ball better, however well a few of them happen to fit."""

ROUNDS = 5
"""Of weighing and fitting."""

STEPS = 3
"""Of Gauss and Newton in each; the beginning is a fit already."""

RATIOS = (0.1, 10.0)
"""Shifts count at most so much less and more than turns."""

ALONE = 1e-6
"""Of a direction of a pose no more than this share is known without it: nothing is."""

SURE = 0.95
"""Share of calibrations in which a point is no further off than is said."""


@dataclass(frozen=True, slots=True, eq=False)
class PlateFit:
    """The best answer, and what is not known of it.

    `shift` and `turn` [m] are the deviations of a ball's coordinate by a shift of the whole plate
    and by its turn.  `shifts` and `turns` (12, 12) are what the poses tell of the motion of `moved`
    by each, of unit deviation and weighed by 1 and by `ratio`.
    """

    answer: Answer
    shift: float
    turn: float
    ratio: float
    shifts: Floats
    turns: Floats

    @property
    def covariance(self) -> Floats:
        """Of the scanner's pose (6, 6) [m, rad], as `Calibration` has it."""
        return self.covariance_with(None)

    def covariance_with(self, rows: Floats | None) -> Floats:
        """Of the scanner's pose if one more pose had the rows (6, 12) of `rigid_slopes`."""
        shifts, turns = self.shifts, self.turns
        if rows is not None:
            shifts = shifts + rows[:3].T @ rows[:3]
            turns = turns + self.ratio**2 * rows[3:].T @ rows[3:]
        bread = _inverse(shifts + turns)
        spread = self.shift**2 * shifts + (self.ratio * self.turn) ** 2 * turns
        R = np.kron(np.eye(2), self.answer[0].rotation)
        found = R @ (bread @ spread @ bread)[:6, :6] @ R.T
        return (found + found.T) / 2


def best_fit(poses: Sequence[PlatePose], start: Answer, centres: Floats) -> PlateFit:
    """Weighed least squares over the shifts and turns of the plate, from a fit that is near.

    Args:
        poses: 4 or more, whose flange turns about two axes.
        start: least squares over the balls, or better.
        centres: (3, 3) [m] of the balls in the plate's frame.
    """
    fit = _fit_weighed(poses, start, centres, 1.0)
    for _ in range(ROUNDS):
        ratio = float(np.clip(fit.shift / fit.turn, *RATIOS))
        fit = _fit_weighed(poses, fit.answer, centres, ratio)
    return fit


def _fit_weighed(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, ratio: float
) -> PlateFit:
    """The best answer by one ratio of the weights, and what it leaves over."""
    for _ in range(STEPS):
        rows, off = _weigh(poses, answer, centres, ratio)
        bread = _inverse(np.einsum("nik,nil->kl", rows, rows))
        answer = moved(answer, -bread @ np.einsum("nik,ni->k", rows, off))
    return PlateFit(answer, *_deviations(poses, answer, centres, ratio))


def rigid_slopes(pose: PlatePose, answer: Answer, centres: Floats) -> Floats:
    """Three rows for the shift of the plate and three for its turn, (6, 12), no unit: weighed."""
    return _rigid([pose], answer, centres)[0][0]


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
    rows, off = _weigh(poses, fit.answer, centres, fit.ratio)
    bread = _inverse(np.einsum("nik,nil->kl", rows, rows))
    _, seen, to_turns = _rigid(poses, fit.answer, centres)
    all_off = (offsets(poses, fit.answer, centres) ** 2).sum(axis=(1, 2))
    found: list[tuple[float, float] | None] = []
    for k in range(len(poses)):
        left = np.eye(6) - rows[k] @ bread @ rows[k].T
        if np.linalg.eigvalsh((left + left.T) / 2)[0] < ALONE:
            found.append(None)
            continue
        ahead = np.linalg.solve(left, off[k])
        ahead[3:] /= fit.ratio
        bent = max(all_off[k] - seen[k] @ seen[k], 0.0)  # the balls among each other
        distance = float(np.sqrt((ahead @ ahead + bent) / 3))
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
    return np.sqrt(squares / np.maximum(mean, 1e-300) * 2 * gammaincinv(freedom / 2, SURE))


def _rigid(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats
) -> tuple[Floats, Floats, Floats]:
    """Slopes (n, 6, 12) and offsets (n, 6) of shifts and turns, and what makes the latter turns.

    The unit is that of a ball's coordinate [m]; the last, (n, 3, 3), brings the three numbers of a
    turn to its rotation vector [rad].
    """
    off, slope = offsets(poses, answer, centres), slopes(poses, answer, centres)
    arms = (centres - centres.mean(axis=0)) @ answer[1].rotation.T
    turned = np.array([-crosses(arms @ pose.T_world_flange.rotation.T) for pose in poses])
    basis, triangle = np.linalg.qr(turned.reshape(-1, 9, 3))
    across = basis.transpose(0, 2, 1)
    size = np.sqrt(3.0)
    rows = np.concatenate([size * slope.mean(axis=1), across @ slope.reshape(-1, 9, 12)], axis=1)
    seen = np.concatenate(
        [size * off.mean(axis=1), (across @ off.reshape(-1, 9, 1))[..., 0]], axis=1
    )
    return rows, seen, np.linalg.inv(triangle)


def _weigh(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, ratio: float
) -> tuple[Floats, Floats]:
    rows, off, _ = _rigid(poses, answer, centres)
    rows[:, 3:] *= ratio
    off[:, 3:] *= ratio
    return rows, off


def _deviations(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, ratio: float
) -> tuple[float, float, float, Floats, Floats]:
    """All of `PlateFit` but its answer.

    The sums of squares left over are what both variances would leave on average.  A variance that
    was measured by few numbers is taken as larger by some (n + 2) / (n - 2): as the 95 % quantile
    of Fisher's distribution is than that of the chi-square.
    """
    rows, off = _weigh(poses, answer, centres, ratio)
    parts = [np.einsum("nik,nil->kl", half, half) for half in (rows[:, :3], rows[:, 3:])]
    bread = _inverse(parts[0] + parts[1])
    taken = [bread @ part for part in parts]
    # Traces of P_a M P_b M, where M takes from the noise what the fit follows of it.
    whole = 3.0 * len(poses)
    mixed = float(np.trace(taken[0] @ taken[1]))
    left = [
        whole - 2 * float(np.trace(projection)) + float(np.trace(projection @ projection))
        for projection in taken
    ]
    sums = [float((half**2).sum()) for half in (off[:, :3], off[:, 3:])]
    found = np.linalg.lstsq(
        np.array([[left[0], mixed], [mixed, left[1]]]), np.array(sums), rcond=1e-9
    )[0]
    deviations: list[float] = []
    for variance, freedom, weight in zip(found, left, (1.0, ratio), strict=True):
        wider = (freedom + 2) / (freedom - 2) if freedom > 4 else 3.0
        deviations.append(max(NOISE, float(np.sqrt(max(variance, 0.0) * wider)) / weight))
    return deviations[0], deviations[1], ratio, parts[0], parts[1]


def _inverse(matrix: Floats) -> Floats:
    """Of a symmetric matrix; directions in which it says nothing stay at zero."""
    return np.asarray(np.linalg.pinv(matrix, rcond=1e-14, hermitian=True), dtype=np.float64)
