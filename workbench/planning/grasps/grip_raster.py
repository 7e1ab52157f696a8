"""All grips that a tool has on a part, on a fine raster: for bounds, filling, and searching plans.

Two fingers: pairs of points with opposite normals all over the surface, the hand from all sides and
more or less deep.  A cup: points all over the surface.  Where a hand fits among neighbours is for
`ToolCheck.free` to say, whether it holds for `Grips.grasp`.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import lru_cache
from itertools import islice

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.geometry import Bools, Floats, Ints
from workbench.model.part import Grasp, Part, widen_grasp
from workbench.model.scan import Detection
from workbench.planning.collision.hands import NO_PAIR, Hands
from workbench.planning.collision.world import World
from workbench.planning.grasps.grasp_check import GraspChecker
from workbench.planning.grasps.grasp_suggestions import opposite_points, sides
from workbench.planning.grasps.pads import Pads
from workbench.planning.grasps.part_rays import centre_of_mass, normals_of, samples_of

PAIRS, POINTS = 500, 2000
"""Points of the surface: that one finger touches, or a cup."""

HAND_SIDES, CUP_TURNS = 24, 8
"""Ways in which a hand comes to two points, and in which a cup is turned."""

DEPTHS = (0.001, 0.003, 0.006, 0.010, 0.015)
"""[m] How far beyond two points the finger tips reach."""

AIR = 0.0015
"""[m] Between each finger and the part on arrival."""

EXAMINED = 60
"""Grips of a batch that fit at a part and are checked whether they hold, in a search."""

CHOICE = 4
"""Grips that hold, for each that is wanted: those that hold best are taken."""

BATCH = 12_000
"""Grips among which some are searched before the next of them."""

TOGETHER = 500
"""Grips that are tried together; only a matter of speed."""

ALONE = 100.0
"""[m] A part this high above the cell is checked by itself."""

FOUND_PRIORITY = -1000
"""Of grips as grasps: behind all that a library may have."""

RINGS = 4
"""By how many distances from the centre of mass grips are ranked: nearer ones hold steadier."""


class Grips:
    """The grips of a tool on a part.

    `hands` are their ways, one each; the hand's poses are R (n, 3, 3) and p (n, 3) [m].
    They are weighed where an acceleration [m/s2] is given, see `GraspChecker`.

    Lifetime: as long as part and tool.
    """

    def __init__(self, part: Part, tool: Tool, acceleration: float | None = None):
        self._checker = GraspChecker(part, tool, acceleration)
        rng = np.random.default_rng(0)
        pads = self._checker.pads
        if pads is not None:
            R, p, closed = _pinches(self._checker, pads, rng)
        else:
            R, p = _touches(part, POINTS if self._checker.cup is not None else 0, rng)
            closed = np.zeros(len(p))
        self._R, self._p = R, p
        self._room = 2 * (part.tolerance or 0.0)
        T = tool.T_flange_tcp.inverse()
        high = tool.stroke[1]
        self.hands = Hands(
            np.arange(len(p) + 1),
            np.ascontiguousarray(R @ T.rotation),
            np.ascontiguousarray(p + R @ T.translation),
            np.column_stack([np.minimum(closed + 2 * AIR + self._room, high), closed]),
            np.zeros(len(p), np.int64),
            np.full((len(p), 2), NO_PAIR),
        )
        self._known: dict[int, Grasp | None] = {}
        self._remarks: dict[int, int] = {}
        centre = centre_of_mass(part.mesh)
        size = float(np.linalg.norm(np.ptp(part.mesh.points, axis=0))) / 2
        self._ring = np.floor(RINGS * np.linalg.norm(p - centre, axis=1) / size)

    def search(self, fit: Callable[[Hands], Bools], clear: Ints, most: int) -> tuple[Grasp, ...]:
        """Some grips that fit and hold the part, at most `most`; the same wherever the same fit.

        Args:
            fit: which of some hands (h,) fit where the part lies.
            clear: (n,) grips that are tried, see `clear_grips`.
            most: grips that are wanted.
        """
        found: list[int] = []
        order = np.random.default_rng(0).permutation(clear)
        for numbers in np.split(order, range(BATCH, len(order), BATCH)):
            free = self._first_fitting(fit, numbers)
            near_first = free[np.argsort(self._ring[free], kind="stable")].tolist()
            holding = (number for number in near_first if self.grasp(number) is not None)
            found += islice(holding, CHOICE * most - len(found))
            if len(found) >= most:
                break
        # Those that the check has no remark on hold better than those with one.
        found.sort(key=lambda number: self._remarks[number])
        return tuple(filter(None, map(self.grasp, found[:most])))

    def _first_fitting(self, fit: Callable[[Hands], Bools], numbers: Ints) -> Ints:
        """The first `EXAMINED` of some grips (n,) that fit."""
        free = numbers[:0]
        for some in np.split(numbers, range(TOGETHER, len(numbers), TOGETHER)):
            free = np.concatenate([free, some[fit(self.hands.some(some))]])
            if len(free) >= EXAMINED:
                break
        return free[:EXAMINED]

    def grasp(self, number: int) -> Grasp | None:
        """One as a grasp; None where it does not hold the part, or the tool cuts into it."""
        if number not in self._known:
            self._known[number] = self._check(number)
        return self._known[number]

    def _check(self, number: int) -> Grasp | None:
        T = pin.SE3(self._R[number], self._p[number])
        if self._checker.pads is not None:
            # From where the fingers arrive: one of them may do so inside of a hollow part.
            opening = float(self.hands.opening[number, 0])
            hold = self._checker.hold(T, opening)
            low, high = self._checker.tool.stroke
            if hold is None or max(hold.width, low) > high:
                return None
            T = T * pin.SE3(np.eye(3), hold.offset * self._checker.pads.travel)
            grip = max(hold.width, low)
            widths = max(min(grip + 2 * AIR, high - self._room), grip), grip
        else:
            widths = 0.0, 0.0
        grasp = Grasp(f"found-{number}", T, *widths, priority=FOUND_PRIORITY, is_found=True)
        check = self._checker.check(grasp)
        self._remarks[number] = len(check.findings)
        return widen_grasp(grasp, self._checker.part.tolerance) if check.is_ok else None


@lru_cache(maxsize=16)
def grips_of(part: Part, tool: Tool, acceleration: float | None = None) -> Grips:
    """The grips of a tool on a part, the same each time."""
    return Grips(part, tool, acceleration)


@lru_cache(maxsize=16)
def clear_grips(cell: Cell, part: Part, arm: Arm) -> Ints:
    """Numbers (n,) of the grips, no unit, of an arm's tool whose open fingers do not cut the part.

    Args:
        cell: with the arm.
        part: one of its parts.
        arm: whose tool.
    """
    grips = grips_of(part, arm.tool)
    if not arm.tool.fingers:
        return np.arange(len(grips.hands.turn))
    # What stands in the hand's way is the same part at the same place, far from all else.
    alone = Detection(part.name, pin.SE3(np.eye(3), np.array([0.0, 0.0, ALONE])))
    policy = replace(cell.policy, near_margin=0.0)
    check = World(cell, (alone, alone), (), policy).tool_check
    # Fingers that close shall meet the part.
    stay_open = grips.hands._replace(opening=grips.hands.opening[:, [0, 0]])
    return np.flatnonzero(check.free(arm, 0, stay_open))


def _pinches(
    checker: GraspChecker, pads: Pads, rng: np.random.Generator
) -> tuple[Floats, Floats, Floats]:
    """Hands around pairs of points: rotations (n, 3, 3), places (n, 3) [m], and widths (n,) [m]."""
    points, inward, widths, _ = opposite_points(checker, PAIRS, rng)
    middles = np.repeat(points + widths[:, None] / 2 * inward, HAND_SIDES, axis=0)
    z, y = sides(inward, HAND_SIDES).reshape(-1, 3), np.repeat(inward, HAND_SIDES, axis=0)
    R = np.stack([np.cross(y, z), y, z], axis=2) @ pads.R_tcp_closing.T
    return (
        np.concatenate([R] * len(DEPTHS)),
        np.concatenate([middles + depth * z for depth in DEPTHS]),
        np.tile(np.repeat(widths, HAND_SIDES), len(DEPTHS)),
    )


def _touches(part: Part, count: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Cups square on points: rotations (n, 3, 3) and places (n, 3) [m]."""
    points, triangles = samples_of(part.mesh, count, rng)
    normals, _ = normals_of(part.mesh)
    z = np.repeat(-normals[triangles], CUP_TURNS, axis=0)
    x = sides(normals[triangles], CUP_TURNS).reshape(-1, 3)
    return np.stack([x, np.cross(z, x), z], axis=2), np.repeat(points, CUP_TURNS, axis=0)
