"""The tool alone, floating in the bin: no arm, so no inverse kinematics is needed.

Most candidates are refused here, so many poses of the hand are looked at in one compiled piece.
What a hand has to do with the part that it takes is the same wherever that lies: it is measured
once and remembered.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin
from numba import njit

from workbench.model.cell import Arm, Cell, Tool
from workbench.model.geometry import Floats, Ints, Solid
from workbench.model.part import Grasp, Part
from workbench.model.scan import Detection, Obstacle
from workbench.planning.collision.bodies import coal_shape, extent, still_bodies
from workbench.planning.collision.gjk import TOUCHES, Cores, cores_of, side
from workbench.planning.collision.legs import grips

NOTHING = np.iinfo(np.int64).max
"""In place of the number of a pair: none is too close."""

Met = tuple[tuple[str, str], float]
"""Labels of tool and obstacle, and their distance [m]."""


@dataclass(frozen=True, slots=True, eq=False)
class Hand:
    """A hand at a part: by which grasp, by which of its `grips`, and how far open [m].

    The tool may cut into the part to be taken, the detection `target`, by `press` [m].
    """

    target: int
    grasp: Grasp
    grip: int
    opening: float
    press: float


class ToolCheck:
    """What is around the tools of a cell, and what they would meet.

    Lifetime: as long as cell and detections.
    """

    def __init__(
        self,
        cell: Cell,
        detections: tuple[Detection, ...],
        obstacles: tuple[Obstacle, ...] = (),
    ):
        self._margin = cell.policy.near_margin
        self._parts = [cell.part(one.part) for one in detections]
        # The bin first: where the tool meets several things, that one is named.
        still = sorted(
            still_bodies(cell, detections, obstacles), key=lambda body: body.kind != "bin"
        )
        self._labels = [body.label for body in still]
        self._numbers = np.array([int(b.owner) if b.kind == "part" else -1 for b in still])
        self._shapes = [body.shape for body in still]
        self._geometry = [coal_shape(shape) for shape in self._shapes]
        poses = [body.T_joint_body for body in still]
        extents = [extent(shape) for shape in self._shapes]
        self._transforms = [coal.Transform3s(T.rotation, T.translation) for T in poses]
        self._R = np.array([T.rotation for T in poses])
        self._centres = np.array([T.act(e[0]) for T, e in zip(poses, extents, strict=True)])
        self._halves = np.array([half for _, half, _ in extents])
        self._around: dict[str, Around] = {}
        self._request = coal.DistanceRequest()
        self._tools = {arm.name: tool_shapes(arm.tool) for arm in cell.arms}

    def contact(
        self, arm: Arm, T_world_tcp: pin.SE3, opening: float, target: int, press: float
    ) -> Met | None:
        """The first obstacle closer to the tool than its margin, and its distance [m].

        The part to be taken has no margin; the tool may cut into it by `press` [m].
        """
        for number, tool in enumerate(self._tools[arm.name]):
            T = tool.at(arm.tool, T_world_tcp, opening)
            offset = np.einsum("gji,gj->gi", self._R, T.act(tool.centre) - self._centres)
            gap = np.linalg.norm(np.maximum(np.abs(offset) - self._halves, 0.0), axis=1)
            for g in np.flatnonzero(gap - tool.radius < self._margin):
                margin = -press if self._numbers[g] == target else self._margin
                found = self._measured(arm, T_world_tcp, opening, number, int(g))
                if found[1] < margin:
                    return found
        return None

    def contacts(
        self, arm: Arm, Ts_world_tcp: Sequence[pin.SE3], hands: Sequence[Hand]
    ) -> list[tuple[int, int] | None]:
        """As `contact` for many hands: the numbers of tool solid and obstacle that it names.

        Args:
            arm: whose tool.
            Ts_world_tcp: where its hand is, one for each hand.
            hands: at parts.
        """
        if not hands:
            return []
        around = self._around.get(arm.name)
        if around is None:
            around = self._around[arm.name] = self._surroundings(arm)
        targets = np.array([hand.target for hand in hands])
        if not around.cores.known.all():
            return [self._slowly(arm, T, h) for T, h in zip(Ts_world_tcp, hands, strict=True)]
        T_tcp_flange = arm.tool.T_flange_tcp.inverse()
        flanges = [T * T_tcp_flange for T in Ts_world_tcp]
        found = first_contacts(
            np.array([T.rotation for T in flanges]),
            np.array([T.translation for T in flanges]),
            np.array([hand.opening for hand in hands]),
            targets,
            self._margin,
            around,
        )
        count = len(self._shapes)
        for row, hand in enumerate(hands):
            own = _at_target(
                arm, self._parts[hand.target], hand.grasp, hand.grip, hand.opening, hand.press,
                self._margin,
            )  # fmt: skip
            if own is not None:
                pieces = np.flatnonzero(self._numbers == hand.target)
                found[row] = min(found[row], own[0] * count + pieces[own[1]])
        return [
            None if code == NOTHING else (int(code) // count, int(code) % count)
            for code in found.tolist()
        ]

    def told(self, arm: Arm, T_world_tcp: pin.SE3, opening: float, pair: tuple[int, int]) -> Met:
        """The labels and the distance [m] of a pair that `contacts` names."""
        return self._measured(arm, T_world_tcp, opening, *pair)

    def _slowly(self, arm: Arm, T_world_tcp: pin.SE3, hand: Hand) -> tuple[int, int] | None:
        """Where a body is not convex, so that compiled code does not know it."""
        met = self.contact(arm, T_world_tcp, hand.opening, hand.target, hand.press)
        if met is None:
            return None
        names = [tool.name for tool in self._tools[arm.name]]
        for pair in np.ndindex(len(names), len(self._labels)):
            if (f"{arm.name} {names[pair[0]]}", self._labels[pair[1]]) == met[0]:
                found = self._measured(arm, T_world_tcp, hand.opening, *pair)
                if found[1] == met[1]:
                    return pair
        raise AssertionError("a contact has a tool and an obstacle")

    def _measured(self, arm: Arm, T_world_tcp: pin.SE3, opening: float, number: int, g: int) -> Met:
        tool = self._tools[arm.name][number]
        T = tool.at(arm.tool, T_world_tcp, opening)
        distance = coal.distance(
            tool.geometry,
            coal.Transform3s(T.rotation, T.translation),
            self._geometry[g],
            self._transforms[g],
            self._request,
            coal.DistanceResult(),
        )
        return (f"{arm.name} {tool.name}", self._labels[g]), float(distance)

    def _surroundings(self, arm: Arm) -> "Around":
        tools = self._tools[arm.name]
        shapes = [tool.solid.shape for tool in tools] + self._shapes
        centres = np.array([extent(shape)[0] for shape in shapes])
        return Around(
            np.array([tool.T_flange_body.rotation for tool in tools]),
            np.array([tool.T_flange_body.act(tool.centre) for tool in tools]),
            np.array([tool.direction for tool in tools]),
            np.array([tool.radius for tool in tools]),
            self._R,
            self._centres,
            self._halves,
            self._numbers,
            cores_of(shapes, centres),
        )


@dataclass(frozen=True, slots=True, eq=False)
class ToolShape:
    """A solid of a tool: `direction` (3,) of its finger or zero; centre (3,) and radius [m]."""

    solid: Solid
    geometry: coal.CollisionGeometry
    T_flange_body: pin.SE3
    direction: Floats
    centre: Floats
    radius: float

    @property
    def name(self) -> str:
        """That of the solid."""
        return self.solid.name

    def at(self, tool: Tool, T_world_tcp: pin.SE3, opening: float) -> pin.SE3:
        """Where it is in the world, its tool being open so far [m]."""
        T = self.T_flange_body
        moved = pin.SE3(T.rotation, T.translation + self.direction * opening / 2)
        return T_world_tcp * tool.T_flange_tcp.inverse() * moved


@lru_cache(maxsize=64)
def tool_shapes(tool: Tool) -> tuple[ToolShape, ...]:
    """The solids of a tool, those that stand still first."""
    moving = [(finger.solid, np.asarray(finger.direction)) for finger in tool.fingers]
    fixed = [(solid, np.zeros(3)) for solid in tool.body]
    shapes: list[ToolShape] = []
    for solid, direction in fixed + moving:
        centre, _, radius = extent(solid.shape)
        geometry, T = coal_shape(solid.shape), solid.T_owner_shape
        shapes.append(ToolShape(solid, geometry, T, direction, centre, radius))
    return tuple(shapes)


@lru_cache(maxsize=16384)
def _at_target(
    arm: Arm, part: Part, grasp: Grasp, grip: int, opening: float, press: float, margin: float
) -> tuple[int, int] | None:
    """The first solid of the tool that cuts too deep into the part taken, and into which piece."""
    T_part_tcp = grasp.T_part_tcp * grips(arm, grasp)[grip]
    request, result = coal.DistanceRequest(), coal.DistanceResult()
    for number, tool in enumerate(tool_shapes(arm.tool)):
        T = tool.at(arm.tool, T_part_tcp, opening)
        transform = coal.Transform3s(T.rotation, T.translation)
        for piece, solid in enumerate(part.pieces):
            T_part_piece = solid.T_owner_shape
            centre, half, _ = extent(solid.shape)
            offset = T_part_piece.rotation.T @ (T.act(tool.centre) - T_part_piece.act(centre))
            gap = np.linalg.norm(np.maximum(np.abs(offset) - half, 0.0)) - tool.radius
            if gap >= margin:
                continue
            result.clear()
            distance = coal.distance(
                tool.geometry,
                transform,
                coal_shape(solid.shape),
                coal.Transform3s(T_part_piece.rotation, T_part_piece.translation),
                request,
                result,
            )
            if distance < -press:
                return number, piece
    return None


class Around(NamedTuple):
    """The solids of a tool (t, ...) seen from its flange, and what stands around it (s, ...) [m].

    `cores` are those of the tool's solids and then those of the rest; `owner` (s,) is the number of
    the part that a piece belongs to, -1 for others.
    """

    R_tool: Floats
    p_tool: Floats
    way: Floats
    radius: Floats
    R_still: Floats
    c_still: Floats
    half: Floats
    owner: Ints
    cores: Cores


@njit(cache=True)
def first_contacts(
    R_flange: Floats,
    p_flange: Floats,
    opening: Floats,
    target: Ints,
    margin: float,
    around: Around,
) -> Ints:
    """For each hand the number of its first pair nearer than the margin, or `NOTHING`.

    Args:
        R_flange: rotations (k, 3, 3) of the flanges.
        p_flange: their places (k, 3) [m].
        opening: (k,) [m] of the fingers.
        target: (k,) numbers of the parts that are taken: these are left out.
        margin: [m] that is kept.
        around: tool and surroundings.
    """
    tools, still = len(around.radius), len(around.owner)
    R, c = np.empty((tools + still, 3, 3)), np.empty((tools + still, 3))
    W = np.empty((5, 3))
    for g in range(still):
        for i in range(3):
            c[tools + g, i] = around.c_still[g, i]
            for j in range(3):
                R[tools + g, i, j] = around.R_still[g, i, j]
    found = np.empty(len(opening), np.int64)
    for k in range(len(opening)):
        found[k] = NOTHING
        for t in range(tools):
            for i in range(3):
                place = p_flange[k, i]
                for j in range(3):
                    way = around.p_tool[t, j] + around.way[t, j] * opening[k] / 2.0
                    place += R_flange[k, i, j] * way
                    turn = 0.0
                    for m in range(3):
                        turn += R_flange[k, i, m] * around.R_tool[t, m, j]
                    R[t, i, j] = turn
                c[t, i] = place
        for t in range(tools):
            if found[k] != NOTHING:
                break
            for g in range(still):
                if around.owner[g] == target[k]:
                    continue
                gap = 0.0
                for i in range(3):
                    along = 0.0
                    for j in range(3):
                        along += around.R_still[g, j, i] * (c[t, j] - around.c_still[g, j])
                    out = max(abs(along) - around.half[g, i], 0.0)
                    gap += out * out
                if np.sqrt(gap) - around.radius[t] >= margin:
                    continue
                if side(t, tools + g, R, c, around.cores, margin, margin, W) == TOUCHES:
                    found[k] = t * still + g
                    break
    return found
