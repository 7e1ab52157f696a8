"""Everything in a cell that has a shape, and where it is while a plan runs."""

from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.derived.assembling import assembled_kinds, rest_pose
from workbench.model.derived.by_bin import barriers
from workbench.model.geometry import Box, Cylinder, Floats, Mesh, Shape, Solid
from workbench.model.part import Part
from workbench.model.scan import Detection, Obstacle, Scene
from workbench.model.tools.held_body import ball_label
from workbench.proof.claims.tolerances import turns_for
from workbench.proof.engine.bodies import CheckedBody
from workbench.proof.engine.robot import Tree
from workbench.proof.engine.shapes import hull

ROUND_WITHIN = 3e-4
"""[m] A cylinder about the axis fills the same room at every turn where it needs no more than this
around it."""


def scene_bodies(cell: Cell, tree: Tree, scene: Scene) -> tuple[CheckedBody, ...]:
    """Links, tools, fixtures, the bin, the parts of the scene, and what else the scan shows."""
    robot = (*_links(cell, tree), *_housing(cell, tree), *_tools(cell, tree))
    return (*robot, *still_of(cell, scene), *_parts(cell, scene))


def _links(cell: Cell, tree: Tree) -> Iterator[CheckedBody]:
    arm_of = {tree.model.getJointId(joint): arm.name for arm in cell.arms for joint in arm.joints}
    tools = {_tool(arm): arm for arm in cell.arms}
    for link in cell.robot.links:
        joint, T_joint_link = tree.frames[link.name]
        # A link that has the name of a tool is that tool, as another program writes it.
        name = f"tool {link.name}" if link.name in tools else f"link {link.name}"
        for solid in link.collision:
            T = T_joint_link * solid.T_owner_shape
            yield CheckedBody(
                "link", link.name, name, arm_of.get(joint, ""), -1, joint, T, solid.shape
            )


def _tools(cell: Cell, tree: Tree) -> Iterator[CheckedBody]:
    for arm in cell.arms:
        joint, T_joint_flange = tree.flange(arm)
        name = f"tool {_tool(arm)}"
        for solid in arm.tool.body:
            label, T = f"{arm.name} {solid.name}", T_joint_flange * solid.T_owner_shape
            # What a hand may hold is no tool: it may meet the links that a tool never meets.
            of = f"held {arm.name}" if label == ball_label(arm.name) else name
            yield CheckedBody("tool", label, of, arm.name, -1, joint, T, solid.shape)
        for finger, slide in zip(arm.tool.fingers, tree.fingers[arm.name], strict=True):
            label, T = f"{arm.name} {finger.solid.name}", finger.solid.T_owner_shape
            yield CheckedBody("tool", label, name, arm.name, -1, slide, T, finger.solid.shape, True)


def _housing(cell: Cell, tree: Tree) -> Iterator[CheckedBody]:
    """What an arm carries of the scanner; it is compared like a link."""
    for arm in cell.arms:
        joint, T_joint_flange = tree.flange(arm)
        for solid in cell.scanner.housing_of(arm.name):
            label, T = f"{arm.name} {solid.name}", T_joint_flange * solid.T_owner_shape
            name = f"link {arm.name}_scanner"
            yield CheckedBody("link", label, name, arm.name, -1, joint, T, solid.shape)


def _tool(arm: Arm) -> str:
    """What a list of disabled pairs calls an arm's tool."""
    return f"{arm.name}_tool"


def still_of(cell: Cell, scene: Scene) -> Iterator[CheckedBody]:
    """Fixtures, the bin, and other objects in the scan."""

    def still(label: str, T: pin.SE3, solid: Solid) -> CheckedBody:
        return CheckedBody("still", label, "still", "", -1, 0, T * solid.T_owner_shape, solid.shape)

    for fixture in barriers(cell):
        for solid in fixture.solids:
            of_fixture = still(solid.name, fixture.T_world_fixture, solid)
            is_solid = any(fixture is known for known in cell.fixtures)
            yield replace(of_fixture, fixture=fixture.name, is_solid=is_solid)
    for solid in cell.bin.solids:
        yield replace(still(solid.name, cell.bin.T_world_bin, solid), is_solid=True)
    assembled = assembled_kinds(cell)
    for number, seen in enumerate(scene.obstacles):
        if seen.part in assembled:
            T_world_part = rest_pose(cell, seen)
            for piece in cell.part(seen.part).pieces:
                yield replace(still(seen.part, T_world_part, piece), of_kind=seen.part)
        else:
            box = Solid("box", Box(seen.size), pin.SE3.Identity())
            yield still(f"seen-{number + 1}", seen.T_world_box, box)


def _parts(cell: Cell, scene: Scene) -> Iterator[CheckedBody]:
    for number, detection in enumerate(scene.detections):
        label, part = f"part-{number + 1}", cell.part(detection.part)
        for piece in part.pieces:
            shape, T = piece.shape, detection.T_world_part * piece.T_owner_shape
            if not detection.roll_known:
                room, T_part_room = room_of(piece, roll_axis(part, detection))
                shape, T = room, detection.T_world_part * T_part_room
            yield CheckedBody(
                "part",
                label,
                label,
                "",
                number,
                0,
                T,
                shape,
                is_rolled=not detection.roll_known,
                of_kind=detection.part,
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


def filled_bin(cell: Cell, high: float, kinds: Iterable[str]) -> Obstacle:
    """A box that holds parts of these kinds in the bin however they lie: one on all, and upright.

    Without walls they may lie over the side, by a part's length; what rolls further is not in it.

    Args:
        cell: with the bin and the kinds.
        high: [m] how high the bin is full, from its floor.
        kinds: names of parts.
    """
    sizes = (np.ptp(cell.part(kind).mesh.points, axis=0) for kind in kinds)
    longest = max((float(np.linalg.norm(size)) for size in sizes), default=0.0)
    T_bin_box = pin.SE3(np.eye(3), np.array([0.0, 0.0, (high + longest) / 2]))
    beside = 0.0 if cell.bin.has_walls else 2 * longest
    size = np.array([*(cell.bin.size[:2] + beside), high + longest])
    return Obstacle(cell.bin.T_world_bin * T_bin_box, size)


def unseen_bin(cell: Cell) -> Obstacle:
    """A box that holds the bin's content before any scan: full to the rim, and a part upright."""
    return filled_bin(cell, float(cell.bin.size[2]), [part.name for part in cell.parts])


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
        max(room.radius - shape.radius, room.length - shape.length) < ROUND_WITHIN
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


def turned_rooms(part: Part, found: Detection) -> list[tuple[Cylinder, pin.SE3]]:
    """For each piece of a part the cylinder in the world that holds it at every turn."""
    axis = roll_axis(part, found)
    rooms = [room_of(piece, axis) for piece in part.pieces]
    return [(room, found.T_world_part * T_part_room) for room, T_part_room in rooms]
