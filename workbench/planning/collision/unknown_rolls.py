"""Parts whose roll nobody knows: the room of all turns about their axis counts in their place.

Only as they come off what they lie on the room says too little, since it is in touch with that:
there the part itself is checked, turn after turn.
"""

from functools import lru_cache

import numpy as np
import pinocchio as pin

from workbench.model.geometry import (
    Box,
    Capsule,
    Cylinder,
    Floats,
    Mesh,
    Shape,
    Solid,
    Sphere,
    pose_from_rpy,
)
from workbench.model.part import Part
from workbench.model.scan import Detection
from workbench.model.symmetry import make_turn

FEWEST_TURNS, TURN_SPACING = 24, 0.001
"""A part is checked at least at this many turns; [m] the most that a point may be from where it is
at the nearest one."""

ROUND_WITHIN = 3e-4
"""[m] A cylinder that needs no more room than this around it fills the same at every turn."""

Placed = tuple[tuple[Shape, pin.SE3], ...]
"""A piece of a part as it may lie in the world: once, or at several turns."""


def room_of(part: Part, detection: Detection) -> tuple[Solid, ...]:
    """The pieces of a part that was found; of one whose roll is unknown the room of all turns.

    Each piece becomes the smallest cylinder about the axis that holds it at every turn.

    Args:
        part: of the detection's name.
        detection: whose `roll_known` and axis count, not where it lies.
    """
    if detection.roll_known:
        return part.pieces
    return _rooms(part, axis_of(part, detection).tobytes())


def axis_of(part: Part, detection: Detection) -> Floats:
    """A point [m] and the unit direction (2, 3) of the axis of a detection, in the part's frame."""
    if detection.roll_axis is not None:
        return detection.roll_axis
    return np.array([part.symmetry.point, part.symmetry.axis])


def turns_about(axis: Floats, count: int = FEWEST_TURNS) -> tuple[pin.SE3, ...]:
    """Turns about an axis (2, 3) [m], see `axis_of`, in equal steps, none at all first."""
    point, direction = axis
    angles = np.arange(count) * 2 * np.pi / count
    return tuple(make_turn(direction, float(angle), point) for angle in angles)


def place_pieces(part: Part, detection: Detection) -> tuple[Placed, ...]:
    """Each piece of a part where it lies; where its roll is unknown, at every turn."""
    T, rooms = detection.T_world_part, room_of(part, detection)
    turns = [pin.SE3.Identity()]
    if not detection.roll_known:
        uneven = [
            room.shape.radius
            for piece, room in zip(part.pieces, rooms, strict=True)
            if isinstance(room.shape, Cylinder) and not _is_round(piece, room)
        ]
        count = int(np.ceil(np.pi * max(uneven, default=0.0) / TURN_SPACING))
        turns = list(turns_about(axis_of(part, detection), max(count, FEWEST_TURNS)))
    return tuple(
        tuple(
            (piece.shape, T * turn * piece.T_owner_shape)
            for turn in (turns[:1] if _is_round(piece, room) else turns)
        )
        for piece, room in zip(part.pieces, rooms, strict=True)
    )


def _is_round(piece: Solid, room: Solid) -> bool:
    mine, theirs = piece.shape, room.shape
    return (
        isinstance(mine, Cylinder)
        and isinstance(theirs, Cylinder)
        and theirs.radius - mine.radius < ROUND_WITHIN
        and theirs.length - mine.length < ROUND_WITHIN
    )


@lru_cache(maxsize=256)
def _rooms(part: Part, axis: bytes) -> tuple[Solid, ...]:
    point, direction = np.frombuffer(axis).reshape(2, 3)
    return tuple(_room(piece, point, direction) for piece in part.pieces)


def _room(piece: Solid, point: Floats, direction: Floats) -> Solid:
    T = piece.T_owner_shape
    centres, out, rise = _balls(piece.shape, T.rotation.T @ direction)
    at = centres @ T.rotation.T + T.translation - point
    along = at @ direction
    radius = float(np.linalg.norm(at - along[:, None] * direction, axis=1).max()) + out
    low, high = float(along.min()) - rise, float(along.max()) + rise
    R = _upright(direction)
    middle = point + (low + high) / 2 * direction
    return Solid(piece.name, Cylinder(radius, high - low), pin.SE3(R, middle), piece.colour)


def _balls(shape: Shape, direction: Floats) -> tuple[Floats, float, float]:
    """Points (k, 3) [m] of a shape, and how far [m] it reaches from them across and along (3,)."""
    match shape:
        case Box(size=size):
            signs = np.stack(np.meshgrid(*[[-0.5, 0.5]] * 3), axis=-1).reshape(-1, 3)
            return signs * np.asarray(size), 0.0, 0.0
        case Mesh(points=points):
            return np.asarray(points), 0.0, 0.0
        case Sphere(radius=radius):
            return np.zeros((1, 3)), radius, radius
        case Capsule(radius=radius, length=length):
            return np.array([[0, 0, -length / 2], [0, 0, length / 2]]), radius, radius
        case Cylinder(radius=radius, length=length):
            leaning = float(np.sqrt(max(0.0, 1.0 - direction[2] ** 2)))
            ends = np.array([[0, 0, -length / 2], [0, 0, length / 2]])
            return ends, radius, radius * leaning


def _upright(direction: Floats) -> Floats:
    """A rotation (3, 3), no unit, whose z is a unit vector (3,)."""
    x, y, z = direction
    pitch, yaw = np.arctan2(np.hypot(x, y), z), np.arctan2(y, x)
    return pose_from_rpy((0.0, 0.0, 0.0), (0.0, pitch, yaw)).rotation
