"""One grip that works, made a family of grasps that a person can read: a pattern, with its tilt."""

from dataclasses import dataclass, field, replace

import numpy as np
import pinocchio as pin

from workbench.app.filling.round_bodies import RoundBody
from workbench.app.filling.work import GRIP, TRIANGLE, Work
from workbench.model.cell import Arm
from workbench.model.geometry import Bools, Floats
from workbench.model.part import (
    Entry,
    Grasp,
    GraspLibrary,
    GraspPattern,
    Part,
    grasps_of,
    widen_grasp,
)
from workbench.model.part import with_symmetry as multiplied
from workbench.model.scan import Detection
from workbench.planning.collision.hands import NO_PAIR, Hands
from workbench.planning.collision.legs import grips
from workbench.planning.collision.tool_check import ToolCheck
from workbench.planning.grasps.grasp_check import GraspCheck, GraspChecker
from workbench.planning.grasps.grasp_frames import PLAY
from workbench.planning.grasps.part_rays import centre_of_mass

AIR = 0.0015
"""[m] Between each finger and the part, where nothing else is said."""

TILTS = (np.deg2rad(45.0), np.deg2rad(30.0), np.deg2rad(15.0))
"""[rad] Tilts that are tried, the largest that holds is taken."""

TURN = np.deg2rad(15.0)
"""[rad] Between turns of a pattern about a round body."""

ROW_SPACING = 0.008
"""[m] Between places in a row, at least."""

MOST_IN_ROW = 5

FAMILY = 100
"""Grasps of a family, at most, those counted that the part's symmetry makes."""

COPIES = 40
"""Of a pattern that are checked: more of them are alike."""

NICE = np.deg2rad(24.0)
"""[rad] A hand that points this near to an axis, or square to it, does so, if that holds."""

PARALLEL_COSINE = 0.98
"""Cosine from which two directions are parallel."""

Pile = tuple[Detection, ...]
"""How parts lie."""


@dataclass(slots=True, eq=False)
class Family:
    """A library entry with all TCP poses by which a hand can take the part.

    Attributes:
        R: rotations of the TCP in the part's frame (w, 3, 3), with those of the part's symmetry.
        p: positions of the TCP in the part's frame (w, 3) [m].
        opening: opening of the fingers on arrival [m].
        grip: opening of the closed fingers [m].
        hands: the same poses as one grasp with many ways.
        took: parts that this entry has taken: the pile and the part's index in it.
    """

    entry: Entry
    R: Floats
    p: Floats
    opening: float
    grip: float
    hands: Hands
    took: list[tuple[Pile, int]] = field(default_factory=list[tuple[Pile, int]])

    def fits(self, tools: ToolCheck, arm: Arm, number: int) -> bool:
        """Whether the hand fits in any way at a part among its neighbours."""
        return bool(tools.free(arm, number, self.hands)[0])

    def free(self, tools: ToolCheck, arm: Arm, number: int) -> Bools:
        """Which of the ways (w,) fit there, no unit."""
        count = len(self.p)
        each = self.hands._replace(first=np.arange(count + 1))
        return tools.free(arm, number, each)

    def grasp(self, way: int) -> Grasp:
        """One of its ways as a grasp that leaves nothing free."""
        T = pin.SE3(self.R[way], self.p[way])
        return Grasp(self.entry.name, T, self.opening, self.grip)


def family_of(part: Part, arm: Arm, entry: Entry, least_air: float | None) -> Family:
    """The family of an entry; its fingers as little open as the policy lets them arrive."""
    alone = GraspLibrary((entry,))
    grasps = multiplied(alone, part.symmetry)
    first_grasp = widen_grasp(grasps[0], part.tolerance)
    opening = first_grasp.opening
    if least_air is not None and arm.tool.fingers:
        least = first_grasp.grip + 2 * (least_air + (part.tolerance or 0.0))
        opening = min(opening, max(least, arm.tool.stroke[0]))
    Ts = [grasp.T_part_tcp * T for grasp in grasps for T in grips(arm.tool, grasp)]
    R, p = np.array([T.rotation for T in Ts]), np.array([T.translation for T in Ts])
    F = arm.tool.T_flange_tcp.inverse()
    hands = Hands(
        np.array([0, len(Ts)]),
        np.ascontiguousarray(R @ F.rotation),
        np.ascontiguousarray(p + R @ F.translation),
        np.tile([opening, first_grasp.grip], (len(Ts), 1)),
        np.zeros(len(Ts), np.int64),
        np.full((len(Ts), 2), NO_PAIR),
    )
    return Family(entry, R, p, opening, first_grasp.grip, hands)


class Grower:
    """Makes families of single grips on a part by a tool.

    Lifetime: of one filling.
    """

    def __init__(
        self,
        checker: GraspChecker,
        bodies: tuple[RoundBody, ...],
        least_air: float | None,
        work: Work,
    ):
        self.part = checker.part
        self.checker = checker
        self.work = work
        self.centre = centre_of_mass(checker.part.mesh)
        # Where the policy lets fingers arrive less open, they may do so wider where there is room.
        self._air = AIR if least_air is None else max(PLAY, least_air)
        self._bodies = bodies

    def looked_at(self, T_part_tcp: pin.SE3) -> tuple[Grasp, GraspCheck] | None:
        """A grip as a grasp, and what is said of it; None where it does not hold the part."""
        if self.checker.pads is None:
            grasp = Grasp("", T_part_tcp, 0.0, 0.0, free_rotation=np.pi)
        else:
            hold = self.checker.hold(T_part_tcp)
            low, high = self.checker.tool.stroke
            if hold is None or max(hold.width, low) + 2 * AIR > high:
                return None
            T = T_part_tcp * pin.SE3(np.eye(3), hold.offset * self.checker.pads.travel)
            grip = max(hold.width, low)
            opening = min(grip + 2 * self._air, high - 1e-4)
            at = pin.SE3(T.rotation, np.round(T.translation, 4))
            grasp = Grasp("", at, float(np.ceil(opening * 1e4) / 1e4), round(grip, 4))
        check = self._check(grasp)
        return (grasp, check) if check.is_ok else None

    def extend(self, grasp: Grasp) -> Entry:
        """The entry that a grip is the first of: tilted, in a row, and around a round body."""
        axes = np.array([*(round_body.axis for round_body in self._bodies), *np.eye(3)])
        nice = _nice(grasp.T_part_tcp, axes)
        straight = None if nice is None else self.looked_at(nice)
        grasp = grasp if straight is None else straight[0]
        grasp = replace(grasp, tilt=self._tilt(grasp))
        row = np.array(grasp.T_part_tcp.rotation[:, 0])
        for body in self._bodies:
            angles = self._angles(grasp, body)
            is_along = abs(float(row @ body.axis)) > PARALLEL_COSINE
            offsets = self._offsets(grasp, np.array(body.axis)) if is_along else (0.0,)
            if len(angles) > 1 or is_along:
                pattern = GraspPattern(grasp, body.axis, angles, offsets, body.point)
                return grasp if pattern.count == 1 else self._whole(pattern)
        offsets = self._offsets(grasp, row) if self.checker.pads is not None else (0.0,)
        if len(offsets) == 1:
            return grasp
        return self._thin(GraspPattern(grasp, row, (0.0,), offsets, np.zeros(3)))

    def _check(self, grasp: Grasp) -> GraspCheck:
        self.work.add(GRIP + TRIANGLE * len(self.part.mesh.triangles))
        return self.checker.check(grasp)

    def _tilt(self, grasp: Grasp) -> float:
        """How far [rad] the hand may be tilted about the way of its fingers and still holds."""
        if self.checker.pads is None:
            return 0.0
        for tilt in TILTS:
            turned = [replace(grasp, T_part_tcp=grasp.T_part_tcp * T)
                      for T in (_about_y(tilt), _about_y(-tilt))]  # fmt: skip
            if all(self._check(turned_grasp).is_ok for turned_grasp in turned):
                return float(tilt)
        return 0.0

    def _holds(self, grasp: Grasp, motion: pin.SE3) -> bool:
        return self._check(replace(grasp, T_part_tcp=motion * grasp.T_part_tcp)).is_ok

    def _offsets(self, grasp: Grasp, axis: Floats) -> tuple[float, ...]:
        """Places along an axis [m] where the same grip holds, its own among them."""
        points = np.asarray(self.part.mesh.points) @ axis
        here = float(grasp.T_part_tcp.translation @ axis)
        low, high = float(points.min()) - here, float(points.max()) - here
        step = max(ROW_SPACING, round((high - low) / MOST_IN_ROW, 3))
        steps = np.arange(np.ceil(low / step), np.floor(high / step) + 1) * step
        return tuple(
            float(offset)
            for offset in steps
            if offset == 0.0 or self._holds(grasp, pin.SE3(np.eye(3), offset * axis))
        )

    def _angles(self, grasp: Grasp, body: RoundBody) -> tuple[float, ...]:
        """Turns [rad] about a round body at which the same grip holds, its own among them."""
        return tuple(
            float(angle)
            for angle in np.arange(round(body.period / TURN)) * TURN
            if angle == 0.0 or self._holds(grasp, body.turn_by(angle))
        )

    def _whole(self, pattern: GraspPattern) -> GraspPattern:
        """The pattern without the places at which it does not hold at all of its turns."""
        rng = np.random.default_rng(0)
        each = max(2, COPIES // len(pattern.offsets))
        offsets: list[float] = []
        for offset in pattern.offsets:
            copies = grasps_of(replace(pattern, offsets=(offset,)))
            some = rng.permutation(len(copies))[:each].tolist()
            if offset == 0.0 or all(self._check(copies[k]).is_ok for k in some):
                offsets.append(offset)
        return self._thin(replace(pattern, offsets=tuple(offsets)))

    def _thin(self, pattern: GraspPattern) -> GraspPattern:
        """The pattern with every other place, and then every other turn, until it is small."""
        while (
            len(multiplied(GraspLibrary((pattern,)), self.part.symmetry)) > FAMILY
            and pattern.count > 1
        ):
            if len(pattern.offsets) > 1:
                middle = pattern.offsets.index(0.0) % 2
                pattern = replace(pattern, offsets=pattern.offsets[middle::2])
            else:
                pattern = replace(pattern, angles=pattern.angles[::2])
        return pattern


def _nice(T: pin.SE3, axes: Floats) -> pin.SE3 | None:
    """The pose turned about the way of its fingers to point along one of some axes (n, 3).

    None where none is near, or it does so already.
    """
    z, y = T.rotation[:, 2], T.rotation[:, 1]
    flat = axes - (axes @ y)[:, None] * y
    lengths = np.linalg.norm(flat, axis=1)
    flat = flat[lengths > 0.2] / lengths[lengths > 0.2, None]
    flat = np.vstack([flat, np.cross(y, flat)])
    flat = np.vstack([flat, -flat])
    best = flat[int(np.argmax(flat @ z))]
    if not 1e-6 < np.arccos(np.clip(float(best @ z), -1.0, 1.0)) < NICE:
        return None
    return pin.SE3(np.column_stack([np.cross(y, best), y, best]), T.translation)


def _about_y(angle: float) -> pin.SE3:
    return pin.SE3(pin.exp3(np.array([0.0, angle, 0.0])), np.zeros(3))
