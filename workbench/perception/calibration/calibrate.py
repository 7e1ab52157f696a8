"""Eye-to-hand calibration: where the scanner is, from a plate that the robot holds into its view.

Whatever the arm does, `T_world_scanner * p_scanner = T_world_flange * T_flange_plate * p_plate` for
each ball.  Unknown are the scanner's pose and how the plate is held.  A linear answer for three
poses at a time (rotations by Kronecker products as Li, Wang and Wu 2010, then translations) finds
those that agree; least squares over the distances of the balls; weighed by how exact robot and
balls turn out to be (`sureness`), gives the answer.
"""

from collections.abc import Mapping, Sequence
from itertools import combinations

import numpy as np
import pinocchio as pin
from scipy.optimize import least_squares

from workbench.model.calibration import Calibration, Light, PoseResidual
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, shift_and_turn
from workbench.model.messages.calibration import PlateText
from workbench.model.messages.message import Message, all_of
from workbench.perception.calibration.plate_poses import (
    Answer,
    PlatePose,
    distances,
    moved,
    offsets,
)
from workbench.perception.calibration.rigid import fitted_motion
from workbench.perception.calibration.sureness import best_fit, predicted_offsets

FEWEST_POSES = 4
"""Poses that a calibration needs; 8 are advised."""

ADVISED = 8

MOST_POSES = 60

GOOD, ACCEPTABLE = (0.001, np.deg2rad(0.3)), (0.002, np.deg2rad(0.6))
"""[m, rad] Up to here the light of a pose is green, and amber."""

AGREE, TIMES = 0.0015, 4.0
"""A pose is an outlier if its error exceeds both `AGREE` [m] and `TIMES` times the usual error."""

LARGEST_USUAL = 0.004
"""[m] More than this is never taken for usual."""

HOPELESS = 0.01
"""[m] Error within which at least half of the poses must agree."""

MOST_ROUNDS = 10
"""Of fitting and leaving out, at most."""

TRIPLES = 150
"""Of three poses at a time, this many are tried as the beginning."""

SAME_POSE = (0.005, np.deg2rad(3.0))
"""[m, rad] Poses of the flange nearer to each other than this are one."""

LEAST_TURN = np.deg2rad(8.0)
"""[rad] By which the flange must turn about two axes, RMS, between two poses."""

LARGEST_ERROR = (0.003, np.deg2rad(0.3))
"""[m, rad] Standard errors above which a calibration is refused."""


def calibrate(poses: Sequence[PlatePose], centres: Floats) -> Calibration:
    """The scanner's pose.

    Args:
        poses: 4 to 60 that are used; those that do not agree with the others are left out.
        centres: (3, 3) [m] of the balls in the plate's frame.

    Raises:
        InputError: too few poses, too similar poses, or poses that do not agree; states which, and
            what of the scanner's pose they leave open.
    """
    wanted = [pose for pose in poses if pose.is_used]
    _check(wanted)
    answer = _consensus(wanted, centres)
    # Three poses alone give a coarse answer: the better half of all improves it first.
    best = np.argsort(distances(wanted, answer, centres), kind="stable")
    used, before = sorted(best[: len(wanted) // 2 + 1].tolist()), []
    for _ in range(MOST_ROUNDS):
        answer = _fit([wanted[k] for k in used], answer, centres)
        used, before = _agreeing(wanted, answer, centres), used
        if used == before:
            break
    _check_left(wanted, used)
    chosen = [wanted[k] for k in used]
    fit = best_fit(chosen, answer, centres)
    rms = float(np.sqrt(np.mean(distances(chosen, fit.answer, centres) ** 2)))
    ahead = dict(zip(map(id, chosen), predicted_offsets(chosen, fit, centres), strict=True))
    residuals = tuple(_residual(pose, fit.answer, centres, rms, ahead) for pose in poses)
    found = Calibration(*fit.answer, residuals, rms, fit.covariance)
    _check_sure(found)
    return found


def _check(poses: Sequence[PlatePose]) -> None:
    """See that the poses can tell where the scanner is.

    Raises:
        InputError: they cannot; says why.
    """
    if len(poses) > MOST_POSES:
        raise InputError(PlateText.MOST_POSES(count=len(poses), most=MOST_POSES))
    distinct: list[PlatePose] = []
    same: list[Message] = []
    for pose in poses:
        twin = next((plate_pose for plate_pose in distinct if _is_same(plate_pose, pose)), None)
        if twin is None:
            distinct.append(pose)
        else:
            same.append(PlateText.SAME_POSE(pose=pose.name, other=twin.name))
    if len(distinct) < FEWEST_POSES:
        few = PlateText.TOO_FEW_POSES(fewest=FEWEST_POSES, advised=ADVISED, count=len(distinct))
        alike = all_of(same)
        raise InputError(few if alike is None else PlateText.SINCE_SAME(problem=few, same=alike))
    rotations = np.array([pose.T_world_flange.rotation for pose in distinct])
    # About their mean, so that no order of the poses matters.
    mean = _rotation(rotations.sum(axis=0))
    turns = np.array([pin.log3(mean.T @ rotation) for rotation in rotations])
    _, sizes, axes = np.linalg.svd(turns)
    sizes *= np.sqrt(2 / len(distinct))  # of two poses, not of one and the mean
    if sizes[0] < LEAST_TURN:
        raise InputError(PlateText.NOT_TURNED())
    if sizes[1] < LEAST_TURN:
        axis = ", ".join(f"{value:.2f}" for value in mean @ axes[0] + 0.0)
        raise InputError(PlateText.ONE_AXIS(axis=axis))


def _is_same(plate_pose: PlatePose, other: PlatePose) -> bool:
    distance, angle = shift_and_turn(plate_pose.T_world_flange.actInv(other.T_world_flange))
    return distance < SAME_POSE[0] and angle < SAME_POSE[1]


def _check_left(wanted: Sequence[PlatePose], used: Sequence[int]) -> None:
    if len(used) == len(wanted):
        return
    out = [pose.name for k, pose in enumerate(wanted) if k not in used]
    try:
        _check([wanted[k] for k in used])
    except InputError as error:
        raise InputError(PlateText.WITHOUT(poses=out, problem=error.message)) from None


def _consensus(poses: Sequence[PlatePose], centres: Floats) -> Answer:
    """The linear answer of those three poses with which most of the others agree best."""
    triples = list(combinations(poses, 3))
    answers = [_linear(three, centres) for three in triples[:: -(-len(triples) // TRIPLES)]]
    middles = [
        float(np.sort(distances(poses, answer, centres))[len(poses) // 2]) for answer in answers
    ]
    best = int(np.argmin(middles))
    if middles[best] > HOPELESS:
        raise InputError(PlateText.NO_CONSENSUS(far=middles[best]))
    return answers[best]


def _linear(poses: Sequence[PlatePose], centres: Floats) -> Answer:
    """Rotations, then translations, each by linear equations."""
    plates = [fitted_motion(centres, pose.balls) for pose in poses]
    flanges = [pose.T_world_flange for pose in poses]
    rows = np.concatenate(
        [
            np.hstack([np.kron(R.T, np.eye(3)), -np.kron(np.eye(3), T.rotation)])
            for (R, _), T in zip(plates, flanges, strict=True)
        ]
    )
    null = np.linalg.svd(rows)[2][-1]
    X, Y = (null[k : k + 9].reshape(3, 3).T for k in (0, 9))
    X, Y = _rotation(X), _rotation(Y)
    # X p + x = F (Y 0 + y) + f for the plate's origin p in the scanner's frame.
    left = np.concatenate([np.hstack([np.eye(3), -T.rotation]) for T in flanges])
    right = np.concatenate(
        [T.translation - X @ p for (_, p), T in zip(plates, flanges, strict=True)]
    )
    shifts = np.linalg.lstsq(left, right, rcond=None)[0]
    return pin.SE3(X, shifts[:3]), pin.SE3(Y, shifts[3:])


def _rotation(matrix: Floats) -> Floats:
    """The rotation nearest to a multiple of one, whatever its sign."""
    u, _, vt = np.linalg.svd(matrix * np.sign(np.linalg.det(matrix) or 1.0))
    return u @ np.diag([1.0, 1.0, np.linalg.det(u @ vt)]) @ vt


def _agreeing(poses: Sequence[PlatePose], answer: Answer, centres: Floats) -> list[int]:
    off = distances(poses, answer, centres)
    usual = float(np.sort(off)[len(poses) // 2])
    gate = max(AGREE, TIMES * min(usual, LARGEST_USUAL))
    return [k for k, distance in enumerate(off) if distance <= gate]


def _fit(poses: Sequence[PlatePose], start: Answer, centres: Floats) -> Answer:
    """Least squares over all balls."""

    def off(step: Floats) -> Floats:
        return offsets(poses, moved(start, step), centres).ravel()

    found = least_squares(off, np.zeros(12))
    return moved(start, found.x)


def _check_sure(found: Calibration) -> None:
    """See that the answer is of use.

    Raises:
        InputError: it is so unsure that it is not; says along what.
    """
    position, angle = found.position_error, found.angle_error
    if position > LARGEST_ERROR[0] or angle > LARGEST_ERROR[1]:
        directions = np.linalg.eigh(found.covariance[:3, :3])[1]
        world = ", ".join(f"{v:.2f}" for v in directions[:, -1] + 0.0)
        raise InputError(PlateText.TOO_UNCERTAIN(far=position, axis=world, turn=angle))


def _residual(
    pose: PlatePose,
    answer: Answer,
    centres: Floats,
    rms: float,
    ahead: Mapping[int, tuple[float, float] | None],
) -> PoseResidual:
    """What is left of a pose; `ahead` has what the others predict of those used, by their ids."""
    X, Y = answer
    distance = float(distances([pose], answer, centres)[0])
    seen, _ = fitted_motion(centres, pose.balls)
    turn = (pose.T_world_flange.rotation @ Y.rotation).T @ X.rotation @ seen
    angle = float(np.linalg.norm(pin.log3(turn)))
    if id(pose) in ahead:
        predicted = ahead[id(pose)]
        light: Light = "warning" if predicted is None else _light(*predicted)
        return PoseResidual(pose.name, distance, angle, light, None, predicted)
    left_out = PlateText.LEFT_OUT()
    if pose.is_used:
        left_out = PlateText.CONFLICT(far=distance, turn=angle, rms=rms)
    # The others have said so without it.
    return PoseResidual(pose.name, distance, angle, "bad", left_out, (distance, angle))


def _light(distance: float, angle: float) -> Light:
    lights: tuple[tuple[Light, tuple[float, float]], ...] = (
        ("good", GOOD),
        ("warning", ACCEPTABLE),
    )
    for light, (far, turned) in lights:
        if distance <= far and angle <= turned:
            return light
    return "bad"
