"""Errors of the poses of a plate: kinds of them, what they make of its shifts and turns, variances.

The flange is shifted.  It is turned, which shifts a plate that is far from it.  The plate is seen
turned.  Each ball is seen shifted: the distances between balls give that variance.  The others are
estimated from the poses themselves by restricted maximum likelihood (Patterson and Thompson,
Biometrika 58, 1971).  A step takes Rao's second moments (Journal of Multivariate Analysis 1, 1971).
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import nnls

from workbench.model.geometry import Floats
from workbench.perception.calibration.plate_poses import (
    Answer,
    PlatePose,
    crosses,
    offsets,
    slopes,
)

NOISE = 0.00005
"""[m] Nobody measures a ball better, however well a few of them happen to fit."""

LEVER = 0.1
"""[m] A turn counts as the shift of a point at this distance."""


def rigid_errors(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats
) -> tuple[Floats, Floats, Floats]:
    """Slopes (n, 6, 12) and offsets (n, 6) [m] of shifts and turns, and what makes these turns.

    The last, (n, 3, 3) [rad/m], brings the three numbers of a turn to its rotation vector.

    Args:
        poses: n of them.
        answer: where scanner and plate are.
        centres: (3, 3) [m] of the balls in the plate's frame.
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

    Shifts of the hand, its turns about itself, turns of the plate about its middle, and shifts of
    single balls.  Turns are measured by what they shift at `LEVER`.

    Args:
        poses: n of them.
        answer: where scanner and plate are.
        centres: (3, 3) [m] of the balls in the plate's frame.
        to_turns: (n, 3, 3) [rad/m], see `rigid_errors`.
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


def weigh(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, variances: Floats
) -> tuple[Floats, Floats, Floats]:
    """Slopes (n, 6, 12) and offsets (n, 6) in deviations, and these (n, 6, 6) [m], triangular.

    Args:
        poses: n of them.
        answer: where scanner and plate are.
        centres: (3, 3) [m] of the balls in the plate's frame.
        variances: (4,) [m2] of the kinds of errors.
    """
    rows, off, to_turns = rigid_errors(poses, answer, centres)
    kinds = error_covariances(poses, answer, centres, to_turns)
    roots = np.linalg.cholesky(np.einsum("c,cnij->nij", variances, kinds))
    return np.linalg.solve(roots, rows), np.linalg.solve(roots, off[..., None])[..., 0], roots


def estimate_variances(
    poses: Sequence[PlatePose],
    answer: Answer,
    centres: Floats,
    before: Floats,
    wanted: tuple[int, ...],
) -> Floats:
    """The variances (4,) [m2] of the kinds of errors, from those (4,) [m2] of the round before.

    What is left over is, on average, what the kinds of errors leave, less what the fit follows of
    them.  None is below zero; those of kinds that are not wanted are zero.

    Args:
        poses: n of them.
        answer: where scanner and plate are.
        centres: (3, 3) [m] of the balls in the plate's frame.
        before: see there.
        wanted: numbers of the kinds, besides that of single balls.
    """
    rows, seen, to_turns = rigid_errors(poses, answer, centres)
    count = len(poses)
    ball = max(NOISE**2, float(bent_squares(poses, answer, centres, seen).sum()) / (3 * count))
    kinds = error_covariances(poses, answer, centres, to_turns)
    weights = np.linalg.inv(np.einsum("c,cnij->nij", before, kinds))
    kinds = kinds[[*wanted, 3]]
    # The projection that takes from weighed offsets what the fit follows of them.
    followed = (weights @ rows).reshape(-1, 12)
    bread = inverse(np.einsum("nik,nij,njl->kl", rows, weights, rows))
    projection = -(followed @ bread @ followed.T)
    blocks = projection.reshape(count, 6, count, 6)
    each = np.arange(count)
    blocks[each, :, each] += weights
    left = (projection @ seen.ravel()).reshape(count, 6)
    taken = [
        np.einsum("anj,njk->ank", projection.reshape(-1, count, 6), kind).reshape(projection.shape)
        for kind in kinds
    ]
    shares = np.array([[np.sum(a * b.T) for b in taken] for a in taken[:-1]])
    sums = np.einsum("ni,cnij,nj->c", left, kinds[:-1], left) - ball * shares[:, -1]
    size = 1 / np.sqrt(np.diag(shares))
    found = np.zeros(4)
    found[[*wanted]] = size * nnls(size[:, None] * shares[:, :-1] * size, size * sums)[0]
    found[3] = ball
    return found


def bent_squares(
    poses: Sequence[PlatePose], answer: Answer, centres: Floats, seen: Floats
) -> Floats:
    """What the balls of each pose are off among each other, (n,) [m2], besides `seen` (n, 6) [m].

    Args:
        poses: n of them.
        answer: where scanner and plate are.
        centres: (3, 3) [m] of the balls in the plate's frame.
        seen: the offsets of `rigid_errors`.
    """
    squares = (offsets(poses, answer, centres) ** 2).sum(axis=(1, 2))
    return np.maximum(squares - (seen**2).sum(axis=1), 0.0)


def inverse(matrix: Floats) -> Floats:
    """Of a symmetric matrix (n, n), no unit; directions in which it is zero stay at zero."""
    return np.asarray(np.linalg.pinv(matrix, rcond=1e-14, hermitian=True), dtype=np.float64)
