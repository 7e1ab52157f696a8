"""The body that stands for what a hand holds where nobody knows how it is held, or what it is.

It is a ball about the TCP, in which any orientation has room.  A part touches the pads of the
fingers, or the cup, within `GRIP_ROOM` of the TCP: no point of it is farther from there than its
length, by whatever grip it was taken.  `ONE`: one part.  `TWO` and `UNKNOWN`: another part touches
the first one.  Fingers may be anywhere in their stroke: boxes hold them at every opening.  A tool
with several TCPs is refused: nobody knows which of them holds the part.
"""

import enum
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Finger, Tool
from workbench.model.geometry import Bools, Box, Floats, Mesh, Shape, Solid, Sphere
from workbench.model.load import Loads, tool_load, uniform_load
from workbench.model.messages.message import HELD_BODY, Message
from workbench.model.messages.refusals import Refusal

GRIP_ROOM = 0.01
"""[m] From the TCP to where a part touches the hand, at most."""

ON_TOP = 0.0001
"""[m] Between two boxes of which one stands on the other: no part reaches in there."""

ROUNDING = 1e-6
"""[m] By which one box may seem to stand out over another."""

UPRIGHT = 1.0 - 1e-9
"""The cosine of what leads up."""


class HeldAmount(enum.StrEnum):
    """What a person states of the hand."""

    ONE = "one"
    TWO = "two"
    UNKNOWN = "unknown"

    @property
    def parts(self) -> int:
        """How many parts that is; 0 where nobody knows."""
        return {HeldAmount.ONE: 1, HeldAmount.TWO: 2}.get(self, 0)


def largest_part(cell: Cell) -> tuple[float, float]:
    """The length [m] of the longest part and the mass [kg] of the heaviest one; 0 without any."""
    lengths = (part.mesh.diameter for part in cell.parts)
    return max(lengths, default=0.0), max((part.mass for part in cell.parts), default=0.0)


def kinds_problem(sent: tuple[float, float], cell: Cell) -> Message | None:
    """What speaks against a drop back in a cell that has lost the largest kind since.

    Args:
        sent: `largest_part` of the cell in which parts were sent for.
        cell: with the kinds that a hand is taken to hold.
    """
    is_as_large = all(now >= before for now, before in zip(largest_part(cell), sent, strict=True))
    return None if is_as_large else Refusal.DROP_KINDS()


def held_radius(cell: Cell, held: HeldAmount) -> float:
    """The radius [m] of the ball about the TCP that holds what the hand may hold."""
    longest, _ = largest_part(cell)
    return GRIP_ROOM + longest * (1 if held is HeldAmount.ONE else 2)


def held_mass(cell: Cell, held: HeldAmount) -> float:
    """The most [kg] that the hand may hold: the heaviest part, or two of it."""
    _, heaviest = largest_part(cell)
    return heaviest * (1 if held is HeldAmount.ONE else 2)


def held_loads(cell: Cell, arm_name: str, held: HeldAmount) -> Loads | None:
    """What an arm carries that drops back what its hand may hold.

    It is an even ball about the TCP, half as large as the one that holds a part.  It is as heavy as
    the heaviest part, or two of it.
    Returns None where the mass of the tool is not stated.
    """
    tool = cell.arm(arm_name).tool
    mine = tool_load(tool)
    if mine is None:
        return None
    ball = Solid(HELD_BODY, Sphere(held_radius(cell, HeldAmount.ONE) / 2), tool.T_flange_tcp)
    return Loads(mine, uniform_load((ball,), held_mass(cell, held)))


def with_held(cell: Cell, arm_name: str, held: HeldAmount) -> Cell:
    """The cell in which the tool of an arm is as large as all that its hand may hold.

    It is as heavy as with a second part; the first one counts by the leg.
    """
    arm = cell.arm(arm_name)
    ball = Solid(HELD_BODY, Sphere(held_radius(cell, held)), arm.tool.T_flange_tcp)
    around = (_swept(finger, arm.tool.stroke[1]) for finger in arm.tool.fingers)
    second = 0.0 if held is HeldAmount.ONE else held_mass(cell, HeldAmount.ONE)
    mass = None if arm.tool.mass is None else arm.tool.mass + second
    tool = replace(arm.tool, body=(*arm.tool.body, ball, *around), mass=mass)
    arms = (replace(a, tool=tool) if a.name == arm_name else a for a in cell.arms)
    return replace(cell, arms=tuple(arms))


def ball_label(arm_name: str) -> str:
    """What people call the ball in the hand of that arm."""
    return f"{arm_name} {HELD_BODY}"


def held_labels(cell: Cell) -> frozenset[str]:
    """What people call the bodies that `with_held` has added, by arm and name."""
    return frozenset(
        f"{arm.name} {solid.name}"
        for arm in cell.arms
        for solid in arm.tool.body
        if solid.name.startswith(HELD_BODY)
    )


def held_reach(cell: Cell) -> float:
    """How far [m] from the TCP any of these bodies reaches, in a cell that `with_held` has made."""
    labels = held_labels(cell)
    found = [0.0]
    for arm in cell.arms:
        T_tcp_flange = arm.tool.T_flange_tcp.inverse()
        for solid in arm.tool.body:
            if f"{arm.name} {solid.name}" in labels:
                T = T_tcp_flange * solid.T_owner_shape
                found.append(Solid(solid.name, solid.shape, T).reach)
    return max(found)


@dataclass(frozen=True, slots=True)
class _Upright:
    """A box of which one axis leads up: its outline seen from above, and its heights [m].

    `middle` (2,) [m] and `axes` (2, 2) without a unit are seen from above, `half` (2,) [m] along
    the axes.
    """

    middle: Floats
    axes: Floats
    half: Floats
    low: float
    top: float

    def covers(self, points: Floats, room: float) -> bool:
        """Whether points (n, 2) [m] are inside of the outline, this far [m] from its sides."""
        away = np.abs((points - self.middle) @ self.axes.T)
        return bool(np.all(away <= self.half - room))

    @property
    def corners(self) -> Floats:
        """Of the outline, (4, 2) [m]."""
        signs = np.array([(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)])
        return self.middle + (signs * self.half) @ self.axes


def stand_below(
    shapes: Sequence[tuple[Shape, pin.SE3]], p: Floats, reach: float, T_world_up: pin.SE3
) -> Bools:
    """Which solids of a cell a held body cannot touch while the hand moves straight up.

    The solids are floor, walls and fixtures, not boxes around objects in a scan.

    The body is in one piece, within `reach` of the TCP, and touches nothing yet.  Only a body under
    a box with upright sides can touch it.  The body is not under a box whose underside is at or
    below its lowest point.  The same holds for a box that stands fully on such a box.  Nor is the
    body under a box that covers all of its space from below: it would have to pass through.

    Args:
        shapes: the solids, with their poses in the world.
        p: (3,) [m] position of the TCP in the world at the start.
        reach: [m] largest distance of the body from the TCP.
        T_world_up: a frame whose z points up.

    Returns:
        Whether each cannot be touched (n,), no unit.
    """
    boxes = [_upright(shape, T_world_up.actInv(T)) for shape, T in shapes]
    x, y, high = T_world_up.actInv(np.asarray(p))
    at = np.array([[x, y]])
    under = (box.top for box in boxes if box and box.top < high and box.covers(at, reach))
    lowest = max(under, default=high - reach)
    lowest = max(lowest, high - reach)
    found = np.array([box is not None and box.low <= lowest + ON_TOP for box in boxes], bool)
    while True:
        more = [
            not known and box is not None and _stands_on_one(box, boxes, found)
            for box, known in zip(boxes, found.tolist(), strict=True)
        ]
        if not any(more):
            return found
        found = found | np.array(more)


def _stands_on_one(box: _Upright, boxes: Sequence[_Upright | None], among: Bools) -> bool:
    return any(
        other is not None
        and is_among
        and abs(other.top - box.low) <= ON_TOP
        and other.covers(box.corners, -ROUNDING)
        for other, is_among in zip(boxes, among.tolist(), strict=True)
    )


def _upright(shape: Shape, T_up_box: pin.SE3) -> _Upright | None:
    """A box seen from above; None of another shape, or where it leans."""
    if not isinstance(shape, Box):
        return None
    R, half = T_up_box.rotation, np.asarray(shape.size) / 2
    up = int(np.abs(R[2]).argmax())
    if abs(R[2, up]) < UPRIGHT:
        return None
    flat = [k for k in range(3) if k != up]
    middle, height = T_up_box.translation[:2], float(T_up_box.translation[2])
    low, top = height - float(half[up]), height + float(half[up])
    return _Upright(middle, R[:2, flat].T, half[flat], low, top)


def drop_problem(cell: Cell) -> Message | None:
    """Why no arm of a cell can drop back what it holds; None when one can."""
    motion = cell.controller.motion
    if motion.sends_poses or not motion.keeps_hand:
        return Refusal.DROP_NO_LINK(link=motion.link)
    return None if cell.parts else Refusal.DROP_NO_PARTS()


def recipe_problem(whole: Cell, cell: Cell) -> Message | None:
    """Why nobody knows what a hand holds in a cell by a recipe; None where it has all kinds."""
    left_out = sorted({part.name for part in whole.parts} - {part.name for part in cell.parts})
    return Refusal.DROP_RECIPE(parts=left_out) if left_out else None


def tool_problem(tool: Tool) -> Message | None:
    """Why nobody knows where a tool holds a part; None when that is known."""
    if len(tool.tcps) < 2:
        return None
    return Refusal.DROP_SEVERAL_TCPS(tool=tool.name, tcps=[tcp.name for tcp in tool.tcps])


def _swept(finger: Finger, widest: float) -> Solid:
    """A box, along the axes of a finger's shape, that holds it from closed to wide open [m]."""
    solid, T = finger.solid, finger.solid.T_owner_shape
    low, high = _extent(solid.shape)
    travel = T.rotation.T @ np.asarray(finger.direction) * (widest / 2)
    low, high = np.minimum(low, low + travel), np.maximum(high, high + travel)
    T_owner_box = T * pin.SE3(np.eye(3), (low + high) / 2)
    return Solid(f"{HELD_BODY}_{solid.name}", Box(high - low), T_owner_box)


def _extent(shape: Shape) -> tuple[Floats, Floats]:
    """The corners (3,) [m] of the box around a shape, in its frame."""
    if isinstance(shape, Mesh):
        points = np.asarray(shape.points)
        return points.min(axis=0), points.max(axis=0)
    if isinstance(shape, Box):
        half = np.asarray(shape.size) / 2
    elif isinstance(shape, Sphere):
        half = np.full(3, shape.radius)
    else:
        along = shape.length / 2 + (shape.radius if shape.kind == "capsule" else 0.0)
        half = np.array([shape.radius, shape.radius, along])
    return -half, half
