"""A leg as `servoj` after `servoj`: the references along its curve, one every `PERIOD`.

The whole stream lies in the program, so that no network and no busy computer is between two
references: what the controller slows down comes later, and none is left out.  (Streams through
registers leave some out then: Universal Robots, "Trajectory improvements for servoj()".)

`servoj` steers each joint to its reference: by the maker's article "ServoJ command" `gain` is the
proportional term, and `lookahead_time` projects the joint's position by its speed.  `Following`
reads that as q'' = gain (reference - q - lookahead q'): a joint lags by `lookahead` behind a steady
stream, as a user has measured (34 ms at 0.03 s and 1200: issue 86 of
Universal_Robots_Client_Library).  To second order such an arm leaves the path by
(lookahead^2 - 2 / gain) q'' / 2.  That is next to nothing at 0.03 s and 2000, the values of the
maker's own driver.  At two or three times that lag it is several degrees.  So each leg is streamed
slowly enough to stay within `FOLLOWS_WITHIN` of the proven curve by this model.  The maker does not
confirm the model, so the link compares the reported joints with the curve all the time.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.devices.streamed_way import Ride, timed_way
from workbench.devices.universal_robots.following import Following
from workbench.devices.universal_robots.urscript import Line
from workbench.model.cell import Arm, Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.plan import Leg, Plan

PERIOD = 0.008
"""[s] A whole number of the controller's steps, on CB3 (8 ms) and on the e-Series (2 ms)."""

SETTLED = 8
"""[lookaheads] Duration of the last reference, so that the arm stands before a gripper moves."""

FOLLOWS_WITHIN = np.deg2rad(0.1)
"""[rad] Largest distance of a joint from the path of its references."""

SLOWER = 0.9
"""What a leg's pace is multiplied by until the arm follows so closely."""

SLOWEST = 0.05
"""[share] A leg that would have to be slower than that is not streamed."""


@dataclass(frozen=True, slots=True)
class Servo:
    """How references are followed: `lookahead` [s], `gain` [1/s2], and `share` of the speed."""

    lookahead: float
    gain: int
    share: float = 1.0


def references_of(cell: Cell, plan: Plan, arm: Arm, leg: Leg, servo: Servo) -> Floats:
    """The references of a leg (k, n) [rad], chain order, the first where it begins.

    Raises:
        InputError: even slowly the arm would not stay close to them.
    """
    way = timed_way(cell, plan, arm, leg)
    share = servo.share
    while share > SLOWEST * servo.share:
        ride = Ride(way, share, PERIOD)
        references = [ride.q]
        while not ride.is_over:
            references.append(ride.go())
        if _left_by(np.array(references), servo) <= FOLLOWS_WITHIN:
            return np.array(references)
        share *= SLOWER
    raise InputError(
        f"leg {leg.name}: with lookahead_s = {servo.lookahead:g} and gain = {servo.gain} the arm "
        f"would leave its way by more than {np.rad2deg(FOLLOWS_WITHIN):.1f} degrees however slow "
        "it is"
    )


def _left_by(references: Floats, servo: Servo) -> float:
    """How far [rad] an arm that follows references (k, n) leaves their way."""
    follows = Following(references[0].tolist(), stream_of(references.tolist(), servo))
    times = np.arange(0.0, follows.seconds, PERIOD)
    return max(float(off_the_references(np.array(follows.at(t)), references).max()) for t in times)


def stream_of(axes: Sequence[Sequence[float]], servo: Servo) -> tuple[Line, ...]:
    """The calls that follow references (k, 6) [rad], the controller's order, and come to rest."""
    resting = math.ceil(SETTLED * servo.lookahead / PERIOD)
    return tuple(
        Line("servoj", (), tuple(q), t=PERIOD, lookahead=servo.lookahead, gain=servo.gain)
        for q in (*axes, *[axes[-1]] * resting)
    )


def off_the_references(q: Floats, references: Floats) -> Floats:
    """How far each joint (n,) [rad] is from the nearest place on the way of references (k, n)."""
    steps = np.diff(references, axis=0)
    squares = np.maximum((steps * steps).sum(axis=1), 1e-18)
    shares = np.clip(((q - references[:-1]) * steps).sum(axis=1) / squares, 0.0, 1.0)
    off = np.abs(references[:-1] + shares[:, None] * steps - q)
    return off[off.max(axis=1).argmin()]
