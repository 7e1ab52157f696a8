"""The solids of a cell as Pinocchio and Coal know them, and the pairs that can meet."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import product
from typing import Literal

import coal
import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Tool
from workbench.model.geometry import (
    Bools,
    Box,
    Capsule,
    Cylinder,
    Floats,
    Ints,
    Mesh,
    Shape,
    Solid,
    Sphere,
    frozen,
)
from workbench.model.scan import Detection
from workbench.model.tools.held_body import ball_label
from workbench.planning.collision.bounds import Boxes, box_of
from workbench.planning.kinematics.robot import Kinematics

BodyKind = Literal["link", "tool", "fixture", "bin", "assembled", "part"]


@dataclass(slots=True)
class Body:
    """One solid in the world.

    `owner` is the link, the arm (tools), the fixture, the kind of an assembled part, or the number
    of a part found; `arm` the index of the arm that carries it, -1 when none does; `finger` the
    travel direction of a finger in the frame of its joint, shape (3,).
    """

    label: str
    kind: BodyKind
    owner: str
    arm: int
    joint: int
    T_joint_body: pin.SE3
    shape: Shape
    finger: Floats | None = None

    @property
    def is_loose(self) -> bool:
        """Whether it is elsewhere in another phase: fingers open, parts are carried away."""
        return self.kind == "part" or self.finger is not None


def carried_bodies(cell: Cell, kinematics: Kinematics) -> list[Body]:
    """The robot itself: links, those that no arm moves among them, and tools, fingers closed."""
    links = [*_link_bodies(cell, kinematics), *_housing_bodies(cell, kinematics)]
    return [*links, *_tool_bodies(cell, kinematics)]


def obstacle_label(number: int) -> str:
    """How people see an obstacle of the scan named, `number` counted from 0."""
    return f"seen-{number + 1}"


def is_ball(body: Body) -> bool:
    """Whether a body is the ball that stands for what a hand holds."""
    return body.kind == "tool" and body.label == ball_label(body.owner)


def part_label(number: int) -> str:
    """How people see the part of detection `number` (counted from 0) named."""
    return f"part-{number + 1}"


def _link_bodies(cell: Cell, kinematics: Kinematics) -> list[Body]:
    carriers = _arm_of_joint(cell, kinematics)
    bodies: list[Body] = []
    for link in cell.robot.links:
        joint, T_joint_link = kinematics.frames[link.name]
        for solid in link.collision:
            carrier, T = _without_rotation(
                kinematics, joint, T_joint_link * solid.T_owner_shape, solid
            )
            bodies.append(
                Body(link.name, "link", link.name, carriers[joint], carrier, T, solid.shape)
            )
    return bodies


def _without_rotation(
    kinematics: Kinematics, joint: int, T_joint_body: pin.SE3, solid: Solid
) -> tuple[int, pin.SE3]:
    """The joint that really moves a body, and the body's pose in it.

    A round solid on the axis of its own revolute joint fills the same space at every angle of
    it: it hangs on the joint before.  Wrist flanges are such solids, and turning a wrist then
    needs no finer checks because of them.
    """
    model = kinematics.model
    if joint == 0 or not isinstance(solid.shape, Cylinder | Capsule):
        return joint, T_joint_body
    axis = kinematics.axes[joint]
    z, p = T_joint_body.rotation[:, 2], T_joint_body.translation
    if axis is None or np.linalg.norm(np.cross(axis, z)) > 1e-9:
        return joint, T_joint_body
    if np.linalg.norm(np.cross(axis, p)) > 1e-9:
        return joint, T_joint_body
    return int(model.parents[joint]), model.jointPlacements[joint] * T_joint_body


def _tool_bodies(cell: Cell, kinematics: Kinematics) -> list[Body]:
    bodies: list[Body] = []
    for index, arm in enumerate(cell.arms):
        joint, T_joint_flange = kinematics.frames[arm.flange]
        for solid in arm.tool.body:
            carrier, T = _without_rotation(
                kinematics, joint, T_joint_flange * solid.T_owner_shape, solid
            )
            bodies.append(
                Body(f"{arm.name} {solid.name}", "tool", arm.name, index, carrier, T, solid.shape)
            )
        for finger in arm.tool.fingers:
            solid, label = finger.solid, f"{arm.name} {finger.solid.name}"
            T = T_joint_flange * solid.T_owner_shape
            direction = T_joint_flange.rotation @ finger.direction
            bodies.append(Body(label, "tool", arm.name, index, joint, T, solid.shape, direction))
    return bodies


def _housing_bodies(cell: Cell, kinematics: Kinematics) -> list[Body]:
    """The housing of a scanner on an arm: like a link of its own behind the flange."""
    carrier = cell.scanner.on_arm
    if carrier is None:
        return []
    names = [arm.name for arm in cell.arms]
    joint, T_joint_flange = kinematics.frames[cell.arm(carrier.arm).flange]
    number, owner = names.index(carrier.arm), carrier.label
    return [
        Body(
            f"{carrier.arm} {solid.name}",
            "link",
            owner,
            number,
            joint,
            T_joint_flange * solid.T_owner_shape,
            solid.shape,
        )
        for solid in carrier.housing
    ]


def _arm_of_joint(cell: Cell, kinematics: Kinematics) -> list[int]:
    """For every joint of the model the arm that it belongs to, -1 for the world."""
    carriers = [-1] * kinematics.model.njoints
    for index, arm in enumerate(cell.arms):
        for name in arm.joints:
            carriers[kinematics.model.getJointId(name)] = index
    return carriers


def pairs_of(cell: Cell, bodies: list[Body]) -> Bools:
    """True (b, b) where two bodies can meet in some phase, upper triangle; no others are checked.

    Left out: bodies of one link or tool, or on the same joint, pairs that the SRDF disables; and
    still things among themselves, except parts, which may be carried.
    """
    owners = [_owner_of(body) for body in bodies]
    number = {name: k for k, name in enumerate(dict.fromkeys(owners))}
    owner = np.array([number[name] for name in owners])
    disabled = np.zeros((len(number), len(number)), bool)
    for (kind, name), a in number.items():
        # A link that has the name of a tool is the tool once more.
        if kind == "tool" and (b := number.get(("link", name))) is not None:
            disabled[a, b] = disabled[b, a] = True
    for pair in cell.robot.disabled_pairs:
        # Where a link has the name of a tool it is the tool, as another program writes it.
        first, second = ([number.get((kind, name)) for kind in ("link", "tool")] for name in pair)
        for a, b in product(first, second):
            if a is not None and b is not None:
                disabled[a, b] = disabled[b, a] = True
    if (carrier := cell.scanner.on_arm) is not None:
        # What is screwed to the flange touches it, even where a round flange hangs elsewhere.
        for link in cell.robot.rigid_with(cell.arm(carrier.arm).flange):
            a, b = (number.get(("link", name)) for name in (carrier.label, link))
            if a is not None and b is not None:
                disabled[a, b] = disabled[b, a] = True
    joint = np.array([body.joint for body in bodies])
    part = np.array([int(body.owner) if body.kind == "part" else -1 for body in bodies])
    meets = (joint[:, None] != joint) & (owner[:, None] != owner)
    meets &= ~disabled[owner[:, None], owner]
    is_part = part >= 0
    meets |= is_part[:, None] | is_part
    meets &= ~((part[:, None] == part) & is_part)
    return np.triu(meets, 1)


def _owner_of(body: Body) -> tuple[str, str]:
    """What a body belongs to; links and tools by the names that an SRDF has for them.

    A fixture or a tool may have the name of a link, and is something else all the same.
    """
    if is_ball(body):
        # It may meet the links that a tool never meets.
        return "held", body.owner
    match body.kind:
        case "tool":
            return body.kind, f"{body.owner}_tool"
        case "link" | "fixture" | "bin" | "assembled" | "part":
            return body.kind, body.owner


def _settle_box_size() -> None:
    """Have Coal take every box as large as it is, whatever is asked of it first.

    The first direction in which a process asks for a box's support decides, for good, whether
    boxes count as 1 + 1e-10 times their size: so if one of its components is zero (Coal's
    `getShapeSupport` of a box keeps that factor in a static).  Distances would then differ in
    their last digits between processes that did different things before.
    """
    R = np.array([[0.36, 0.48, -0.8], [-0.8, 0.6, 0.0], [0.48, 0.64, 0.6]])
    aslant = coal.Transform3s(R, np.array([0.01, 0.02, 0.03]))
    coal.distance(
        coal.Cylinder(0.02, 0.05),
        aslant,
        coal.Box(np.full(3, 0.1)),
        coal.Transform3s(np.eye(3), np.zeros(3)),
        coal.DistanceRequest(),
        coal.DistanceResult(),
    )


_settle_box_size()


@lru_cache(maxsize=4096)
def coal_shape(shape: Shape) -> coal.CollisionGeometry:
    """The Coal geometry of a shape; convex meshes become solid, others triangle trees.

    Shapes never change and nor does what is made of them here: one serves all worlds.
    """
    match shape:
        case Box():
            return coal.Box(np.array(shape.size))
        case Cylinder():
            return coal.Cylinder(shape.radius, shape.length)
        case Capsule():
            return coal.Capsule(shape.radius, shape.length)
        case Sphere():
            return coal.Sphere(shape.radius)
        case Mesh():
            points = coal.StdVec_Vec3s()
            for point in shape.points:
                points.append(np.array(point))
            triangles = coal.StdVec_Triangle()
            for i, j, k in shape.triangles.tolist():
                triangles.append(coal.Triangle(i, j, k))
            if shape.is_convex:
                return coal.Convex(points, triangles)
            tree = coal.BVHModelOBBRSS()
            tree.beginModel(len(shape.triangles), len(shape.points))
            tree.addSubModel(points, triangles)
            tree.endModel()
            return tree


def in_their_parts(bodies: Sequence[Body], detections: Sequence[Detection]) -> dict[int, pin.SE3]:
    """By number, the poses of the pieces of parts in the frame of their part."""
    return {
        number: detections[int(body.owner)].T_world_part.actInv(body.T_joint_body)
        for number, body in enumerate(bodies)
        if body.kind == "part"
    }


def are_rolled(
    bodies: Sequence[Body], detections: Sequence[Detection], first: Ints, second: Ints
) -> Bools:
    """Of pairs of bodies (k,), by number, whether one is the room of a part of unknown roll.

    No unit.
    """
    rolled = np.array(
        [body.kind == "part" and not detections[int(body.owner)].roll_known for body in bodies],
        bool,
    )
    return rolled[first] | rolled[second]


def geometry_of(bodies: Sequence[Body]) -> pin.GeometryModel:
    """The bodies where they are now, named by their numbers, without pairs."""
    geometry = pin.GeometryModel()
    for number, body in enumerate(bodies):
        shape = coal_shape(body.shape)
        geometry.addGeometryObject(
            pin.GeometryObject(f"{number}", body.joint, body.T_joint_body, shape)
        )
    return geometry


@lru_cache(maxsize=4096)
def extent(shape: Shape) -> tuple[Floats, Floats, float]:
    """Centre (3,) and half sizes (3,) [m] of the shape's box in its frame; radius [m] around it."""
    zero = frozen(np.zeros(3))
    match shape:
        case Box():
            half = frozen(np.asarray(shape.size) / 2)
            return zero, half, float(np.linalg.norm(half))
        case Sphere():
            return zero, frozen(np.full(3, shape.radius)), shape.radius
        case Cylinder():
            half = frozen([shape.radius, shape.radius, shape.length / 2])
            return zero, half, float(np.hypot(shape.radius, shape.length / 2))
        case Capsule():
            length = shape.length / 2 + shape.radius
            return zero, frozen([shape.radius, shape.radius, length]), length
        case Mesh():
            centre, half = box_of(shape.points)
            ball = np.linalg.norm(shape.points - centre, axis=1).max()
            return frozen(centre), frozen(half), float(ball)


def boxes_of(bodies: Sequence[Body]) -> Boxes:
    """The boxes around all bodies, each in the frame of the joint that carries it."""
    extents = [extent(body.shape) for body in bodies]
    poses = [body.T_joint_body for body in bodies]
    return Boxes(
        joint=np.array([body.joint for body in bodies]),
        R=np.array([T.rotation for T in poses]),
        c=np.array([T.act(e[0]) for T, e in zip(poses, extents, strict=True)]),
        half=np.array([half for _, half, _ in extents]),
        radius=np.array([radius for _, _, radius in extents]),
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
        """Its pose in the world at an opening [m] of its tool."""
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
