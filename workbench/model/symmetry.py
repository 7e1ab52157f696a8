"""The turns that leave a part as it is: any finite group of rotations, or a round one.

A group is stated by axes through one point.  Together with all their products the turns about them
are it: two axes across each other make D-n or D-infinity, two round ones a ball's; three-fold
axes over the corners of a cube the groups of the regular bodies.
"""

from dataclasses import dataclass, field

import numpy as np
import pinocchio as pin

from workbench.model.digest import LATER
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, own, put

ANY_TURN = float(np.deg2rad(30.0))
"""[rad] A part that looks alike at any turn is taken at turns this far apart."""

MOST_FOLD = 360

MOST_TURNS = 720
"""Axes whose products are more than these make no group: they are stated wrongly."""

SAME_TURN = float(np.deg2rad(0.3))
"""[rad] Rotations and axes that differ by less are one."""

NONE, ROUND, BALL = "", "round", "ball"
"""Whether any turn about the axis, or any at all, changes nothing."""


@dataclass(frozen=True, slots=True, eq=False)
class SymmetryAxis:
    """An axis (3,), a unit vector, with its `fold`: see `Symmetry`; no unit."""

    axis: Floats
    fold: int

    def __post_init__(self) -> None:
        own(self, "axis")


@dataclass(frozen=True, slots=True, eq=False)
class Symmetry:
    """The group of rotations that the turns about some axes make.

    `axis` (3,) is a unit vector.  `fold` 1: none; n: turns of 360/n degrees; 0: any angle.  `point`
    [m] is where all axes meet, `also` are the other ones.
    """

    axis: Floats = field(default_factory=lambda: np.array([0.0, 0.0, 1.0]))
    fold: int = 1
    point: tuple[float, float, float] = field(default=(0.0, 0.0, 0.0), metadata=LATER)
    also: tuple[SymmetryAxis, ...] = field(default=(), metadata=LATER)

    def __post_init__(self) -> None:
        x, y, z = map(float, self.point)
        own(self, "axis")
        put(self, point=(x, y, z))

    @property
    def axes(self) -> tuple[SymmetryAxis, ...]:
        """Those with turns, the one with the most first, which is the main one."""
        every = (SymmetryAxis(self.axis, self.fold), *self.also)
        return tuple(
            sorted(
                (axis for axis in every if axis.fold != 1), key=lambda axis: -axis.fold or -np.inf
            )
        )

    @property
    def is_none(self) -> bool:
        """Whether every turn makes a difference."""
        return not self.axes

    @property
    def form(self) -> str:
        """`ROUND` or `BALL` where turns by any angle change nothing, `NONE` elsewhere."""
        if self.is_none or self.axes[0].fold != 0:
            return NONE
        main, *others = self.axes
        for other_axis in others:
            cosine = abs(float(main.axis @ other_axis.axis))
            if cosine < np.cos(SAME_TURN) and not (
                other_axis.fold == 2 and cosine < np.sin(SAME_TURN)
            ):
                return BALL
        return ROUND

    @property
    def others(self) -> Floats:
        """Rotations (k, 3, 3), no unit: all turns about the main axis after each make the group.

        The identity is the first.

        Raises:
            InputError: the axes make no group.
        """
        found = [np.eye(3)]
        if self.is_none or self.form == BALL:
            return np.array(found)
        main = self.axes[0]
        steps = [turn_about(axis.axis, 2 * np.pi / axis.fold) for axis in self.axes if axis.fold]
        about = np.array([turn_about(main.axis, angle) for angle in _angles(main.fold, 1)])
        for known in found:  # grows meanwhile
            for step in steps:
                new = known @ step
                if main.fold == 0:
                    is_known = any(float(main.axis @ (new @ R.T) @ main.axis) > np.cos(SAME_TURN)
                                   for R in found)  # fmt: skip
                else:
                    cosines = (np.einsum("nij,kij->nk", about @ new, np.array(found)) - 1) / 2
                    is_known = bool(cosines.max() > np.cos(SAME_TURN))
                if not is_known:
                    found.append(new)
                    if len(found) * len(about) > MOST_TURNS:
                        raise InputError(
                            f"the axes of a symmetry make more than {MOST_TURNS} turns: "
                            "is one of them stated wrongly?"
                        )
        return np.array(found)

    @property
    def turns(self) -> tuple[tuple[str, pin.SE3], ...]:
        """The motions of the group except for the identity, each with a name.

        Where any angle changes nothing, they stand for all, `ANY_TURN` apart; those of a
        dodecahedron stand for those of a ball.
        """
        if self.is_none:
            return ()
        group = _dodecahedron() if self.form == BALL else self
        main = group.axes[0]
        angles = _angles(main.fold, round(2 * np.pi / ANY_TURN))
        named = [
            (f"{np.rad2deg(angle):.0f}" + (f"+{k}" if k else ""), turn_about(main.axis, angle) @ R)
            for k, R in enumerate(group.others)
            for angle in angles
        ]
        return tuple((name, self._about_point(R)) for name, R in named[1:])

    def motions(self, steps: int) -> Floats:
        """The motions (k, 4, 4) of the group, the identity first; any angle as equal steps.

        The lengths are in m.  Of a ball the turns of a dodecahedron are returned.
        """
        group = _dodecahedron() if self.form == BALL else self
        if self.is_none:
            return np.eye(4)[None]
        main = group.axes[0]
        about = [turn_about(main.axis, angle) for angle in _angles(main.fold, steps)]
        return np.array([self._about_point(R @ S).homogeneous for S in group.others for R in about])

    def invariant_point(self, p: Floats) -> Floats:
        """The point (3,) [m] nearest to another, (3,) [m], that no turn moves."""
        point, axes = np.array(self.point), self.axes
        if not axes:
            return np.array(p)
        main = axes[0].axis
        if all(abs(float(main @ axis.axis)) >= np.cos(SAME_TURN) for axis in axes):
            return point + float((p - point) @ main) * main
        return point

    def check(self) -> None:
        """Whether it can be one.

        Raises:
            InputError: an axis is no unit vector, a fold is none, or no group comes of them.
        """
        for axis in (SymmetryAxis(self.axis, self.fold), *self.also):
            length = float(np.linalg.norm(axis.axis))
            if not 0 <= axis.fold <= MOST_FOLD or not abs(length - 1.0) <= 1e-6:
                raise InputError(
                    f"symmetry: a unit axis and 0 to {MOST_FOLD} turns are needed, "
                    f"not {axis.fold} about {axis.axis}"
                )
        if not np.isfinite(self.point).all():
            raise InputError("symmetry: its point is no place")
        _ = self.others

    def __str__(self) -> str:
        """Its usual name, as far as it has a short one."""
        if self.is_none:
            return "none"
        if self.form == BALL:
            return "sphere"
        count, main = len(self.others), self.axes[0]
        fold = "-inf" if main.fold == 0 else str(main.fold)
        if count == 1:
            return f"C{fold}"
        if count == 2 and float(main.axis @ self.others[1] @ main.axis) < 0:
            return f"D{fold}"
        return f"{count * main.fold} turns"

    def _about_point(self, R: Floats) -> pin.SE3:
        point = np.array(self.point)
        return pin.SE3(R, point - R @ point)


def turn_about(axis: Floats, angle: float) -> Floats:
    """The rotation (3, 3), no unit, by an angle [rad] about an axis (3,) of unit length."""
    return np.array(pin.AngleAxis(angle, np.array(axis)).matrix())


def make_turn(axis: Floats, angle: float, through: Floats | None = None) -> pin.SE3:
    """The turn by `angle` [rad] about an axis (3,) through a point (3,) [m], or the origin."""
    R = turn_about(axis, angle)
    return pin.SE3(R, np.zeros(3) if through is None else through - R @ through)


def _angles(fold: int, steps: int) -> Floats:
    count = fold or steps
    return np.arange(count) * 2 * np.pi / count


def _dodecahedron() -> Symmetry:
    """The sixty turns that stand for those of a ball."""
    golden = (1 + np.sqrt(5)) / 2
    five = np.array([0.0, 1.0, golden]) / np.sqrt(1 + golden**2)
    return Symmetry(five, 5, also=(SymmetryAxis(np.ones(3) / np.sqrt(3), 3),))
