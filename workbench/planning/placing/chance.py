"""Distance of a placed part from its target pose, and the chance that it is within tolerance."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats, frozen, own, put
from workbench.model.part import Part, PartPlace
from workbench.model.scan import Detection
from workbench.model.symmetry import BALL, ROUND, SAME_TURN
from workbench.planning.collision.unknown_rolls import axis_of

DRAWS = 20_000
"""Random errors drawn for a distribution."""

CONFIDENCE = 0.95
"""Confidence level of the reported placing error."""


@dataclass(frozen=True, slots=True, eq=False)
class Counted:
    """What of an error makes a difference, in the part's frame.

    The error is that of `point` (3,) [m] of the part, and of its turn.  Turns about the axes `free`
    (k, 3), no unit, change nothing; they are made perpendicular to each other.
    """

    point: Floats
    free: Floats

    def __post_init__(self) -> None:
        _, sizes, across = np.linalg.svd(self.free.reshape(-1, 3), full_matrices=False)
        own(self, "point")
        put(self, free=frozen(across[sizes > 1e-09]))

    def off(self, errors: Floats) -> tuple[Floats, Floats]:
        """How far the part is shifted (n,) [m] and turned (n,) [rad].

        Args:
            errors: (n, 6) [m, rad] shifts of its origin, then turns, along axes of the part.
        """
        turns = errors[:, 3:]
        shifts = errors[:, :3] + np.cross(turns, self.point)
        for axis in self.free:
            turns = turns - np.outer(turns @ axis, axis)
        return np.linalg.norm(shifts, axis=1), np.linalg.norm(turns, axis=1)


def select_counted(part: Part, detection: Detection, place: PartPlace | None) -> Counted:
    """What makes a difference of a part that is to lie at a place, None: somewhere.

    Turns about the axis of a part that is round do not; nor those about one about which its roll is
    not known, since such parts are put only where that does not matter; nor those about z of a
    place at which it may be turned all around.
    """
    symmetry, point = part.symmetry, np.zeros(3)
    if symmetry.form == BALL:
        return Counted(np.array(symmetry.point), np.eye(3))
    free: list[Floats] = []
    if symmetry.form == ROUND:
        point = symmetry.invariant_point(point)
        free.append(np.asarray(symmetry.axes[0].axis))
    elif not detection.roll_known:
        through, axis = axis_of(part, detection)
        point = through + ((point - through) @ axis) * axis
        free.append(axis)
    if place is not None and place.free_rotation >= np.pi - SAME_TURN:
        free.append(np.array([0.0, 0.0, 1.0]))
    return Counted(point, np.array(free))


def draw_errors(covariance: Floats, count: int, seed: int | Sequence[int]) -> Floats:
    """Errors (count, 6) [m, rad] of a covariance (6, 6), the same ones for each `seed`."""
    normal = np.random.default_rng(seed).standard_normal((count, 6))
    # The root that is symmetric: others depend on how a machine turns the axes.
    values, axes = np.linalg.eigh(covariance)
    return normal @ ((axes * np.sqrt(np.maximum(values, 0.0))) @ axes.T)


def within(off: tuple[Floats, Floats], place: PartPlace) -> float:
    """The share of parts this far off (n,) [m] and (n,) [rad] that a place takes as right, 0..1."""
    shifts, turns = off
    return float(np.mean((shifts <= place.tolerance) & (turns <= place.turn_tolerance)))
