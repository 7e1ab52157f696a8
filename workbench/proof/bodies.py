"""Everything in a cell that has a shape, and where it is while a plan runs."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache
from typing import Literal

import coal
import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Box, Capsule, Cylinder, Floats, Mesh, Shape, Solid, Sphere
from workbench.model.scan import Scene
from workbench.proof.robot import Tree

Kind = Literal["link", "tool", "still", "part"]


@dataclass(frozen=True, slots=True, eq=False)
class Body:
    """One shape.

    `label` is what people read, `name` what it is part of: two bodies of one name are never
    compared.  `arm` carries it, empty where none does.  `part` is the number of the detection, -1
    for what is none.  `joint` and `T_joint_body`: where it hangs as long as no hand holds it.
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


def bodies_of(cell: Cell, tree: Tree, scene: Scene) -> tuple[Body, ...]:
    """Links, tools, fixtures, the bin, the parts of the scene, and what else the scan shows."""
    return (*_links(cell, tree), *_tools(cell, tree), *_still(cell, scene))


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


def _still(cell: Cell, scene: Scene) -> Iterator[Body]:
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
    for number, one in enumerate(scene.detections):
        label = f"part-{number + 1}"
        for piece in cell.part(one.part).pieces:
            T = one.T_world_part * piece.T_owner_shape
            yield Body("part", label, label, "", number, 0, T, piece.shape)


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


@lru_cache(maxsize=4096)
def ball(shape: Shape) -> tuple[Floats, float]:
    """Centre (3,) [m] in the shape's frame, and radius [m], of a ball around it."""
    zero = np.zeros(3)
    match shape:
        case Box(size=size):
            return zero, float(np.linalg.norm(size)) / 2
        case Sphere(radius=radius):
            return zero, radius
        case Cylinder(radius=radius, length=length):
            return zero, float(np.hypot(radius, length / 2))
        case Capsule(radius=radius, length=length):
            return zero, radius + length / 2
        case Mesh(points=points):
            centre = (points.max(axis=0) + points.min(axis=0)) / 2
            return centre, float(np.linalg.norm(points - centre, axis=1).max())


@lru_cache(maxsize=4096)
def box(shape: Shape) -> tuple[Floats, Floats]:
    """Centre (3,) and half lengths (3,) [m] of the box around a shape, along its own axes."""
    zero = np.zeros(3)
    match shape:
        case Box(size=size):
            return zero, np.asarray(size) / 2
        case Sphere(radius=radius):
            return zero, np.full(3, radius)
        case Cylinder(radius=radius, length=length):
            return zero, np.array([radius, radius, length / 2])
        case Capsule(radius=radius, length=length):
            return zero, np.array([radius, radius, length / 2 + radius])
        case Mesh(points=points):
            high, low = points.max(axis=0), points.min(axis=0)
            return (high + low) / 2, (high - low) / 2


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


def _measure_aslant_first() -> None:
    """Let Coal fix, for this process, that boxes are as large as they are.

    The first direction in which it looks at a box decides whether boxes count as 1 + 1e-10 times
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
