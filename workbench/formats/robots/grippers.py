"""A gripper's URDF or xacro file to a tool: its body, two fingers, stroke and TCP.

Fingers of a cell move straight, those of linkages swing.  So a tool made here is a little larger
than such a gripper: of each finger the last link moves, and is as large as all places that it gets
to beside its straight way.  What moves behind it counts as body, at all its places at once.
"""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
import pinocchio as pin
import trimesh

from workbench.formats.meshes.pieces.convex_pieces import hull_of
from workbench.formats.meshes.triangles import surface_of
from workbench.formats.robots.descriptions import Description
from workbench.formats.robots.urdf_joints import Follower
from workbench.formats.robots.urdf_package import simplify_robot
from workbench.model.cell import Finger, Tool
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, Mesh, Solid
from workbench.model.robot import Robot

SAMPLES = 33
"""Openings at which it is looked where the links are."""

STILL = 1e-6
"""[m] A link whose points move less is of the body."""

SAME_WAY = 1e-4
"""[m] A link that goes along with the tip so closely is one finger with it."""

MOST_SWING = 0.005
"""[m] By how much tips of a linkage may come forward as they close, unless somebody wants more."""

LEAST_STROKE = 0.002
"""[m]"""

TOLERANCE, MOST_PIECES = 0.003, 8
"""[m] By how much a convex piece of the body may be too large, and how many a mesh may have."""

GREY, DARK = (0.55, 0.57, 0.6), (0.25, 0.26, 0.3)


@dataclass(frozen=True, slots=True, eq=False)
class _Moving:
    """The points (n, 3) [m] of a link in the root's frame, at each opening."""

    name: str
    points: tuple[Floats, ...]

    @property
    def middles(self) -> Floats:
        """Of the points at each opening (k, 3) [m]."""
        return np.array([points.mean(axis=0) for points in self.points])


def gripper_of(
    found: Description, name: str, widest: float | None = None
) -> tuple[Tool, tuple[str, ...]]:
    """The tool that a description is of, its root link on the flange, and what was decided.

    Args:
        found: of the gripper alone.
        name: of the tool.
        widest: [m] it is never opened further; None: as far as the tips of a linkage come forward
            by no more than `MOST_SWING` as they close.

    Raises:
        InputError: it has no solids, or does not move like a gripper with two fingers.
    """
    robot, _ = simplify_robot(found.robot, tolerance=TOLERANCE, most=MOST_PIECES)
    leaders = [joint.name for joint in robot.joints if joint.kind != "fixed"]
    if not leaders:
        raise InputError(
            f"gripper {name}: none of its joints moves; a suction cup is described in the cell "
            "file, or from CAD in the tab Cell"
        )
    if len(leaders) > 2:
        raise InputError(
            f"gripper {name}: {len(leaders)} joints move on their own ({', '.join(leaders)}); "
            "one or two are expected, and <mimic> for those that follow"
        )
    ways = [_moved(robot, found.followers, leaders, ends) for ends in _ends(robot, leaders)]
    made = max((_Jaws.of(moving, name) for moving in ways), key=lambda jaws: jaws.stroke[1])
    if made.stroke[1] - made.stroke[0] < LEAST_STROKE:
        raise InputError(f"gripper {name}: its fingers do not move apart along a line")
    made = made.within(widest)
    return made.tool(robot, name), (*found.notes, *made.notes)


def _ends(robot: Robot, leaders: Sequence[str]) -> Iterable[tuple[tuple[float, float], ...]]:
    """From where to where the leaders go [rad, m] as it opens or closes: all ways together."""
    limits = [(robot.joint(name).lower, robot.joint(name).upper) for name in leaders]
    first, *rest = limits
    return ((first, *others) for others in product(*((r, r[::-1]) for r in rest)))


def _moved(
    robot: Robot,
    followers: Sequence[Follower],
    leaders: Sequence[str],
    ends: Sequence[tuple[float, float]],
) -> tuple[_Moving, ...]:
    """Where the points of every link that moves are as the leaders go from end to end."""
    known = {follower.joint.name: follower for follower in followers}
    points = {
        link.name: np.asarray(surface_of(link.collision or link.visual).vertices)
        for link in robot.links
        if link.collision or link.visual
    }
    placed: dict[str, list[Floats]] = {name: [] for name in points}
    for share in np.linspace(0.0, 1.0, SAMPLES):
        values = {
            name: (1 - share) * low + share * high
            for name, (low, high) in zip(leaders, ends, strict=True)
        }
        poses = {robot.root: pin.SE3.Identity()}
        for joint in robot.joints:
            there = joint.at(_value(joint.name, values, known))
            if joint.name in known:
                there = known[joint.name].joint.at(_value(joint.name, values, known))
            poses[joint.child] = poses[joint.parent] * there.T_parent_joint
        for name, own in points.items():
            placed[name].append(own @ poses[name].rotation.T + poses[name].translation)
    return tuple(
        _Moving(name, tuple(places))
        for name, places in placed.items()
        if max(np.abs(place - places[0]).max() for place in places) > STILL
    )


def _value(name: str, values: Mapping[str, float], known: Mapping[str, Follower]) -> float:
    """The value [rad, m] of a joint, which may follow one that follows another one."""
    if name not in known:
        return values.get(name, 0.0)
    follower = known[name]
    return follower.factor * _value(follower.leader, values, known) + follower.offset


@dataclass(frozen=True, slots=True, eq=False)
class _Jaws:
    """What moves of a gripper, sorted.

    `along` (3,) is where it points, `apart` (3,) where the first of the two `tips` opens, `middle`
    [m] where they meet along that.  `behind` is what else moves; `moving` names all links that do.
    `openings` (n,) [m] are the distances of the tips, `most` the largest that the gripper has.
    """

    along: Floats
    apart: Floats
    middle: float
    tips: tuple[_Moving, _Moving]
    behind: tuple[_Moving, ...]
    moving: frozenset[str]
    openings: Floats
    most: float = 0.0

    @classmethod
    def of(cls, moving: Sequence[_Moving], name: str) -> "_Jaws":
        """Find the two tips among the links that move, and how they open.

        Raises:
            InputError: the links do not move to two sides.
        """
        if len(moving) < 2:
            raise InputError(f"gripper {name}: two fingers are expected, {len(moving)} link moves")
        every = np.concatenate([points for link in moving for points in link.points])
        along = _nearest_axis(every.mean(axis=0))
        travels = [link.middles[-1] - link.middles[0] for link in moving]
        across = [travel - (travel @ along) * along for travel in travels]
        widest = max(across, key=lambda travel: float(np.linalg.norm(travel)))
        if np.linalg.norm(widest) < LEAST_STROKE / 2:
            raise InputError(f"gripper {name}: its fingers do not move apart along a line")
        apart = widest / np.linalg.norm(widest)
        half = float((every @ apart).min() + (every @ apart).max()) / 2
        sides = [
            [link for link in moving if (link.middles.mean(axis=0) @ apart > half) == is_first]
            for is_first in (True, False)
        ]
        if not all(sides):
            raise InputError(f"gripper {name}: only one finger moves; two are expected")
        tips = tuple(max(side, key=lambda link: _farthest(link, along)) for side in sides)
        with_tips = [
            [link for link in side if _goes_along(link, tip)]
            for side, tip in zip(sides, tips, strict=True)
        ]
        first, second = (_joined(links) for links in with_tips)
        low = np.array([(points @ apart).min() for points in first.points])
        high = np.array([(points @ apart).max() for points in second.points])
        inner = np.array([low, high])
        behind = tuple(link for link in moving if not any(link in links for links in with_tips))
        middle = float(inner.mean())
        names = frozenset(link.name for link in moving)
        return cls(along, apart, middle, (first, second), behind, names, low - high)

    def within(self, widest: float | None) -> "_Jaws":
        """The same as far as it opens by `widest` [m]; see `gripper_of`."""
        if widest is None:
            reaches = np.array([self._reach(k) for k in range(SAMPLES)])
            order = np.argsort(self.openings)
            is_near = np.maximum.accumulate(reaches[order]) - reaches[order] <= MOST_SWING
            stays = order[np.logical_and.accumulate(is_near)]
        else:
            stays = np.flatnonzero(self.openings <= widest)
        stays = np.sort(stays)

        def cut(link: _Moving) -> _Moving:
            return replace(link, points=tuple(link.points[k] for k in stays))

        first, second = map(cut, self.tips)
        behind = tuple(map(cut, self.behind))
        most = float(self.openings.max())
        return replace(
            self, tips=(first, second), behind=behind, openings=self.openings[stays], most=most
        )

    def _reach(self, sample: int) -> float:
        """How far [m] along both tips reach at one of the openings."""
        return min(float((tip.points[sample] @ self.along).max()) for tip in self.tips)

    @property
    def stroke(self) -> tuple[float, float]:
        """The smallest and the largest opening [m]."""
        return max(float(self.openings.min()), 0.0), max(float(self.openings.max()), 0.0)

    @property
    def tip_z(self) -> float:
        """How far [m] along both tips reach at every opening."""
        return min(self._reach(k) for k in range(len(self.openings)))

    @property
    def notes(self) -> tuple[str, ...]:
        """What was decided, for people."""
        axis = "xyz"[int(np.argmax(np.abs(self.along)))]
        low, high = (1000 * opening for opening in self.stroke)
        first, second = (tip.name for tip in self.tips)
        notes = [
            f"fingers {first} and {second} open by {low:.1f} to {high:.1f} mm; the TCP is between "
            f"them, {1000 * self.tip_z:.1f} mm along {axis} of the root link"
        ]
        if high + 1 < 1000 * self.most:
            notes.append(
                f"it opens up to {1000 * self.most:.1f} mm; wider its tips draw back, which "
                "straight fingers cannot: --widest-mm takes more of it"
            )
        if self.along[2] < 0.5:
            notes.append("the gripper does not point along z of its root link: look at its pose")
        if self.behind:
            names = ", ".join(link.name for link in self.behind)
            notes.append(f"{names}: counted as body at all places that they get to")
        return tuple(notes)

    def tool(self, robot: Robot, name: str) -> Tool:
        """The tool, in the frame of the robot's root link."""
        poses = robot.link_poses({})
        body = [
            Solid(solid.name, solid.shape, poses[link.name] * solid.T_owner_shape, GREY)
            for link in robot.links
            if link.name not in self.moving
            for solid in link.collision or link.visual
        ]
        body += [_hull(link.name, np.concatenate(link.points), GREY) for link in self.behind]
        fingers = []
        for tip, sense in zip(self.tips, (1.0, -1.0), strict=True):
            steps = np.clip(self.openings, 0.0, None) / 2 * sense
            pairs = zip(tip.points, steps, strict=True)
            closed = np.concatenate([points - step * self.apart for points, step in pairs])
            fingers.append(Finger(_hull(tip.name, closed, DARK), sense * self.apart))
        R = np.column_stack([np.cross(self.apart, self.along), self.apart, self.along])
        p = self.tip_z * self.along + self.middle * self.apart
        return Tool(name, pin.SE3(R, p), tuple(body), tuple(fingers), self.stroke)


def _hull(name: str, points: Floats, colour: tuple[float, float, float]) -> Solid:
    around = trimesh.PointCloud(points).convex_hull
    hull = hull_of(Mesh(np.asarray(around.vertices), np.asarray(around.faces)))
    if hull is None:
        raise InputError(f"link {name} is flat")
    return Solid(name, hull, pin.SE3.Identity(), colour)


def _goes_along(link: _Moving, tip: _Moving) -> bool:
    """Whether a link goes as the tip of its finger does, and turns no more than that."""
    shifts = tip.middles - tip.middles[0]
    return all(
        float(np.abs(points - shift - link.points[0]).max()) < SAME_WAY
        for points, shift in zip(link.points, shifts, strict=True)
    )


def _joined(links: Sequence[_Moving]) -> _Moving:
    """Links of one finger as one."""
    every = zip(*(link.points for link in links), strict=True)
    return _Moving(links[-1].name, tuple(np.concatenate(points) for points in every))


def _nearest_axis(direction: Floats) -> Floats:
    axis = np.zeros(3)
    largest = int(np.argmax(np.abs(direction)))
    axis[largest] = np.sign(direction[largest]) or 1.0
    return axis


def _farthest(link: _Moving, along: Floats) -> float:
    return max(float((points @ along).max()) for points in link.points)
