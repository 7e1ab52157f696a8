"""Everything in a cell that has a shape, and where it is while a plan runs."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Literal

import coal
import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import (
    Box,
    Capsule,
    Cylinder,
    Floats,
    Mesh,
    Shape,
    Solid,
    Sphere,
    pieces_of,
)
from workbench.model.part import Part
from workbench.model.scan import Detection, Scene
from workbench.proof.robot import Tree
from workbench.proof.tolerances import turns_for

ALIKE = 3e-4
"""[m] A cylinder about the axis fills the same room at every turn where it needs no more than this
around it."""

Kind = Literal["link", "tool", "still", "part"]


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One shape.

    `label` is what people read, `name` what it is part of: two bodies of one name are never
    compared.  `arm` carries it, empty where none does.  `part` is the number of the detection, -1
    for what is none.  `joint` and `T_joint_body`: where it hangs as long as no hand holds it.
    `is_rolled`: it is the room of a piece of a part at every turn, since its roll is not known.
    """

    kind: Kind
    label: str
    name: str
    arm: str
    part: int
    joint: int
    T_joint_body: pin.SE3
    shape: Shape
    is_finger: bool = False
    is_rolled: bool = False


def bodies_of(cell: Cell, tree: Tree, scene: Scene) -> tuple[Body, ...]:
    """Links, tools, fixtures, the bin, the parts of the scene, and what else the scan shows."""
    return (*_links(cell, tree), *_tools(cell, tree), *still_of(cell, scene), *_parts(cell, scene))


def _links(cell: Cell, tree: Tree) -> Iterator[Body]:
    arm_of = {tree.model.getJointId(joint): arm.name for arm in cell.arms for joint in arm.joints}
    tools = {_tool(arm): arm for arm in cell.arms}
    for link in cell.robot.links:
        joint, T_joint_link = tree.frames[link.name]
        # A link that has the name of a tool is that tool, as another program writes it.
        name = f"tool {link.name}" if link.name in tools else f"link {link.name}"
        for solid in link.collision:
            T = T_joint_link * solid.T_owner_shape
            yield Body("link", link.name, name, arm_of.get(joint, ""), -1, joint, T, solid.shape)


def _tools(cell: Cell, tree: Tree) -> Iterator[Body]:
    for arm in cell.arms:
        joint, T_joint_flange = tree.flange(arm)
        name = f"tool {_tool(arm)}"
        for solid in arm.tool.body:
            label, T = f"{arm.name} {solid.name}", T_joint_flange * solid.T_owner_shape
            yield Body("tool", label, name, arm.name, -1, joint, T, solid.shape)
        for finger, slide in zip(arm.tool.fingers, tree.fingers[arm.name], strict=True):
            label, T = f"{arm.name} {finger.solid.name}", finger.solid.T_owner_shape
            yield Body("tool", label, name, arm.name, -1, slide, T, finger.solid.shape, True)


def _tool(arm: Arm) -> str:
    """What a list of disabled pairs calls an arm's tool."""
    return f"{arm.name}_tool"


def still_of(cell: Cell, scene: Scene) -> Iterator[Body]:
    """Fixtures, the bin, and what the scan shows beside the parts."""

    def still(label: str, T: pin.SE3, solid: Solid) -> Body:
        return Body("still", label, "still", "", -1, 0, T * solid.T_owner_shape, solid.shape)

    for fixture in cell.fixtures:
        for solid in fixture.solids:
            yield still(solid.name, fixture.T_world_fixture, solid)
    for solid in cell.bin.solids:
        yield still(solid.name, cell.bin.T_world_bin, solid)
    for number, seen in enumerate(scene.obstacles):
        shape = Box(seen.size)
        yield Body("still", f"seen-{number + 1}", "still", "", -1, 0, seen.T_world_box, shape)


def _parts(cell: Cell, scene: Scene) -> Iterator[Body]:
    for number, detection in enumerate(scene.detections):
        label, part = f"part-{number + 1}", cell.part(detection.part)
        for piece in part.pieces:
            shape, T = piece.shape, detection.T_world_part * piece.T_owner_shape
            if not detection.roll_known:
                room, T_part_room = room_of(piece, roll_axis(part, detection))
                shape, T = room, detection.T_world_part * T_part_room
            yield Body(
                "part", label, label, "", number, 0, T, shape, is_rolled=not detection.roll_known
            )


def roll_axis(part: Part, found: Detection) -> Floats:
    """The axis (2, 3) of a part about which its roll is not known: a point [m] and a direction.

    It is the detection's own; where that says none, the one that the part's symmetry is about.
    """
    axis = found.roll_axis
    return np.vstack([part.symmetry.point, part.symmetry.axis]) if axis is None else axis


def room_of(piece: Solid, axis: Floats) -> tuple[Cylinder, pin.SE3]:
    """The cylinder about an axis (2, 3) [m] that holds a piece however it is turned about it.

    Returns:
        It, and where it is in the frame of the part.
    """
    point, direction = axis
    shape, T = hull(piece.shape), piece.T_owner_shape
    points, box = shape.centre + shape.points, shape.box
    if isinstance(piece.shape, Mesh):
        points, box = np.asarray(piece.shape.points), np.zeros(3)
    corners = np.array(list(product((-1.0, 1.0), repeat=3))) * box
    points = (points[:, None] + corners).reshape(-1, 3) @ T.rotation.T + T.translation
    high = (points - point) @ direction
    away = np.linalg.norm(points - point - np.outer(high, direction), axis=1)
    lean = np.linalg.norm(np.cross(T.rotation[:, 2], direction))
    rise = shape.disc * lean + shape.ball
    low, top = float(high.min() - rise), float(high.max() + rise)
    radius = float(away.max()) + shape.disc + shape.ball
    R = pin.Quaternion.FromTwoVectors(np.array([0.0, 0.0, 1.0]), np.array(direction)).matrix()
    return Cylinder(radius, top - low), pin.SE3(R, point + direction * (low + top) / 2)


def roll_turns(part: Part, found: Detection) -> int:
    """At how many turns about its axis a part is checked: one where its roll is known."""
    if found.roll_known:
        return 1
    axis = roll_axis(part, found)
    uneven = [room.radius for piece, room in _rooms(part, axis) if not _fills(piece, room)]
    return turns_for(max(uneven, default=0.0))


def _rooms(part: Part, axis: Floats) -> list[tuple[Solid, Cylinder]]:
    return [(piece, room_of(piece, axis)[0]) for piece in part.pieces]


def _fills(piece: Solid, room: Cylinder) -> bool:
    """Whether a piece fills the same room at every turn."""
    shape = piece.shape
    return isinstance(shape, Cylinder) and (
        max(room.radius - shape.radius, room.length - shape.length) < ALIKE
    )


def turned_pieces(part: Part, found: Detection) -> list[list[tuple[Shape, pin.SE3]]]:
    """Each piece of a part as it may lie in the world: once, or at each of `roll_turns` turns.

    These are of a part whose roll is not known, and whose piece is not the same at all of them.
    """
    axis, count = roll_axis(part, found), roll_turns(part, found)
    angles = np.arange(count) * (2 * np.pi / count)
    every: list[list[tuple[Shape, pin.SE3]]] = []
    for piece, room in _rooms(part, axis):
        places: list[tuple[Shape, pin.SE3]] = []
        for angle in angles[: 1 if _fills(piece, room) else count]:
            R = pin.exp3(axis[1] * angle)
            turn = pin.SE3(R, axis[0] - R @ axis[0])
            places.append((piece.shape, found.T_world_part * turn * piece.T_owner_shape))
        every.append(places)
    return every


def is_round(body: Body, tree: Tree) -> bool:
    """Whether a body fills the same space however its joint is turned: a flange on its axis."""
    joint = tree.joints.get(body.joint)
    if joint is None or joint.kind != "revolute":
        return False
    if not isinstance(body.shape, Sphere | Cylinder | Capsule):
        return False
    R, at = body.T_joint_body.rotation, body.T_joint_body.translation
    is_alike = (
        isinstance(body.shape, Sphere) or np.linalg.norm(np.cross(joint.axis, R[:, 2])) < 1e-9
    )
    return bool(is_alike and np.linalg.norm(np.cross(joint.axis, at)) < 1e-9)


@dataclass(frozen=True, slots=True, eq=False)
class Hull:
    """A shape as a hull of points (m, 3) [m], seen from `centre` (3,) [m] in the shape's frame.

    Each point has a box of half lengths `box` (3,) [m], a disc across z of radius `disc` [m] and a
    ball of radius `ball` [m].  Around it all are a box of half lengths `half` (3,) [m] and a ball
    of a `radius` [m].
    """

    centre: Floats
    half: Floats
    radius: float
    points: Floats
    box: Floats
    disc: float = 0.0
    ball: float = 0.0


@lru_cache(maxsize=4096)
def hull(shape: Shape) -> Hull:
    """The hull of a shape."""
    zero, none = np.zeros(3), np.zeros((1, 3))
    match shape:
        case Box(size=size):
            half = np.asarray(size) / 2
            return Hull(zero, half, float(np.linalg.norm(half)), none, half)
        case Sphere(radius=radius):
            return Hull(zero, np.full(3, radius), radius, none, zero, ball=radius)
        case Cylinder(radius=radius, length=length):
            half = np.array([radius, radius, length / 2])
            box, far = np.array([0.0, 0.0, length / 2]), float(np.hypot(radius, length / 2))
            return Hull(zero, half, far, none, box, disc=radius)
        case Capsule(radius=radius, length=length):
            half = np.array([radius, radius, length / 2 + radius])
            box = np.array([0.0, 0.0, length / 2])
            return Hull(zero, half, radius + length / 2, none, box, ball=radius)
        case Mesh(points=points, is_convex=is_convex):
            centre = (points.max(axis=0) + points.min(axis=0)) / 2
            off = points - centre
            half, far = np.abs(off).max(axis=0), float(np.linalg.norm(off, axis=1).max())
            # What is hollow would hardly be told apart by its hull, whose points are many.
            return Hull(centre, half, far, *((off, zero) if is_convex else (none, half)))


@lru_cache(maxsize=4096)
def coal_shape(shape: Shape) -> coal.CollisionGeometry:
    """A shape as Coal measures it: convex ones as bodies, other meshes as their surface."""
    match shape:
        case Box(size=size):
            return coal.Box(np.array(size))
        case Sphere(radius=radius):
            return coal.Sphere(radius)
        case Cylinder(radius=radius, length=length):
            return coal.Cylinder(radius, length)
        case Capsule(radius=radius, length=length):
            return coal.Capsule(radius, length)
        case Mesh(points=points, triangles=triangles, is_convex=is_convex):
            if is_convex:
                # Coal walks along edges: no edge leads from one of two equal corners to the other.
                places, number = np.unique(points, axis=0, return_inverse=True)
                if len(places) < len(points):
                    points, triangles = places, number.ravel()[triangles]
            corners, faces = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
            for point in points:
                corners.append(np.array(point))
            for a, b, c in triangles.tolist():
                faces.append(coal.Triangle(a, b, c))
            if is_convex:
                return coal.Convex(corners, faces)
            surface = coal.BVHModelOBBRSS()
            surface.beginModel(len(triangles), len(points))
            surface.addSubModel(corners, faces)
            surface.endModel()
            return surface


Placed = tuple[Shape, pin.SE3]
"""A shape and its pose in the world."""


@dataclass(frozen=True, slots=True, eq=False)
class _Pieces:
    """The pieces of a shape; around each a box (n, 3) and a ball (n,) [m] in the shape's frame."""

    shapes: tuple[coal.CollisionGeometry, ...]
    centres: Floats
    halves: Floats
    radii: Floats


@lru_cache(maxsize=4096)
def _pieces(shape: Shape) -> _Pieces:
    pieces = pieces_of(shape)
    hulls = [hull(piece) for piece in pieces]
    return _Pieces(
        tuple(coal_shape(piece) for piece in pieces),
        np.array([convex.centre for convex in hulls]),
        np.array([convex.half for convex in hulls]),
        np.array([convex.radius for convex in hulls]),
    )


def is_divided(shape: Shape) -> bool:
    """Whether a shape only goes around pieces."""
    return isinstance(shape, Mesh) and len(shape.pieces) > 0


def measure(first: Placed, second: Placed) -> coal.DistanceResult:
    """How far two shapes are apart, where they are nearest: their pieces, where they have some."""
    (shape, T), (bed, U) = first, second
    mine, its = _pieces(shape), _pieces(bed)
    least = _apart_at_least(mine, its, T.actInv(U))
    at, where = (coal.Transform3s(pose.rotation, pose.translation) for pose in (T, U))
    best: coal.DistanceResult | None = None
    for k in np.argsort(least, axis=None):
        i, j = divmod(int(k), least.shape[1])
        if best is not None and least[i, j] >= best.min_distance:
            break
        found = coal.DistanceResult()
        coal.distance(mine.shapes[i], at, its.shapes[j], where, coal.DistanceRequest(), found)
        # What is no number is not far away.
        if best is None or not found.min_distance >= best.min_distance:
            best = found
    assert best is not None  # every shape has a piece
    return best


def _apart_at_least(pieces: _Pieces, other: _Pieces, T: pin.SE3) -> Floats:
    """How far pieces are apart at least (n, m) [m]: the box around each, the ball around the other.

    `T` is the pose of the other shape in the frame of the one.
    """
    theirs = other.centres @ T.rotation.T + T.translation
    ours = (pieces.centres - T.translation) @ T.rotation
    beside = np.maximum(np.abs(theirs - pieces.centres[:, None]) - pieces.halves[:, None], 0.0)
    besides = np.maximum(np.abs(ours[:, None] - other.centres) - other.halves, 0.0)
    return np.maximum(
        np.sqrt((beside**2).sum(axis=2)) - other.radii,
        np.sqrt((besides**2).sum(axis=2)) - pieces.radii[:, None],
    )


def gap_of(first: Placed, second: Placed, far: float = np.inf) -> float:
    """The distance [m] of two bodies in the world, negative inside; at least `far` beyond that."""
    (shape, T), (bed, U) = first, second
    around, about = hull(shape), hull(bed)
    offset = U.rotation.T @ (T.act(around.centre) - U.act(about.centre))
    apart = np.linalg.norm(np.maximum(np.abs(offset) - about.half, 0.0)) - around.radius
    if apart >= far:
        return float(apart)
    return float(measure(first, second).min_distance)


def _measure_aslant_first() -> None:
    """Let Coal fix, for this process, that boxes are as large as they are.

    The first direction in which it looks at a box decides if boxes count as 1 + 1e-10 times
    their size, if a component of it is zero: the last digits would depend on what came before.
    """
    turn = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    coal.distance(
        coal.Sphere(0.02),
        coal.Transform3s(turn, np.array([0.31, 0.27, 0.43])),
        coal.Box(np.full(3, 0.1)),
        coal.Transform3s(np.eye(3), np.zeros(3)),
        coal.DistanceRequest(),
        coal.DistanceResult(),
    )


_measure_aslant_first()
