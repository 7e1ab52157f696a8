"""A robot as a tree of links and joints, whatever file it came from."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal

import numpy as np
import pinocchio as pin

from workbench.model.digest import Shared
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Solid, copied, frozen, put

JointKind = Literal["revolute", "prismatic", "fixed"]


@dataclass(frozen=True, slots=True, eq=False)
class Joint:
    """One joint.  A URDF `continuous` joint is a revolute one with limits of +/- 2 pi.

    `lower`, `upper` [rad or m], `velocity` [rad/s or m/s]; `axis` (3,) a unit vector in the
    joint's frame; `T_parent_joint` where that frame sits in the parent link at zero.
    """

    name: str
    kind: JointKind
    parent: str
    child: str
    T_parent_joint: pin.SE3
    axis: Floats
    lower: float = 0.0
    upper: float = 0.0
    velocity: float = 0.0

    def __post_init__(self) -> None:
        put(self, T_parent_joint=copied(self.T_parent_joint), axis=frozen(self.axis))

    def at(self, value: float) -> "Joint":
        """The joint fixed at a value [rad or m]; as it is when it cannot move."""
        if self.kind == "fixed":
            return self
        moved = np.asarray(self.axis) * value
        T = pin.SE3(pin.exp3(moved), np.zeros(3))
        if self.kind == "prismatic":
            T = pin.SE3(np.eye(3), moved)
        there = self.T_parent_joint * T
        return Joint(self.name, "fixed", self.parent, self.child, there, self.axis)


@dataclass(frozen=True, slots=True, eq=False)
class Link:
    """One rigid body: `collision` is what the planner checks, `visual` what the page draws."""

    name: str
    collision: tuple[Solid, ...] = ()
    visual: tuple[Solid, ...] = ()


@dataclass(frozen=True, slots=True, eq=False)
class Robot(Shared):
    """Links and joints, parents before children, and the link pairs that need no check."""

    name: str
    links: tuple[Link, ...]
    joints: tuple[Joint, ...]
    disabled_pairs: frozenset[tuple[str, str]] = frozenset()

    @property
    def root(self) -> str:
        """The link that no joint has as its child."""
        children = {joint.child for joint in self.joints}
        return next(link.name for link in self.links if link.name not in children)

    def link(self, name: str) -> Link:
        """The link of that name.

        Raises:
            InputError: there is none; the message lists those there are.
        """
        for link in self.links:
            if link.name == name:
                return link
        known = ", ".join(link.name for link in self.links)
        raise InputError(f"robot {self.name} has no link {name!r}; it has {known}")

    def joint(self, name: str) -> Joint:
        """The joint of that name.

        Raises:
            InputError: there is none; the message lists the movable ones.
        """
        for joint in self.joints:
            if joint.name == name:
                return joint
        known = ", ".join(joint.name for joint in self.joints if joint.kind != "fixed")
        raise InputError(f"robot {self.name} has no joint {name!r}; it has {known}")

    def chain(self, tip: str) -> tuple[Joint, ...]:
        """All joints from the root to link `tip`, root first, fixed ones included."""
        by_child = {joint.child: joint for joint in self.joints}
        joints: list[Joint] = []
        link = self.link(tip).name
        while link in by_child:
            joints.append(by_child[link])
            link = by_child[link].parent
        return tuple(reversed(joints))

    def reach(self, link: str, tools: Mapping[str, float]) -> float:
        """How far [m] the farthest point that a link carries gets from its origin, at most.

        Args:
            link: its name; links that hang on it count, wherever their joints are.
            tools: how far tools reach beyond the links that carry them.
        """
        own = [solid.reach for solid in self.link(link).collision]
        beyond = [
            float(np.linalg.norm(joint.T_parent_joint.translation))
            + (max(abs(joint.lower), abs(joint.upper)) if joint.kind == "prismatic" else 0.0)
            + self.reach(joint.child, tools)
            for joint in self.joints
            if joint.parent == link
        ]
        return max([*own, *beyond, tools.get(link, 0.0)], default=0.0)

    def limits(self, joints: tuple[str, ...]) -> tuple[Floats, Floats, Floats]:
        """Lower and upper limits [rad, m] and velocities [per s] of the named joints, (n,) each."""
        found = [self.joint(name) for name in joints]
        return (
            np.array([joint.lower for joint in found]),
            np.array([joint.upper for joint in found]),
            np.array([joint.velocity for joint in found]),
        )
