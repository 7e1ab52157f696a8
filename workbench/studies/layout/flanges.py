"""Where a tool is screwed to: its z points out of the arm, along the axis of the last joint.

Names of links do not tell: makers call `flange` what has x, y or z along that axis.
"""

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from workbench.formats.meshes.triangles import surface_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.robot import Joint, Link, Robot

NAMES = (r"tool0$", r"flange$", r"link_?8$", r"hand(_link)?$", r"ee_link$", r"tool")
"""Names of links that a tool is screwed to, the surest first."""

MOST_TURNED = np.deg2rad(1.0)
"""[rad] So much z of a flange may be turned against the last axis."""

OFF_AXIS = 0.002
"""[m] This far from that axis a flange may lie."""

CLEAR_DISTANCE = 0.002
"""[m] A smaller distance does not tell to which side a link lies."""

FACE = 0.02
"""[m] No further does the last link reach beyond a frame that is its face."""

MADE = "tool_flange"
"""What a link is called that is made where no frame is right."""


@dataclass(frozen=True, slots=True, eq=False)
class Mounts:
    """A robot, the links in it that carry its tools, and what a person has to know of these."""

    robot: Robot
    flanges: tuple[str, ...]
    notes: tuple[str, ...]


def mounts_of(robot: Robot, ends: Sequence[str]) -> Mounts:
    """The flange of each arm, among the links that are fixed to the last one that moves.

    Where none has its z along the last axis, a link is added that has.

    Args:
        robot: with the joints of its arms.
        ends: the last link that moves of each arm.
    """
    flanges: list[str] = []
    notes: list[str] = []
    for end in ends:
        candidates = _fixed_to(robot, end)
        called = min(candidates, key=_rank)
        right = [link for link in candidates if _fits(robot, link) and _rank(link) < len(NAMES)]
        if right:
            flange = min(right, key=_rank)
            if flange != called and not _fits(robot, called):
                notes.append(_describe(robot, called, flange))
        elif _fits(robot, end) and _is_at_face(robot, end):
            flange = end
        else:
            robot, flange = _with_flange(robot, end, called)
            notes.append(_describe(robot, called, flange))
        flanges.append(flange)
    return Mounts(robot, tuple(flanges), tuple(notes))


def named_mounts(robot: Robot, flanges: Sequence[str]) -> Mounts:
    """The links that a person names, with a remark about those whose z is not the last axis.

    Raises:
        InputError: a link is not there, or no joint moves it.
    """
    notes: list[str] = []
    for flange in flanges:
        lean = lean_of(robot, robot.link(flange).name)
        if np.isnan(lean):
            raise InputError(f"--flange {flange}: no joint moves this link")
        if lean > MOST_TURNED:
            notes.append(
                f"z of link {flange} is turned {np.rad2deg(lean):.0f} degrees against the last "
                "axis: the tool stands along that z"
            )
    return Mounts(robot, tuple(flanges), tuple(notes))


def lean_of(robot: Robot, flange: str) -> float:
    """By how much z of a flange is turned against the last axis, out of the arm [rad]; 0 to pi.

    NaN where no joint moves the flange.
    """
    found = _last(robot, flange)
    if found is None:
        return float("nan")
    _, T_joint_flange, axis = found
    z = T_joint_flange.rotation[:, 2]
    return float(np.arccos(np.clip(z @ axis, -1.0, 1.0)))


def _fits(robot: Robot, link: str) -> bool:
    """Whether z of a link lies along the last axis, out of the arm."""
    found = _last(robot, link)
    if found is None:
        return False
    _, T, axis = found
    off = T.translation - (T.translation @ axis) * axis
    return lean_of(robot, link) < MOST_TURNED and float(np.linalg.norm(off)) < OFF_AXIS


def _last(robot: Robot, link: str) -> tuple[Joint, pin.SE3, Floats] | None:
    """The last joint that moves a link, the link in its frame, and its axis (3,) out of the arm."""
    T = pin.SE3.Identity()
    chain = list(robot.chain(link))
    while chain and chain[-1].kind == "fixed":
        T = chain.pop().T_parent_joint * T
    if not chain:
        return None
    joint = chain[-1]
    axis = np.asarray(joint.axis)
    return joint, T, axis * _outward(robot, chain, T, axis)


def _outward(robot: Robot, chain: Sequence[Joint], T: pin.SE3, axis: Floats) -> float:
    """1 where the arm ends in the direction of the axis of its last joint, -1 in the other."""
    joint = chain[-1]
    away = [float(T.translation @ axis)]
    # Seen from the joint before, the link before, and the link itself: all turn about the axis.
    if len(chain) > 1:
        away = [float((T.translation + _from_before(chain)) @ axis)]
    T_joint_parent = joint.T_parent_joint.inverse()
    for link, T_joint_link in ((joint.child, pin.SE3.Identity()), (joint.parent, T_joint_parent)):
        points = _points(robot.link(link))
        if len(points):
            middle = T_joint_link.act((points.min(axis=0) + points.max(axis=0)) / 2)
            away.append(float((T.translation - middle) @ axis))
    offset = next((distance for distance in away if abs(distance) > CLEAR_DISTANCE), 1.0)
    return float(np.sign(offset))


def _from_before(chain: Sequence[Joint]) -> Floats:
    """From the joint that moves before the last one to that, in the frame of the last (3,) [m]."""
    T = pin.SE3.Identity()
    for joint, before in zip(reversed(chain), reversed(chain[:-1]), strict=False):
        T = joint.T_parent_joint * T
        if before.kind != "fixed":
            return T.rotation.T @ T.translation
    return np.zeros(3)


def _points(link: Link) -> Floats:
    """Points of a link's geometry, in its frame (n, 3) [m]; n may be 0."""
    solids = link.collision or link.visual
    return np.asarray(surface_of(solids).vertices) if solids else np.empty((0, 3))


def _fixed_to(robot: Robot, end: str) -> list[str]:
    """A link and all that is fixed to it, the nearest first."""
    links = [end]
    for link in links:  # grows while it is walked
        links += [j.child for j in robot.joints if j.parent == link and j.kind == "fixed"]
    return links


def _rank(link: str) -> int:
    """How sure the name of a link says that a tool is screwed to it; 0 is surest."""
    found = (rank for rank, pattern in enumerate(NAMES) if re.search(pattern, link.lower()))
    return next(found, len(NAMES))


def _face(robot: Robot, end: str, axis: Floats) -> float:
    """How far the geometry of the last link reaches along the last axis [m]; 0 without any."""
    points = _points(robot.link(end))
    return float((points @ axis).max()) if len(points) else 0.0


def _is_at_face(robot: Robot, end: str) -> bool:
    found = _last(robot, end)
    return found is not None and abs(_face(robot, end, found[2])) < FACE


def _with_flange(robot: Robot, end: str, called: str) -> tuple[Robot, str]:
    """The robot with a link where the arm ends, z along the last axis."""
    found = _last(robot, called)
    if found is None:
        return robot, called
    _, T_end_called, axis = found
    far = float(T_end_called.translation @ axis)
    if _rank(called) == len(NAMES):
        far = max(far, _face(robot, end, axis))
    R = pin.Quaternion.FromTwoVectors(T_end_called.rotation[:, 2], axis).matrix()
    T = pin.SE3(R @ T_end_called.rotation, far * axis)
    name = MADE if MADE not in {link.name for link in robot.links} else f"{MADE}_{end}"
    joint = Joint(f"{name}_mount", "fixed", end, name, T, np.array([0.0, 0.0, 1.0]))
    links, joints = (*robot.links, Link(name)), (*robot.joints, joint)
    return replace(robot, links=links, joints=joints), name


def _describe(robot: Robot, called: str, flange: str) -> str:
    lean = np.rad2deg(lean_of(robot, called))
    why = f"z of link {called} is turned {lean:.0f} degrees against the last axis"
    if lean < np.rad2deg(MOST_TURNED):
        why = f"no link is called a flange, and {called} does not lie where the arm ends"
    made = " (added to the URDF)" if flange.startswith(MADE) else ""
    return f"{why}: the tool is screwed to {flange}{made}; look at it, or name another by --flange"
