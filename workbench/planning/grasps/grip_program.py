"""The linear program of a grip: how much force on a part its contacts hold, in one direction.

Each pad presses evenly or more on one side, as an elastic layer does (Winkler); friction under it
takes a force and a torque up to its limit surface: Goyal, Ruina and Papadopoulos, "Planar sliding
with dry friction, part 1: limit surface and moment function", Wear 143, 1991.
"""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from workbench.model.geometry import Floats

LEAST_RADIUS = 0.001
"""[m] Of what a pad touches, so that a point has a scale, too."""

UNBOUNDED = 3
"""What SciPy says of a program without an end."""


@dataclass(frozen=True, slots=True, eq=False)
class Touch:
    """Where a pad, or a cup's lip, touches a part, in the TCP frame.

    `points` (n, 3) [m] with the share `weights` (n,) of the pressure on each where it is pressed
    straight; `inward` (3,), unit, is how it presses on the part, `closing` (3,) how it travels as
    it closes.
    """

    points: Floats
    weights: Floats
    inward: Floats
    closing: Floats


@dataclass(frozen=True, slots=True, eq=False)
class Contacts:
    """All that holds a part: touches, the `force` [N], the `friction`, no unit.

    `pull` (3,) [N] is the vacuum's on the part, at the TCP; None where fingers close by `force`.
    """

    touches: tuple[Touch, ...]
    force: float
    friction: float
    pull: Floats | None = None


class GripProgram:
    """The linear program of a grip: the unknowns are six numbers a touch, and the load.

    A touch has the pressure, even and along both sides [N]; and the force of friction along both
    [N] and its torque about the normal, over the touch's radius [N].
    """

    def __init__(self, contacts: Contacts):
        count = 6 * len(contacts.touches) + 1
        balance, limits = np.zeros((7, count)), list[Floats]()
        for number, touch in enumerate(contacts.touches):
            own = slice(6 * number, 6 * number + 6)
            block, rows = _touch(touch, contacts.friction)
            balance[:6, own] = block
            balance[6, own] = touch.closing @ block[:3]
            wide = np.zeros((len(rows), count))
            wide[:, own] = rows
            limits.append(wide)
        self._limits = np.vstack(limits)
        right = np.zeros(7)
        if contacts.pull is None:
            right[6] = len(contacts.touches) * contacts.force
        else:
            right[:3] = -contacts.pull
            balance = balance[:6]
        self._balance, self._right = balance, right[: len(balance)]

    def most(self, way: Floats, centre: Floats) -> tuple[float, Floats]:
        """The most force [N] along `way` (3,), no unit, at `centre` (3,) [m] that is held.

        Beside it the normal (3,), unit, of the side of all forces that are held, there.
        """
        from scipy.optimize import linprog  # takes a while to import

        balance = self._balance.copy()
        balance[:3, -1], balance[3:6, -1] = way, np.cross(centre, way)
        goal = np.zeros(balance.shape[1])
        goal[-1] = -1.0
        bounds = [(None, None)] * (len(goal) - 1) + [(0.0, None)]
        # Lengths in mm, so that rows for torques weigh as much as those for forces.
        scale = np.ones(len(balance))
        scale[3:6] = 1000.0
        found = linprog(
            goal,
            self._limits,
            np.zeros(len(self._limits)),
            balance * scale[:, None],
            self._right * scale,
            bounds,
            method="highs-ds",
        )
        if found.x is None:
            # What presses a part onto a cup has no end; a grip may also hold nothing at all.
            return (np.inf if found.status == UNBOUNDED else 0.0), way
        dual = np.asarray(found.eqlin.marginals) * scale
        side = dual[:3] + np.cross(dual[3:6], centre)
        length = float(np.linalg.norm(side))
        return float(found.x[-1]), side / length if length > 0 else way


def _touch(touch: Touch, friction: float) -> tuple[Floats, Floats]:
    """What a touch brings (6, 6) by its unknowns, and what must not be above 0 (m, 6)."""
    n, points, weights = touch.inward, touch.points, touch.weights
    e1 = np.linalg.svd(n[None])[2][1]
    e2 = np.cross(n, e1)
    middle = weights @ points
    flat = (points - middle) @ np.column_stack([e1, e2])
    radius = max(float(np.linalg.norm(flat, axis=1).max()), LEAST_RADIUS)
    spread = np.column_stack([np.ones(len(points)), flat / radius])
    pressure = weights[:, None] * spread
    block = np.zeros((6, 6))
    block[:3, :3] = n[:, None] * pressure.sum(axis=0)
    block[3:, :3] = np.cross(points, n).T @ pressure
    for column, e in ((3, e1), (4, e2)):
        block[:3, column], block[3:, column] = e, np.cross(middle, e)
    block[3:, 5] = n * radius
    rows = [np.column_stack([-spread, np.zeros((len(points), 3))])]
    for slide in _slides():
        x, y, turn = slide
        speeds = np.hypot(x - turn * flat[:, 1] / radius, y + turn * flat[:, 0] / radius)
        rows.append(np.concatenate([-friction * speeds @ pressure, slide])[None])
    found: Floats = np.vstack(rows).astype(np.float64)
    return block, found


def _slides() -> Iterator[Floats]:
    """Ways (3,) in which a pad may slide and turn, unit: those that its limit surface is cut by."""
    for height, count in ((0.0, 16), (0.5, 12), (0.87, 8), (1.0, 1)):
        for turn in sorted({height, -height}):
            for angle in np.arange(count) * 2 * np.pi / count:
                flat = np.sqrt(1 - turn**2)
                yield np.array([flat * np.cos(angle), flat * np.sin(angle), turn])
