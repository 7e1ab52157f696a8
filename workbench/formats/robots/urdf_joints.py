"""The joints of a URDF file, and what follows from what it leaves open."""

import math
from collections import Counter, defaultdict
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.xml_elements import Element
from workbench.formats.robots.remarks import Remarks
from workbench.formats.robots.urdf_geometry import read_pose
from workbench.model.errors import FileError
from workbench.model.robot import Joint, JointKind

JOINT_KINDS: dict[str, JointKind] = {
    "revolute": "revolute",
    "continuous": "revolute",
    "prismatic": "prismatic",
    "fixed": "fixed",
}
FREE_KINDS = ("floating", "planar")
"""Of joints that no motor turns: what hangs on them stands where it is."""

WIDEST_TURN = 4 * math.pi
"""[rad] Wider joint limits are taken for degrees."""
NO_RANGE = 1000.0
"""[rad] Limits beyond this stand in files that know none."""
FASTEST_TURN = 100.0
"""[rad/s] Faster joints are taken for degrees per second."""
NO_LIMIT = 1000.0
"""[rad/s] A joint this fast stands in a file that knows no limit for it."""
LONGEST_SLIDE = 20.0
"""[m] Longer slides are taken for millimetres."""
ASSUMED_TURN, ASSUMED_SLIDE = 1.0, 0.1
"""[rad/s, m/s] Speeds of joints that come without one."""


@dataclass(frozen=True, slots=True, eq=False)
class Follower:
    """A joint that no motor turns of its own: its value is `factor` x that of `leader` + `offset`.

    `joint` is as if it could move.
    """

    joint: Joint
    leader: str
    factor: float
    offset: float

    def at(self, value: float) -> Joint:
        """The joint fixed where it stands when its leader has that value [rad or m]."""
        return self.joint.at(self.factor * value + self.offset)


def read_joint(
    element: Element, links: Iterable[str], remarks: Remarks, followers: list[Follower]
) -> Joint:
    """One joint; a follower is added to `followers`, and is fixed where its leader is at zero.

    Raises:
        FileError: an end is no link, or a number is wrong.
    """
    name, declared = element.text("name"), element.text("type")
    if declared not in JOINT_KINDS:
        error = element.error(f"type={quote(declared)} is not one of {', '.join(JOINT_KINDS)}")
        if declared not in FREE_KINDS:
            raise error
        remarks.pass_over(error, "stands still")
        declared = "fixed"
    parent, child = (_end(element, tag, links) for tag in ("parent", "child"))
    joint = Joint(name, "fixed", parent, child, read_pose(element), np.array([1.0, 0.0, 0.0]))
    # A wheel may come without a limit: nobody says how fast it turns, so it is not turned.
    is_wheel = declared == "continuous" and element.one("limit") is None
    mimic = element.one("mimic")
    if declared == "fixed" or (is_wheel and remarks.is_strict and mimic is None):
        return joint
    kind, axis = JOINT_KINDS[declared], _axis(element)
    if mimic is not None:
        moving = Joint(name, kind, parent, child, joint.T_parent_joint, axis)
        follower = Follower(
            moving,
            mimic.text("joint"),
            mimic.number("multiplier", 1.0),
            mimic.number("offset", 0.0),
        )
        followers.append(follower)
        return follower.at(0.0)
    limits = _limits(element, declared, remarks)
    if limits is None:
        return joint
    return Joint(name, kind, parent, child, joint.T_parent_joint, axis, *limits)


def _axis(element: Element) -> np.ndarray:
    given = element.one("axis")
    if given is None:
        return np.array([1.0, 0.0, 0.0])
    axis = given.numbers("xyz", 3)
    if np.linalg.norm(axis) < 1e-9:
        raise given.error("has no direction")
    return axis / np.linalg.norm(axis)


def _end(element: Element, tag: str, links: Iterable[str]) -> str:
    end = element.one(tag)
    if end is None:
        raise element.error(f"has no <{tag}>")
    link = end.text("link")
    if link not in links:
        raise end.error(f"there is no link {quote(link)}")
    return link


def _limits(element: Element, declared: str, remarks: Remarks) -> tuple[float, float, float] | None:
    """Lower and upper limit [rad or m] and velocity [rad/s or m/s]; None: it cannot move."""
    turns, limit = declared != "prismatic", element.one("limit")
    if limit is None:
        error = element.error("has no <limit> with lower, upper and velocity")
        if declared != "continuous":
            raise error
        return -2 * math.pi, 2 * math.pi, _assume_speed(error, turns, remarks)
    if declared == "continuous":
        return -2 * math.pi, 2 * math.pi, _velocity(limit, turns, remarks)
    lower, upper = limit.number("lower", 0.0), limit.number("upper", 0.0)
    if not lower < upper:
        error = limit.error(
            f"lower={lower:g} is not less than upper={upper:g}; "
            "give its range, or make the joint fixed"
        )
        if lower > upper:
            raise error
        remarks.pass_over(error, "stands still")
        return None
    velocity = _velocity(limit, turns, remarks)
    if turns and min(-lower, upper) >= NO_RANGE and not remarks.is_strict:
        return -2 * math.pi, 2 * math.pi, velocity
    widest, unit, other = (
        (WIDEST_TURN, "radians", "degrees") if turns else (LONGEST_SLIDE, "metres", "millimetres")
    )
    if max(-lower, upper) > widest:
        raise limit.error(
            f"lower={lower:g} and upper={upper:g}: {unit} are expected, these look like {other}"
        )
    return lower, upper, velocity


def _velocity(limit: Element, turns: bool, remarks: Remarks) -> float:
    """[rad/s or m/s]; an assumed one where the file gives none that is one."""
    if not remarks.is_strict and not limit.text("velocity", ""):
        return _assume_speed(limit.error("has no velocity"), turns, remarks)
    velocity = limit.number("velocity")
    if velocity <= 0:
        error = limit.error(
            f"velocity={velocity:g}: must be positive; give its speed, or make the joint fixed"
        )
        return _assume_speed(error, turns, remarks)
    if velocity >= (FASTEST_TURN if turns else NO_LIMIT) and not remarks.is_strict:
        return _assume_speed(limit.error(f"velocity={velocity:g}: is no limit"), turns, remarks)
    if turns and FASTEST_TURN < velocity < NO_LIMIT:
        raise limit.error(f"velocity={velocity:g}: rad/s are expected, this looks like degrees")
    return velocity


def _assume_speed(error: FileError, turns: bool, remarks: Remarks) -> float:
    speed, unit = (ASSUMED_TURN, "rad/s") if turns else (ASSUMED_SLIDE, "m/s")
    remarks.pass_over(error, f"{speed:g} {unit} is assumed; set velocity in robot.urdf")
    return speed


def as_tree(path: Path, links: Iterable[str], joints: list[Joint]) -> tuple[Joint, ...]:
    """The joints with parents before children, when they make one tree of all links.

    Raises:
        FileError: they do not; it names the link or the joints where it is so.
    """
    for name, times in Counter(joint.name for joint in joints).items():
        if times > 1:
            raise FileError(path, f"joint {quote(name)} is there {times} times")
    children = Counter(joint.child for joint in joints)
    for name, times in children.items():
        if times > 1:
            ends = ", ".join(quote(joint.name) for joint in joints if joint.child == name)
            raise FileError(
                path,
                f"link {quote(name)} is the child of {times} joints ({ends}), as where rods close "
                "a chain; leave out all but the one that a motor turns",
            )
    roots = [name for name in links if name not in children]
    if not roots:
        raise FileError(path, "no link is the root: the joints make a circle")
    if len(roots) > 1:
        listed = ", ".join(quote(name) for name in roots[:5])
        raise FileError(path, f"one link must be the root, these {len(roots)} are: {listed}")
    onward: defaultdict[str, list[Joint]] = defaultdict(list)
    for joint in joints:
        onward[joint.parent].append(joint)
    ordered = list(onward[roots[0]])
    for joint in ordered:  # grows while it is walked
        ordered += onward[joint.child]
    if len(ordered) < len(joints):
        left = next(joint for joint in joints if joint not in ordered)
        raise FileError(path, f"joint {quote(left.name)} is part of a circle")
    return tuple(ordered)
