"""How sure a calibration is: its covariance, each pose predicted by the others, errors of points.

A robot is less exact than a scanner of balls is: where it holds the plate is off by some tenths of
a millimetre; how it turns it is off by some hundredths of a degree, for all three balls of a pose
alike.  Nine numbers of a pose are therefore no nine measurements.  They are taken as one shift
and one turn of the plate.  Four kinds of errors make them: the flange is shifted, it is turned,
which shifts a plate that is far from it, the plate is seen turned, and each ball is seen shifted.
The variance of the last is what the distances between the balls say; the others are estimated from
the poses themselves by restricted maximum likelihood (Patterson and Thompson, Biometrika 58, 1971),
by steps of Rao's second moments (Journal of Multivariate Analysis 1, 1971), and weigh them.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import nnls
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

BEGIN = 0.0001
"""[m] Deviation of each kind of error at the beginning."""

LEVER = 0.1
"""[m] A turn counts as the shift of what is so far away."""

ROUNDS = 10
"""Of weighing and fitting."""

ALONE = 1e-6
"""Of a direction of a pose no more than this share is known without it: nothing is."""

SURE = 0.95
"""Share of calibrations in which a point is no further off than is said."""


@dataclass(frozen=True, slots=True, eq=False)
class PlateFit:
    """The best answer, and what is not known of it.

    `variances` (4,) [m2] are those of the kinds of errors, in the order of `error_covariances`.
    `information` (12, 12) is what the poses tell of the motion of `moved`.  `widening` is by how
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
        known = _inverse(self.information + rows.T @ rows)[:6, :6]
        found = self.widening * R @ known @ R.T
        return (found + found.T) / 2


def best_fit(poses: Sequence[PlatePose], start: Answer, centres: Floats) -> PlateFit:
    """Weighed least squares over the shifts and turns of the plate, from a fit that is near.

    Args:
        poses: 4 or more, whose flange turns about two axes.
        start: least squares over the balls, or better.
        centres: (3, 3) [m] of the balls in the plate's frame.
    """
    answer, variances = start, np.full(4, BEGIN**2)
    for _ in range(ROUNDS):
        rows, off, _ = _weigh(poses, answer, centres, variances)
        bread = _inverse(np.einsum("nik,nil->kl", rows, rows))
        answer = moved(answer, -bread @ np.einsum("nik,ni->k", rows, off))
        variances = _estimate_variances(poses, answer, centres, variances)
    rows, _, _ = _weigh(poses, answer, centres, variances)
    # As the 95 % quantile of Fisher's distribution is larger than that of the chi-square; most
    # poses are off by one kind of error, which half of their numbers show.
    freedom = 3 * len(poses) - 6
    widening = (freedom + 2) / (freedom - 2)
    return PlateFit(answer, variances, np.einsum("nik,nil->kl", rows, rows), widening)


def weighed_slopes(pose: PlatePose, fit: PlateFit, centres: Floats) -> Floats:
    """Rows (6, 12), no unit, for shift and turn of the plate in a pose, by the errors of a fit."""
    return _weigh([pose], fit.answer, centres, fit.variances)[0][0]


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
    rows, off, roots = _weigh(poses, fit.answer, centres, fit.variances)
    bread = _inverse(fit.information)
    _, seen, to_turns = rigid_errors(poses, fit.answer, centres)
    bent = _bent(poses, fit.answer, centres, seen)
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
    return np.sqrt(squares / np.maximum(mean, 1e-300) * 2 * gammaincinv(freedom / 2, SURE))


def rigid_errors(
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


def error_covariances(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, to_turns: Floats
) -> Floats:
    """What unit variances of errors make of the offsets of `rigid_errors`, (4, n, 6, 6), no unit.

    Shifts of the hand, its turns about itself, turns of the plate about its middle, of both by what
    they shift at `LEVER`, and shifts of single balls.

    Args:
        poses: n of them.
        answer: where scanner and plate are.
        centres: (3, 3) [m] of the balls in the plate's frame.
        to_turns: (n, 3, 3), see `rigid_errors`.
    """
    middle = answer[1].act(centres.mean(axis=0))
    arms = np.array([pose.T_world_flange.act(middle) - pose.hand for pose in poses])
    turns = np.linalg.inv(to_turns) / LEVER
    shifts = -np.sqrt(3.0) * crosses(arms) / LEVER
    by_hand = np.concatenate([shifts, turns], axis=1)
    by_plate = np.concatenate([np.zeros_like(shifts), turns], axis=1)
    found = np.zeros((4, len(poses), 6, 6))
    found[0, :, :3, :3] = 3 * np.eye(3)
    for number, jacobian in ((1, by_hand), (2, by_plate)):
        found[number] = jacobian @ jacobian.transpose(0, 2, 1)
    found[3] = np.eye(6)
    return found


def _weigh(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, variances: Floats
) -> tuple[Floats, Floats, Floats]:
    """Slopes (n, 6, 12) and offsets (n, 6) in deviations, and these (n, 6, 6): lower triangles."""
    rows, off, to_turns = rigid_errors(poses, answer, centres)
    kinds = error_covariances(poses, answer, centres, to_turns)
    roots = np.linalg.cholesky(np.einsum("c,cnij->nij", variances, kinds))
    return np.linalg.solve(roots, rows), np.linalg.solve(roots, off[..., None])[..., 0], roots


def _estimate_variances(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, before: Floats
) -> Floats:
    """The variances (4,) [m2] of the kinds of errors, from those (4,) [m2] of the round before.

    What is left over is, on average, what the kinds of errors leave, less what the fit follows of
    them.  None is below zero.
    """
    rows, seen, to_turns = rigid_errors(poses, answer, centres)
    count = len(poses)
    ball = max(NOISE**2, float(_bent(poses, answer, centres, seen).sum()) / (3 * count))
    kinds = error_covariances(poses, answer, centres, to_turns)
    weights = np.linalg.inv(np.einsum("c,cnij->nij", before, kinds))
    # The projection that takes from weighed offsets what the fit follows of them.
    followed = (weights @ rows).reshape(-1, 12)
    bread = _inverse(np.einsum("nik,nij,njl->kl", rows, weights, rows))
    projection = -(followed @ bread @ followed.T)
    blocks = projection.reshape(count, 6, count, 6)
    each = np.arange(count)
    blocks[each, :, each] += weights
    left = (projection @ seen.ravel()).reshape(count, 6)
    taken = [
        np.einsum("anj,njk->ank", projection.reshape(-1, count, 6), kind).reshape(projection.shape)
        for kind in kinds
    ]
    shares = np.array([[np.sum(one * other.T) for other in taken] for one in taken[:3]])
    sums = np.einsum("ni,cnij,nj->c", left, kinds[:3], left) - ball * shares[:, 3]
    size = 1 / np.sqrt(np.diag(shares))
    found, _ = nnls(size[:, None] * shares[:, :3] * size, size * sums)
    return np.array([*(size * found), ball])


def _bent(poses: Sequence[PlatePose], answer: Answer, centres: Floats, seen: Floats) -> Floats:
    """What the balls of each pose are off among each other, (n,) [m2], beside `seen` (n, 6) [m]."""
    squares = (offsets(poses, answer, centres) ** 2).sum(axis=(1, 2))
    return np.maximum(squares - (seen**2).sum(axis=1), 0.0)


def _inverse(matrix: Floats) -> Floats:
    """Of a symmetric matrix; directions in which it says nothing stay at zero."""
    return np.asarray(np.linalg.pinv(matrix, rcond=1e-14, hermitian=True), dtype=np.float64)
