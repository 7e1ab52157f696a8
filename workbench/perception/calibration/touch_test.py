"""Touch test: balls where a tool tip touches them, against where the scanner has them.

The errors of a calibration move all balls together, as its covariance says; those of robot and
touching differ from touch to touch, as the residuals of the calibration's poses do.  Draws of both
give the largest offset that 95 % of tests stay below.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.calibration import BallScan, Light, Touch
from workbench.model.cell import Cell
from workbench.model.derived.scanner_poses import calibration_covariance, scanner_pose
from workbench.model.derived.touches import TouchedBall, touched_ball
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.messages.calibration import VerifyText
from workbench.model.messages.message import Message, all_of
from workbench.perception.calibration.plate_poses import crosses

FEWEST_TOUCHES = 3
"""Touches of a test."""

LEAST_SPREAD = 0.01
"""[m] RMS distance of the touched balls from the line that lies best among them, at least."""

SEATED = 0.0001
"""[m] Deviation along each axis of a tip that sits on a ball."""

CONFIDENCE = 0.95
"""Share of tests that stay below the prediction."""

DRAWS = 5_000

LEAST_TURN = np.deg2rad(20.0)
"""[rad] A tool that turns by less between touches hides an error of its TCP in the common shift."""


@dataclass(frozen=True, slots=True, eq=False)
class Offsets:
    """The largest offset [m], the length of the mean one, and the largest from the mean."""

    largest: float
    shift: float
    rest: float


@dataclass(frozen=True, slots=True, eq=False)
class TouchTest:
    """What touches say: `balls` in their order, `found` offsets, and what they may be.

    `mean` (3,) [m] is the common shift, from the robot's to the scanner's, along the world's axes.
    """

    balls: tuple[TouchedBall, ...]
    found: Offsets
    allowed: Offsets
    mean: Floats
    light: Light
    says: Message


def assess_touches(
    cell: Cell, scans: Sequence[BallScan], touches: Sequence[Touch], limit: float | None = None
) -> TouchTest:
    """Compare robot and scanner.

    Args:
        cell: with the calibrated scanner.
        scans: that the touches name.
        touches: three or more, whose balls lie on no line.
        limit: [m] of each offset; None: as the calibration predicts.

    Raises:
        InputError: too few touches, all on a line, of another cell, or no calibration that
            predicts anything.
    """
    by_name = {scan.name: scan for scan in scans}
    balls = tuple(touched_ball(cell, by_name[touch.scan], touch) for touch in touches)
    if len(balls) < FEWEST_TOUCHES:
        raise InputError(VerifyText.FEW_TOUCHES(fewest=FEWEST_TOUCHES, count=len(balls)))
    seen = np.array([ball.seen for ball in balls])
    spread = np.linalg.svd(seen - seen.mean(axis=0), compute_uv=False)
    if spread[1] < LEAST_SPREAD * np.sqrt(len(balls)):
        raise InputError(VerifyText.ON_LINE())
    offsets = np.array([ball.offset for ball in balls])
    largest, shift, rest = (float(value[0]) for value in _sizes(offsets[None]))
    found = Offsets(largest, shift, rest)
    if limit is None:
        allowed = predict_offsets(cell, seen, scanner_pose(cell, scans[0].q).translation)
    elif 0 < limit < 1:
        allowed = Offsets(limit, limit, limit)
    else:
        raise InputError(VerifyText.LIMIT())
    worst = touches[int(np.linalg.norm(offsets, axis=1).argmax())].name
    light, says = _judge(found, allowed, worst, balls, is_predicted=limit is None)
    return TouchTest(balls, found, allowed, offsets.mean(axis=0), light, says)


def predict_offsets(cell: Cell, seen: Floats, origin: Floats) -> Offsets:
    """What 95 % of tests stay below, each of the three for itself.

    Args:
        cell: whose calibration states its covariance.
        seen: (n, 3) [m] of the touched balls in the world.
        origin: (3,) [m] of the scanner.

    Raises:
        InputError: the calibration states none, or there is no calibration.
    """
    record, covariance = cell.scanner.calibration, calibration_covariance(cell.scanner)
    if record is None or covariance is None:
        raise InputError(VerifyText.NOT_PREDICTED())
    rng = np.random.default_rng(0)
    sizes, axes = np.linalg.eigh(covariance)
    moves = rng.standard_normal((DRAWS, 6)) * np.sqrt(np.maximum(sizes, 0.0)) @ axes.T
    rows = np.concatenate([np.tile(np.eye(3), (len(seen), 1, 1)), -crosses(seen - origin)], axis=2)
    # The residuals are those of the robot, in three directions.  Each pose gives six equations, and
    # the fit has taken twelve unknowns.
    widening = record.poses / max(record.poses - 2, 1)
    deviation = np.sqrt(widening * record.rms**2 / 3 + SEATED**2)
    alone = deviation * rng.standard_normal((DRAWS, len(seen), 3))
    drawn = np.einsum("kij,dj->dki", rows, moves) + alone
    return Offsets(*(float(np.quantile(values, CONFIDENCE)) for values in _sizes(drawn)))


def _sizes(offsets: Floats) -> tuple[Floats, Floats, Floats]:
    """Largest, mean and rest, as `Offsets`, of tests (d, n, 3) [m]: (d,) [m] each."""
    mean = offsets.mean(axis=1)
    rest = np.linalg.norm(offsets - mean[:, None], axis=2).max(axis=1)
    return np.linalg.norm(offsets, axis=2).max(axis=1), np.linalg.norm(mean, axis=1), rest


def _judge(
    found: Offsets,
    allowed: Offsets,
    worst: str,
    balls: Sequence[TouchedBall],
    *,
    is_predicted: bool,
) -> tuple[Light, Message]:
    of = {"off": found.largest, "bound": allowed.largest}
    if found.largest <= allowed.largest:
        agrees = VerifyText.AGREES if is_predicted else VerifyText.AGREES_LIMIT
        return "good", agrees(**of)
    differs = VerifyText.DIFFERS if is_predicted else VerifyText.DIFFERS_LIMIT
    says: list[Message] = [differs(touch=worst, **of)]
    is_shifted = found.shift / allowed.shift >= found.rest / allowed.rest
    if is_shifted or found.shift > allowed.shift:
        first = balls[0].turn
        turns = [float(np.linalg.norm(pin.log3(first.T @ ball.turn))) for ball in balls]
        text = VerifyText.SHIFTED if max(turns) > LEAST_TURN else VerifyText.SHIFTED_ALIKE
        says.append(text(shift=found.shift))
    if not is_shifted or found.rest > allowed.rest:
        says.append(VerifyText.VARIES(rest=found.rest))
    return "bad", all_of(says) or says[0]
