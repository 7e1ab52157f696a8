"""Which of a robot's joints are its arms, and what stands still while these move."""

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from workbench.formats.robots.urdf_joints import Follower
from workbench.model.errors import InputError
from workbench.model.robot import Joint, Robot

FEWEST_JOINTS = 5
"""An arm with fewer turning joints cannot point its tool where it likes."""

FEWEST_AXES = 4
"""Joints of an arm that only ever points its tool down, slides among them."""

FINGERS = r"finger|gripper|knuckle|jaw|claw|thumb"
"""Parts of the names of joints that move a hand."""

LEFT = re.compile(r"left|(?:^|_)l(?:_|$)", re.IGNORECASE)
"""In the name of a flange: that of the left arm."""


@dataclass(frozen=True, slots=True, eq=False)
class Moving:
    """A robot of which only the joints of its arms move, and what follows from that, in words."""

    robot: Robot
    notes: tuple[str, ...]


def ends_of(robot: Robot, followers: Sequence[Follower] = ()) -> tuple[str, ...]:
    """The last links that move of one or two arms, as far as the joints tell; hands do not count.

    Raises:
        InputError: no chain is long enough, or more than two are.
    """
    tree = _Tree(robot, followers)
    lengths = {end: tree.turns_to(end) for end in tree.ends(robot.root, 0)}
    longest = max(lengths.values(), default=0)
    ends = [end for end, length in lengths.items() if length == longest]
    if longest < FEWEST_JOINTS:
        ends = [end for end in lengths if tree.moves_to(end) >= FEWEST_AXES]
    if not 1 <= len(ends) <= 2:
        names = ", ".join(ends or lengths) or "none"
        raise InputError(
            f"robot {robot.name}: its arms cannot be told from its joints (ends of chains: "
            f"{names}, {longest} turning joints at most); name the links that carry tools with "
            "--flange"
        )
    return tuple(ends)


class _Tree:
    """The joints that move, seen from link to link."""

    def __init__(self, robot: Robot, followers: Sequence[Follower]):
        self._robot = robot
        self._following = {follower.joint.name for follower in followers}
        self._leading = {follower.leader for follower in followers}

    def turns_to(self, link: str) -> int:
        """How many joints turn before a link."""
        return sum(joint.kind == "revolute" for joint in self._robot.chain(link))

    def moves_to(self, link: str) -> int:
        """How many joints move before a link."""
        return sum(joint.kind != "fixed" for joint in self._robot.chain(link))

    def ends(self, link: str, before: int) -> list[str]:
        """The last moving links of the arms beyond a link, `before` which this many joints move."""
        onward = list(self._onward(link))
        driven = [joint for joint in onward if self._longest(joint) > 0]
        arms = [joint for joint in driven if self._longest(joint) >= FEWEST_AXES]
        # More than two chains beyond an arm are fingers, however many joints each has.
        is_hand = not arms or len(arms) > 2
        if is_hand and before >= FEWEST_AXES and self._is_hand(onward):
            return [link]
        if not arms:
            longest = max(map(self._longest, driven), default=0)
            arms = [joint for joint in driven if self._longest(joint) == longest]
            if not arms:
                return [link]
        return [
            end for joint in arms for end in self.ends(joint.child, before + self._is_driven(joint))
        ]

    def _is_hand(self, onward: Sequence[Joint]) -> bool:
        # The last axis of an arm turns a whole hand, and the link that it turns is named so.
        names = " ".join(
            joint.name if any(self._onward(joint.child)) else f"{joint.name} {joint.child}"
            for joint in onward
        ).lower()
        leads = any(joint.name in self._leading for joint in onward)
        return len(onward) > 1 or leads or bool(re.search(FINGERS, names))

    def _is_driven(self, joint: Joint) -> bool:
        return joint.kind != "fixed" and joint.name not in self._following

    def _onward(self, link: str) -> Iterator[Joint]:
        """The next joints beyond a link that move, followers included."""
        for joint in self._robot.joints:
            if joint.parent == link:
                if joint.kind != "fixed" or joint.name in self._following:
                    yield joint
                else:
                    yield from self._onward(joint.child)

    def _longest(self, joint: Joint) -> int:
        """How many joints of the longest chain that begins with a joint have a motor."""
        beyond = max(map(self._longest, self._onward(joint.child)), default=0)
        return beyond + self._is_driven(joint)


def right_first(flanges: Sequence[str]) -> tuple[str, ...]:
    """The flanges as they are, but those of left arms last."""
    return tuple(sorted(flanges, key=lambda flange: bool(LEFT.search(flange))))


def standing(
    robot: Robot,
    followers: Sequence[Follower],
    flanges: Sequence[str],
    fixed: Mapping[str, float],
) -> Moving:
    """The robot with all joints fixed that belong to no arm, or to two.

    Args:
        robot: with its followers fixed.
        followers: its joints that follow others.
        flanges: the links that carry tools.
        fixed: values [rad, m] at which joints stand, by name.

    Raises:
        InputError: no such joint, a value that it cannot have, or an arm in which a joint follows
            another.
    """
    _check(robot, followers, fixed)
    chains = {flange: [joint.name for joint in robot.chain(flange)] for flange in flanges}
    moving = {joint.name: joint for joint in robot.joints if joint.kind != "fixed"}
    at = dict(fixed)
    notes: list[str] = []
    shared = _list_shared(chains, followers, moving.keys() - fixed.keys())
    for name in shared:
        at[name] = _nearest_to_zero(moving[name])
        notes.append(
            f"joint {name} moves both arms and stands at {_format(moving[name], at[name])}: "
            f"--fix {name}=VALUE for another value (its range: {_range(moving[name])})"
        )
    of_arms = {name for chain in chains.values() for name in chain if name in moving} - at.keys()
    _refuse_rods(chains, followers, of_arms, fixed)
    idle = [name for name in moving if name not in of_arms and name not in at]
    at |= {name: _nearest_to_zero(moving[name]) for name in idle}
    if idle:
        values = ", ".join(f"{name} at {_format(moving[name], at[name])}" for name in idle)
        notes.append(f"these joints belong to no arm and stand: {values} (--fix NAME=VALUE)")
    led = [follower for follower in followers if follower.joint.name not in at]
    tied = [follower for follower in led if follower.leader in of_arms]
    if tied:
        links = ", ".join(
            f"{follower.joint.child} (follows {follower.leader})" for follower in tied
        )
        notes.append(
            "links that follow another joint are drawn and checked where they are while that is at "
            f"zero: {links}; keep their room free, or leave them out of the URDF"
        )
    stand = {follower.joint.name: follower.at(at.get(follower.leader, 0.0)) for follower in led}
    stand |= {
        follower.joint.name: follower.joint.at(at[follower.joint.name])
        for follower in followers
        if follower.joint.name in at
    }
    joints = (stand.get(joint.name) or _at(joint, at) for joint in robot.joints)
    return Moving(replace(robot, joints=tuple(joints)), tuple(notes))


def without_hands(robot: Robot, flanges: Iterable[str]) -> tuple[Robot, tuple[str, ...]]:
    """The robot without what hangs on its flanges, and the names of what was left out."""
    gone: list[str] = []
    for flange in flanges:
        ends = [flange]
        for link in ends:  # grows while it is walked
            ends += [joint.child for joint in robot.joints if joint.parent == link]
        gone += [link for link in ends[1:] if link not in flanges]
    links = tuple(link for link in robot.links if link.name not in gone)
    joints = tuple(joint for joint in robot.joints if joint.child not in gone)
    return Robot(robot.name, links, joints, robot.disabled_pairs), tuple(gone)


def _check(robot: Robot, followers: Sequence[Follower], fixed: Mapping[str, float]) -> None:
    following = {follower.joint.name for follower in followers}
    for name, value in fixed.items():
        joint = robot.joint(name)
        if joint.kind == "fixed" and name not in following:
            raise InputError(f"--fix {name}: the joint cannot move")
        if joint.kind != "fixed" and not joint.lower <= value <= joint.upper:
            raise InputError(f"--fix {name}={_plain(joint, value)}: its range is {_range(joint)}")


def _list_shared(
    chains: Mapping[str, Sequence[str]], followers: Sequence[Follower], moving: Iterable[str]
) -> list[str]:
    """The joints that move more than one arm, themselves or by what follows them."""
    leaders = {follower.joint.name: follower.leader for follower in followers}
    moved = [{leaders.get(name, name) for name in chain} for chain in chains.values()]
    return [name for name in moving if sum(name in names for names in moved) > 1]


def _refuse_rods(
    chains: Mapping[str, Sequence[str]],
    followers: Sequence[Follower],
    of_arms: set[str],
    fixed: Mapping[str, float],
) -> None:
    """Refuse an arm whose own joint follows another: its flange would not be where it is said."""
    for follower in followers:
        name = follower.joint.name
        is_inside = any(name in chain for chain in chains.values())
        if is_inside and follower.leader in of_arms and name not in fixed:
            raise InputError(
                f"joint {name} follows joint {follower.leader} (mimic) and carries the tool, as "
                "where rods make a parallelogram: this cannot be calculated here, and the tool "
                f"would stand elsewhere than planned; --fix {name}=0 if it stands still in truth"
            )


def _at(joint: Joint, values: Mapping[str, float]) -> Joint:
    return joint.at(values[joint.name]) if joint.name in values else joint


def _nearest_to_zero(joint: Joint) -> float:
    return float(np.clip(0.0, joint.lower, joint.upper))


def _plain(joint: Joint, value: float) -> str:
    return f"{np.rad2deg(value):g}" if joint.kind == "revolute" else f"{value * 1000:g}"


def _format(joint: Joint, value: float) -> str:
    return f"{_plain(joint, value)} {'degrees' if joint.kind == 'revolute' else 'mm'}"


def _range(joint: Joint) -> str:
    low, high = np.round([joint.lower, joint.upper], 6)
    return f"{_plain(joint, low)} to {_format(joint, high)}"
