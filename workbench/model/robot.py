"""A robot as a tree of links and joints, whatever file it came from; what its arms carry."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import pinocchio as pin

from workbench.model.digest import LATER, Shared
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Solid, own

JointKind = Literal["revolute", "prismatic", "fixed"]

MOST_TURNS = 9
"""How often an axis may count in another one."""


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
        own(self, "T_parent_joint", "axis")

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

    def link_poses(self, values: Mapping[str, float]) -> dict[str, pin.SE3]:
        """`T_root_link` of every link; joints without a value [rad, m] stand at zero."""
        poses = {self.root: pin.SE3.Identity()}
        for joint in self.joints:
            there = joint.at(values.get(joint.name, 0.0))
            poses[joint.child] = poses[joint.parent] * there.T_parent_joint
        return poses

    def rigid_with(self, link: str) -> frozenset[str]:
        """Links that no movable joint parts from a link, itself among them."""
        carriers = {self.root: self.root}
        for joint in self.joints:
            carriers[joint.child] = carriers[joint.parent] if joint.kind == "fixed" else joint.child
        return frozenset(name for name, carrier in carriers.items() if carrier == carriers[link])

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


@dataclass(frozen=True, slots=True, eq=False)
class AxisMapping:
    """How a controller's numbers follow from an arm's axes: `coupling @ axes + offsets`.

    Axes are in the controller's order and sense already (`Arm.to_axes`).  `coupling` (n, n) holds
    whole numbers, so that whole steps of an axis stay whole; `offsets` (n,) [rad, m].
    """

    coupling: Floats
    offsets: Floats

    def __post_init__(self) -> None:
        own(self, "coupling", "offsets")

    def to_controller(self, axes: Floats) -> Floats:
        """What the controller shows (n,) [rad, m] where its axes are at `axes` (n,) [rad, m]."""
        return np.asarray(self.coupling) @ axes + self.offsets

    def from_controller(self, values: Floats) -> Floats:
        """The axes (n,) [rad, m] where the controller shows `values` (n,) [rad, m]."""
        turns = np.linalg.inv(self.coupling).astype(np.float64)
        return turns @ (np.asarray(values) - self.offsets)

    def problem(self, slides: Sequence[bool]) -> str:
        """Why no controller counts so, with the axes that slide; empty when one may."""
        coupling = np.asarray(self.coupling)
        if not np.array_equal(coupling, np.round(coupling)) or np.abs(coupling).max() > MOST_TURNS:
            return f"whole numbers from -{MOST_TURNS} to {MOST_TURNS} are expected"
        if abs(np.linalg.det(coupling)) < 0.5:
            return "the rows depend on each other: an axis cannot be read back"
        mixed = coupling[np.not_equal.outer(slides, slides)]
        return "a turning axis and a sliding one are added" if np.any(mixed) else ""


@dataclass(frozen=True, slots=True, eq=False)
class Tcp:
    """A TCP that has a name: `touches` names the solids of the tool that may touch the part.

    Without any, all may.  `output` is the digital output that switches it; None: the link's one.
    """

    name: str
    T_flange_tcp: pin.SE3
    touches: tuple[str, ...] = ()
    output: int | None = None

    def __post_init__(self) -> None:
        own(self, "T_flange_tcp")


@dataclass(frozen=True, slots=True, eq=False)
class ToolSlot:
    """Where a tool of an arm stands while the arm does not carry it.

    `T_world_flange` is the pose of the flange that carries the tool in its slot.  With the tool the
    flange leaves along `leave` (3,), a unit vector in the world, without it along its own -z; both
    `distance` [m] far.  On these lines the tool may touch the `fixture` of that name; empty: none.
    """

    tool: str
    T_world_flange: pin.SE3
    leave: Floats
    distance: float
    fixture: str = ""

    def __post_init__(self) -> None:
        own(self, "T_world_flange", "leave")

    @property
    def T_world_outside(self) -> pin.SE3:
        """The pose of the flange where it is out of the slot with the tool."""
        T = self.T_world_flange
        return pin.SE3(T.rotation, T.translation + self.distance * np.asarray(self.leave))

    @property
    def T_world_before(self) -> pin.SE3:
        """The pose of the flange, without tool, straight before the one that stands there."""
        return self.T_world_flange * pin.SE3(np.eye(3), np.array([0.0, 0.0, -self.distance]))


@dataclass(frozen=True, slots=True, eq=False)
class ScanPosture:
    """A posture of the arm from which its scanner scans: `q` (n,) [rad, m], chain order.

    `bin` names the only bin that is scanned from there; empty: any.  Several views of a cell have
    numbers from 1 on.
    """

    name: str
    q: Floats
    bin: str = field(default="", metadata=LATER)
    number: int = field(default=0, metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "q")


MOST_OFF = (0.002, float(np.deg2rad(0.5)))
"""[m], [rad] A view that lies further off the others than this is not moved onto them."""

MOST_THROUGH = 0.025
"""Of what a view shows, the share that others look through.  Six kinds of simulated scanners bring
1.9% at most, and a pose that is 12 mm off brings 3.2% or more."""


@dataclass(frozen=True, slots=True, eq=False)
class ScannedView:
    """One of the views that a scan is merged from: from where the scanner saw `count` points.

    They follow those of the views before.  `T_world_scanner` is the pose that the robot's joints
    gave, moved onto the other views by `shift` [m] and `turn` [rad]; by more than `MOST_OFF` it was
    not moved.  `through`, 0..1, is the share of its points that others look through, or it of
    theirs.
    """

    name: str
    count: int
    T_world_scanner: pin.SE3
    shift: float = 0.0
    turn: float = 0.0
    through: float = 0.0

    def __post_init__(self) -> None:
        own(self, "T_world_scanner")

    @property
    def is_off(self) -> bool:
        """Whether calibration or robot has to be wrong: it does not fit the other views."""
        is_far = self.shift > MOST_OFF[0] or self.turn > MOST_OFF[1]
        return is_far or self.through > MOST_THROUGH


HOME = "home"
"""Instead of the name of a view: the posture `home` of the arm with the scanner."""


@dataclass(frozen=True, slots=True, eq=False)
class ArmScanner:
    """Which arm carries the scanner, where on its flange, and what collides of it.

    `flange` and `joints` are those of the arm.
    `T_flange_scanner` is the pose of the camera's frame.  `housing` are solids in the flange's
    frame: scanner, bracket, plug.  The arm waits at the `view`, where every plan begins and ends;
    it may be exchanged for one of `other_views` (`derived.by_view`).  `home` (n,) [rad, m] is the
    arm's `home_deg` in the cell file, from where the arm goes to a view and back.  `merges_views`:
    a scan is whole once it has come from each view of the bin.
    """

    arm: str
    flange: str
    joints: tuple[str, ...]
    T_flange_scanner: pin.SE3
    view: ScanPosture
    home: Floats
    housing: tuple[Solid, ...] = ()
    other_views: tuple[ScanPosture, ...] = field(default=(), metadata=LATER)
    merges_views: bool = field(default=False, metadata=LATER)

    def __post_init__(self) -> None:
        own(self, "T_flange_scanner", "home")

    @property
    def views(self) -> tuple[ScanPosture, ...]:
        """All of them, in the order of the cell file."""
        return tuple(sorted((self.view, *self.other_views), key=lambda view: view.number))

    @property
    def label(self) -> str:
        """What people and a list of disabled pairs call the housing."""
        return f"{self.arm}_scanner"

    @property
    def reach(self) -> float:
        """How far [m] the farthest point of the housing gets from the flange, at most."""
        return max((solid.reach for solid in self.housing), default=0.0)

    def start_of(self, name: str) -> Floats | None:
        """Where (n,) [rad, m] a path to the view begins: at `HOME` or another view; else None."""
        if name == HOME:
            return self.home
        return next((view.q for view in self.other_views if view.name == name), None)

    def leads_home(self, path: Floats) -> bool:
        """Whether a path (m, n) [rad, m] leads from the view home, by where it begins and ends."""
        begins, ends = np.asarray(path)[[0, -1]]
        at_view, at_home = np.asarray(self.view.q), np.asarray(self.home)
        forth = np.abs(begins - at_home).max() + np.abs(ends - at_view).max()
        back = np.abs(begins - at_view).max() + np.abs(ends - at_home).max()
        return bool(back < forth)

    def T_world_scanner(self, T_world_robot: pin.SE3, robot: Robot, q: Floats) -> pin.SE3:
        """Where the scanner is while its arm stands at `q` (n,) [rad, m], chain order.

        Args:
            T_world_robot: where the robot stands.
            robot: whose arm carries it.
            q: of the arm; the robot's other joints do not count.
        """
        values = dict(zip(self.joints, map(float, np.asarray(q)), strict=True))
        return T_world_robot * robot.link_poses(values)[self.flange] * self.T_flange_scanner
