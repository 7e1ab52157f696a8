"""A gripper's URDF or xacro file to a tool: its body, two fingers or a lip, stroke and TCP.

Fingers of a cell move straight, those of linkages swing.  So a tool made here is a little larger
than such a gripper: of each finger the last link moves, and holds all places of its own that are
off its straight path.  What moves behind it counts as body, at all its places at once.
"""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.formats.grippers.jaws import LEAST_STROKE, Jaws, MovingLink, nearest_axis
from workbench.formats.meshes.pieces.convex_pieces import hull_of
from workbench.formats.meshes.triangles import surface_of
from workbench.formats.robots.descriptions import Description
from workbench.formats.robots.urdf_joints import Follower
from workbench.formats.robots.urdf_package import simplify_robot
from workbench.model.cell import Finger, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Mesh, Solid, transform
from workbench.model.robot import Link, Robot

COARSE = "_sc"
"""Ending of names of links that are a coarse model of another one, for self-collision."""

OPENINGS_TRIED = 33
"""Openings at which it is looked where the links are."""

LEAST_MOTION = 1e-6
"""[m] A link whose points move less is of the body."""

PIECE_TOLERANCE, MOST_PIECES = 0.003, 8
"""[m] By how much a convex piece of the body may be too large, and how many a mesh may have."""

LIP, PRESS = 0.001, 0.003
"""[m] Within `LIP` of its end a suction tool has its lip, which gives way by `PRESS`."""

GREY, DARK = (0.55, 0.57, 0.6), (0.25, 0.26, 0.3)


def gripper_of(
    found: Description, name: str, widest: float | None = None
) -> tuple[Tool, tuple[str, ...]]:
    """The tool that a description is of, its root link on the flange, and what was decided.

    One of which nothing moves sucks.

    Args:
        found: of the gripper alone.
        name: of the tool.
        widest: [m] it is never opened further; None: as far as the tips of a linkage come forward
            by no more than `MOST_SWING` as they close.

    Raises:
        InputError: it has no solids, or does not move like a gripper with two fingers.
    """
    robot, _ = simplify_robot(
        _without_coarse(found.robot), tolerance=PIECE_TOLERANCE, most=MOST_PIECES
    )
    leaders = [joint.name for joint in robot.joints if joint.kind != "fixed"]
    _check_followers(found.followers, name)
    if not leaders:
        return _suction(robot, name)
    if len(leaders) > 2:
        raise InputError(
            f"gripper {name}: {len(leaders)} joints move on their own ({', '.join(leaders)}); "
            "one or two are expected, and <mimic> for those that follow"
        )
    ways = [_moved(robot, found.followers, leaders, ends) for ends in _ends(robot, leaders)]
    if not any(ways):
        return _suction(robot, name)
    whole = max((Jaws.of(moving, name) for moving in ways), key=lambda jaws: jaws.stroke[1])
    low, high = whole.stroke
    if high - low < LEAST_STROKE:
        raise InputError(f"gripper {name}: its fingers do not move apart along a line")
    if widest is not None and widest - low < LEAST_STROKE:
        raise InputError(
            f"gripper {name}: it opens by {1000 * low:.1f} to {1000 * high:.1f} mm, so --widest-mm "
            f"is more than {1000 * (low + LEAST_STROKE):.0f}"
        )
    jaws = whole.within(widest)
    if jaws.stroke[1] - jaws.stroke[0] < LEAST_STROKE:
        raise InputError(
            f"gripper {name}: straight fingers cannot stand for its own, which swing; --widest-mm "
            "takes them as far as it says"
        )
    return _made(robot, jaws, name), (*found.notes, *jaws.notes)


def _check_followers(followers: Sequence[Follower], name: str) -> None:
    """Refuse joints that follow each other in a circle."""
    leaders = {follower.joint.name: follower.leader for follower in followers}
    for joint in leaders:
        at = joint
        for _ in followers:
            at = leaders.get(at, "")
        if at in leaders:
            raise InputError(f"gripper {name}: joint {joint} mimics itself")


def tool_name(found: Description) -> str:
    """A name for the tool of a description: that of its robot, as names of tools are written."""
    return re.sub(r"[^A-Za-z0-9_-]", "_", found.robot.name)[:60]


def _without_coarse(robot: Robot) -> Robot:
    """The robot without the solids of links that only stand for others, as `hand_sc` for `hand`.

    Such coarse models keep a robot from itself, and reach beyond the tips of fingers.
    """
    names = {link.name for link in robot.links}
    links = tuple(
        Link(link.name) if link.name.removesuffix(COARSE) in names - {link.name} else link
        for link in robot.links
    )
    return replace(robot, links=links)


def hand_beyond(found: Description, robot: Robot, flange: str) -> Description | None:
    """What hangs on a flange, as a robot of its own; None where no joint of it moves.

    Args:
        found: with the joints that follow others.
        robot: of the description, perhaps with flanges added.
        flange: a link of it, the root of what is found.
    """
    beyond = [flange]
    for link in beyond:  # grows while it is walked
        beyond += [joint.child for joint in robot.joints if joint.parent == link]
    joints = tuple(joint for joint in robot.joints if joint.child in beyond[1:])
    if all(joint.kind == "fixed" for joint in joints):
        return None
    links = (Link(flange), *(robot.link(name) for name in beyond[1:]))
    names = {joint.name for joint in joints}
    followers = tuple(each for each in found.followers if each.joint.name in names)
    return Description(Robot(robot.name, links, joints), followers)


def _suction(robot: Robot, name: str) -> tuple[Tool, tuple[str, ...]]:
    """A tool of which nothing moves: it sucks by what is farthest from its root link."""
    body = _still(robot, frozenset())
    if not body:
        raise InputError(f"gripper {name}: it has no solids")
    points = np.asarray(surface_of(body).vertices)
    along = nearest_axis(points.mean(axis=0))
    end = float((points @ along).max())
    lip = points[points @ along > end - LIP]
    middle = (lip.min(axis=0) + lip.max(axis=0)) / 2
    middle += (end - middle @ along) * along
    wide = 2 * float(np.linalg.norm(lip - middle, axis=1).max())
    axis = "xyz"[int(np.argmax(np.abs(along)))]
    note = (
        f"nothing of it moves, so it sucks, by one lip of {1000 * wide:.0f} mm that is "
        f"{1000 * end:.1f} mm along {axis} of the root link; several cups count as one"
    )
    across = np.roll(along, 1)
    R = np.column_stack([np.cross(across, along), across, along])
    return Tool(name, pin.SE3(R, middle), body, press=PRESS), (note,)


def _still(robot: Robot, moving: frozenset[str]) -> tuple[Solid, ...]:
    """The solids of the links that do not move, in the frame of the root link."""
    poses = robot.link_poses({})
    return tuple(
        Solid(solid.name, solid.shape, poses[link.name] * solid.T_owner_shape, GREY)
        for link in robot.links
        if link.name not in moving
        for solid in link.collision or link.visual
    )


def _ends(robot: Robot, leaders: Sequence[str]) -> Iterable[tuple[tuple[float, float], ...]]:
    """From where to where the leaders go [rad, m] as it opens or closes: all ways together."""
    limits = [(robot.joint(name).lower, robot.joint(name).upper) for name in leaders]
    first, *rest = limits
    return ((first, *others) for others in product(*((r, (r[1], r[0])) for r in rest)))


def _moved(
    robot: Robot,
    followers: Sequence[Follower],
    leaders: Sequence[str],
    ends: Sequence[tuple[float, float]],
) -> tuple[MovingLink, ...]:
    """Where the points of every link that moves are as the leaders go from end to end."""
    known = {follower.joint.name: follower for follower in followers}
    points = {
        link.name: np.asarray(surface_of(link.collision or link.visual).vertices)
        for link in robot.links
        if link.collision or link.visual
    }
    placed: dict[str, list[Floats]] = {name: [] for name in points}
    for share in np.linspace(0.0, 1.0, OPENINGS_TRIED):
        values = {
            name: (1 - share) * low + share * high
            for name, (low, high) in zip(leaders, ends, strict=True)
        }
        poses = {robot.root: pin.SE3.Identity()}
        for joint in robot.joints:
            moving = known[joint.name].joint if joint.name in known else joint
            there = moving.at(_value(joint.name, values, known))
            poses[joint.child] = poses[joint.parent] * there.T_parent_joint
        for name, own in points.items():
            placed[name].append(transform(poses[name], own))
    return tuple(
        MovingLink(name, tuple(places))
        for name, places in placed.items()
        if max(np.abs(place - places[0]).max() for place in places) > LEAST_MOTION
    )


def _value(name: str, values: Mapping[str, float], known: Mapping[str, Follower]) -> float:
    """The value [rad, m] of a joint, which may follow one that follows another one."""
    if name not in known:
        return values.get(name, 0.0)
    follower = known[name]
    return follower.factor * _value(follower.leader, values, known) + follower.offset


def _made(robot: Robot, jaws: Jaws, name: str) -> Tool:
    """The tool, in the frame of the robot's root link."""
    body = [*_still(robot, jaws.moving)]
    body += [_hull(link.name, np.concatenate(link.points), GREY) for link in jaws.behind]
    fingers = []
    for tip, sense in zip(jaws.tips, (1.0, -1.0), strict=True):
        steps = np.clip(jaws.openings, 0.0, None) / 2 * sense
        pairs = zip(tip.points, steps, strict=True)
        closed = np.concatenate([points - step * jaws.apart for points, step in pairs])
        fingers.append(Finger(_hull(tip.name, closed, DARK), sense * jaws.apart))
    R = np.column_stack([np.cross(jaws.apart, jaws.along), jaws.apart, jaws.along])
    p = jaws.tip_z * jaws.along + jaws.middle * jaws.apart
    return Tool(name, pin.SE3(R, p), tuple(body), tuple(fingers), jaws.stroke)


def _hull(name: str, points: Floats, colour: tuple[float, float, float]) -> Solid:
    hull = hull_of(Mesh(points, np.empty((0, 3), np.int32)))
    if hull is None:
        raise InputError(f"link {name} is flat, so it takes no part")
    return Solid(name, hull, pin.SE3.Identity(), colour)
