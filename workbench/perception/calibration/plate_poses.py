"""Poses of a held plate against an answer: where its balls are, and where they should be."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats

Answer = tuple[pin.SE3, pin.SE3]
"""`T_world_scanner` and `T_flange_plate`."""


@dataclass(frozen=True, slots=True, eq=False)
class PlatePose:
    """One pose: where the flange was, and the balls (3, 3) [m] in the scanner's frame.

    `at` (3,) [m] is the robot's flange in the world where another one counts as moving the plate.
    """

    name: str
    T_world_flange: pin.SE3
    balls: Floats
    is_used: bool = True
    at: Floats | None = None

    @property
    def hand(self) -> Floats:
        """The place (3,) [m] in the world about which the robot's errors turn the plate."""
        return self.T_world_flange.translation if self.at is None else self.at


def offsets(poses: Sequence[PlatePose], answer: Answer, centres: Floats) -> Floats:
    """By how much the balls are elsewhere than expected, (n, 3, 3) [m] in the world frame."""
    X, Y = answer
    on_flange = centres @ Y.rotation.T + Y.translation
    rows: list[Floats] = []
    for pose in poses:
        T = pose.T_world_flange
        expected = on_flange @ T.rotation.T + T.translation
        rows.append(pose.balls @ X.rotation.T + X.translation - expected)
    return np.array(rows)


def distances(poses: Sequence[PlatePose], answer: Answer, centres: Floats) -> Floats:
    """RMS over the balls of each pose (n,) [m]."""
    return np.sqrt((offsets(poses, answer, centres) ** 2).sum(axis=2).mean(axis=1))


def moved(answer: Answer, step: Floats) -> Answer:
    """Scanner and plate after a small motion (12,) [m, rad], each in its own frame."""
    return answer[0] * pin.exp6(step[:6]), answer[1] * pin.exp6(step[6:])


def slopes(poses: Sequence[PlatePose], answer: Answer, centres: Floats) -> Floats:
    """How `offsets` change with the small motion of `moved`, (n, 3, 3, 12) [m per m, m per rad]."""
    X, Y = answer
    found = np.empty((len(poses), 3, 3, 12))
    for number, pose in enumerate(poses):
        R = pose.T_world_flange.rotation @ Y.rotation
        found[number, :, :, :3] = X.rotation
        found[number, :, :, 3:6] = -X.rotation @ crosses(pose.balls)
        found[number, :, :, 6:9] = -R
        found[number, :, :, 9:] = R @ crosses(centres)
    return found


def crosses(vectors: Floats) -> Floats:
    """The matrices (n, 3, 3) of cross products with vectors (n, 3), in their unit."""
    x, y, z = vectors.T
    zero = np.zeros_like(x)
    return np.array([[zero, -z, y], [z, zero, -x], [-y, x, zero]]).transpose(2, 0, 1)
