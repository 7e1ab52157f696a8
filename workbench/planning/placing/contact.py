"""What closing fingers do to a part that is not quite where it is thought to be.

All errors are small motions of the part (6,) [m, rad]: that of the point of it at the TCP, then
turns, along the closing axes: x across the pads, y along the fingers' travel, z along the tool.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import pinocchio as pin

from workbench.model.geometry import Floats, Mesh, frozen, own, put
from workbench.planning.grasps.grasp_check import FRICTION, GraspChecker
from workbench.planning.grasps.part_rays import normals_of

TURN_TRIED = float(np.deg2rad(2.0))
"""[rad] Turns by which it is tried what the fingers meet."""

LYING_DIRECTIONS = 6
"""Axes across the travel about which the part may lie flat on the pads, over half a turn."""

UPRIGHT = LYING_DIRECTIONS // 2
ANGLES = np.arange(LYING_DIRECTIONS) * np.pi / LYING_DIRECTIONS
LYING_AXES = np.column_stack([np.cos(ANGLES), np.zeros(LYING_DIRECTIONS), np.sin(ANGLES)])
"""They themselves (n, 3), the one along the tool at `UPRIGHT`; no unit."""

BORNE = 0.0005
"""[m] A part is borne by what is no higher above its lowest point."""

STEEP = 0.5
"""Fingers whose travel is less level than this cosine do not push a part along what it lies on."""

PLAY, ALIGNED = 1e-4, float(np.deg2rad(0.5))
"""[m] Deviation along the travel of what is gripped, and [rad] about axes about which it was turned
flat: friction holds the last of it."""

UPWARDS = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True, slots=True, eq=False)
class Grip:
    """What becomes of an error as the hand closes: `error -> keeps @ error`.

    `keeps` (6, 6) [m, rad] is linear.  `turns` (k, 6) [m/rad, no unit] are the motions by which the
    hand turns the part flat, each by one radian: what it takes out about them it takes out nearly.
    `play` [m] is the deviation of what it holds along the fingers' travel.
    """

    keeps: Floats
    turns: Floats
    play: float = PLAY

    def __post_init__(self) -> None:
        own(self, "keeps")
        put(self, turns=frozen(self.turns).reshape(-1, 6))

    def covariance(self, before: Floats) -> Floats:
        """What the grip itself adds (6, 6) [m, rad] to an error of a covariance (6, 6)."""
        along = np.zeros(6)
        along[1] = self.play
        found = np.outer(along, along)
        for turn in self.turns:
            axis = np.concatenate([np.zeros(3), turn[3:]])
            found += min(ALIGNED**2, float(axis @ before @ axis)) * np.outer(turn, turn)
        return found


def cup_grip() -> Grip:
    """What a suction cup takes out: nothing but what lifts a flat face off its lip.

    The part is drawn to the lip, along the tool and about both axes across it.
    """
    return Grip(np.diag([1.0, 1.0, 0.0, 0.0, 0.0, 1.0]), np.eye(6)[3:5], play=0.0)


def finger_grip(checker: GraspChecker, T_part_tcp: pin.SE3, T_world_part: pin.SE3) -> Grip:
    """What two fingers take out of the error of a part that lies on something level.

    First one of them pushes it until the other meets it, too.  That takes out the error along the
    travel; as it is pushed beside its middle the part swivels, and where it lies round it rolls.
    Then both turn it until faces lie flat on the pads, unless friction holds it as it is: that is
    so where the faces are shorter than the part is wide, times the friction (Nguyen, Constructing
    force-closure grasps, 1988: each pad's push goes through the friction cone of the other).

    Args:
        checker: of the part and a tool with pads.
        T_part_tcp: of the grasp.
        T_world_part: how it lies.
    """
    assert checker.pads is not None
    R_tcp_closing = np.asarray(checker.pads.R_tcp_closing)
    T_part_closing = T_part_tcp * pin.SE3(R_tcp_closing, np.zeros(3))
    felt = _Felt(checker, T_part_tcp, R_tcp_closing)
    if felt.width is None:
        return Grip(np.eye(6), np.empty((0, 6)), play=0.0)
    along = felt.along()
    way = _push(checker.part.mesh, T_part_closing, T_world_part, felt.lengths[UPRIGHT])
    way /= along @ way
    keeps = np.eye(6) - np.outer(way, along)
    # About the middle of the faces: what is between the fingers stays in their middle.
    turns = [np.array([0.0, -along[3:] @ axis, 0.0, *axis]) for axis in felt.alignment_axes()]
    for turn in turns:
        keeps = keeps - np.outer(turn, turn[3:] @ keeps[3:])
    return Grip(keeps, np.array(turns))


class _Felt:
    """What the fingers meet of a part that is turned a little in the hand."""

    def __init__(self, checker: GraspChecker, T_part_tcp: pin.SE3, R_tcp_closing: Floats):
        self._checker, self._T_tcp_part, self._R = checker, T_part_tcp.inverse(), R_tcp_closing
        nominal = self._hold(np.array([1.0, 0.0, 0.0]), 0.0)
        self.width, self._middle = (None, 0.0) if nominal is None else nominal

    def _hold(self, axis: Floats, angle: float) -> tuple[float, float] | None:
        """Width [m] and middle along the travel [m] after a turn about an axis through the TCP."""
        turn = pin.SE3(pin.exp3(self._R @ axis * angle), np.zeros(3))
        hold = self._checker.hold((turn * self._T_tcp_part).inverse())
        return None if hold is None else (hold.width, hold.offset)

    def along(self) -> Floats:
        """By how much the middle of what is between the fingers is off, for each error (6,)."""
        found = np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
        for k in (0, 2):
            forward, backward = (
                self._hold(np.eye(3)[k], angle) for angle in (TURN_TRIED, -TURN_TRIED)
            )
            if forward is not None and backward is not None:
                found[3 + k] = (forward[1] - backward[1]) / (2 * TURN_TRIED)
        return found

    def _length(self, axis: Floats) -> float:
        """How much wider [m/rad] a turn about an axis makes what is between the fingers."""
        assert self.width is not None
        holds = [self._hold(axis, angle) for angle in (TURN_TRIED, -TURN_TRIED)]
        return min(0.0 if hold is None else (hold[0] - self.width) / TURN_TRIED for hold in holds)

    @cached_property
    def lengths(self) -> Floats:
        """How long (n,) [m] what both fingers touch is across each of the axes `LYING_AXES`."""
        assert self._checker.pads is not None
        # Rays do not see the rims of faces: half a cell at each end.
        step = self._checker.pads.grid.step
        found = np.array([self._length(axis) for axis in LYING_AXES])
        return np.where(found > step, found + step, 0.0)

    def alignment_axes(self) -> Floats:
        """Axes (k, 3) across the travel about which the pads turn the part flat; no unit."""
        assert self.width is not None
        # What touches is as short as it is along its own axes: a corner's way across is no help.
        shortest = int(np.argmin(self.lengths))
        across = (shortest + LYING_DIRECTIONS // 2) % LYING_DIRECTIONS
        least = self.width * np.tan(FRICTION)
        return LYING_AXES[[k for k in (shortest, across) if self.lengths[k] > least]]


def _push(mesh: Mesh, T_part_closing: pin.SE3, T_world_part: pin.SE3, length: float) -> Floats:
    """How the part goes as one finger pushes it along the travel (6,), of whatever length.

    What it lies on is level, and bears it where the part is lowest.

    Args:
        mesh: the part's.
        T_part_closing: the TCP with the closing axes.
        T_world_part: how it lies.
        length: [m] of what touches the pad: a push anywhere in it goes as it must for the part not
            to swivel.
    """
    T_world_closing = T_world_part * T_part_closing
    travel = T_world_closing.rotation[:, 1]
    level = travel - (travel @ UPWARDS) * UPWARDS
    cosine = float(np.linalg.norm(level))
    if cosine < STEEP:
        return np.array([0.0, 1.0, 0.0, 0.0, 0.0, 0.0])
    level /= cosine
    sideways = np.cross(UPWARDS, level)
    _, areas = normals_of(mesh)
    middle = areas @ mesh.points[mesh.triangles].mean(axis=1) / areas.sum()
    points = (mesh.points - middle) @ T_world_part.rotation.T
    from_middle = T_world_closing.translation - T_world_part.act(middle)
    beside = float(from_middle @ sideways)
    arm = float(np.sign(beside)) * max(abs(beside) - length / 2, 0.0)
    borne = points[points[:, 2] < points[:, 2].min() + BORNE, :2]
    # Evenly, but so that it does not topple: what lies far from its middle bears less of it.
    loads = np.linalg.pinv(np.vstack([np.ones(len(borne)), borne.T]))[:, 0]
    square = max(float(loads @ (borne**2).sum(axis=1)), BORNE**2)
    # As on a film of oil, which is where friction holds least.
    turn = -arm / (arm**2 + square) * UPWARDS
    shift = square / (arm**2 + square)
    if _is_round(points, sideways):
        turn = turn + sideways * shift / -float(points[:, 2].min())
    R_closing_world = T_world_closing.rotation.T
    found = np.zeros(6)
    found[:3] = R_closing_world @ (shift * level + np.cross(turn, from_middle))
    found[3:] = R_closing_world @ turn
    return found


def _is_round(points: Floats, axis: Floats) -> bool:
    """Whether a part rolls about a level axis (3,) rather than slides on what it lies on.

    It slides where lifting its middle takes more force than friction does (points (n, 3) [m] from
    its middle).
    """
    height = -float(points[:, 2].min())
    risen: list[float] = []
    for angle in (TURN_TRIED, -TURN_TRIED):
        turned = points @ pin.exp3(axis * angle)[2]
        risen.append((-float(turned.min()) - height) / TURN_TRIED)
    # The pad rubs on the part as it rolls, at about the same distance from what it rolls about.
    friction = float(np.tan(FRICTION))
    return max(map(abs, risen)) < friction * (1.0 - friction) * height
