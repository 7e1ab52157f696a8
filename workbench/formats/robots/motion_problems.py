"""Motion problems in files: a robot, where it starts, where it shall end, and what is in the way.

A file holds one set, for one robot whose URDF and SRDF lie beside it under the robot's name:
`{format: "motion-problems/1", robot, set, problems: [{name, start, goal, others, obstacles}]}`.
`start`, `goal` and `others` give joints by name [rad, m]; those of `others` stand still, and may be
left out.  Obstacles are `{name, shape, dimensions, object_pose, pose}` with lengths in m: of a box
its full lengths x, y, z, of a cylinder its height and radius, of a sphere its radius.  The pose of
a shape is `object_pose`, which may be null or left out, times `pose`, each `{position, orientation:
x y z w}`.  Other keys are ignored.

The shapes and dimensions are those of ROS (shape_msgs/SolidPrimitive); scenes like these are in
MotionBenchMaker (Chamzas et al., IEEE Robotics and Automation Letters 7(2), 2022).
"""

import re
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.formats.files.json_keys import read_json
from workbench.formats.files.toml_keys import Table, quote
from workbench.formats.files.whole_files import is_file
from workbench.formats.robots.urdf import read_srdf, read_urdf
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Cylinder, Floats, Shape, Solid, Sphere, own
from workbench.model.robot import Joint, Robot

FORMAT = "motion-problems/1"
SHAPES = ("box", "cylinder", "sphere")
ROBOT_NAME = r"[A-Za-z0-9_][A-Za-z0-9_.-]*"
"""What a robot may be called: a part of the name of a file, and never a path."""

FURTHEST = 1000.0
"""[m] Nothing lies further away or is larger."""

FULL_TURN = 4 * np.pi
"""[rad] Larger angles are taken for degrees."""

UNIT = 1e-3
"""By so much the length of a quaternion may differ from 1."""


@dataclass(frozen=True, slots=True, eq=False)
class MotionProblem:
    """From `start` to `goal` (n,) [rad, m] of `joints`, from base to tip, past the obstacles.

    All other joints of `robot` are fixed where the problem has them.
    """

    name: str
    robot: Robot
    joints: tuple[str, ...]
    start: Floats
    goal: Floats
    obstacles: tuple[Solid, ...]

    def __post_init__(self) -> None:
        own(self, "start", "goal")


@dataclass(frozen=True, slots=True, eq=False)
class MotionSet:
    """Problems of one kind for one robot."""

    name: str
    robot: str
    problems: tuple[MotionProblem, ...]


def read_motion_problems(folder: Path, robot: str | None = None) -> tuple[MotionSet, ...]:
    """The sets in a folder and in the folders in it, in the order of their files' names.

    Args:
        folder: with the files, or with a folder for each robot.
        robot: whose sets; None for all.

    Raises:
        InputError: no such folder, no problems in it, or none for that robot.
        FileError: a file cannot be used; it says which key.
    """
    if not folder.is_dir():
        raise InputError(f"{folder}: there is no such folder")
    paths = sorted([*folder.glob("*.json"), *folder.glob("*/*.json")])
    tables = [read_json(path, FORMAT) for path in paths]
    names = [_robot_name(table) for table in tables]
    wanted = [k for k, name in enumerate(names) if robot in (None, name)]
    if not paths:
        raise InputError(f"{folder}: there are no motion problems (*.json) in it")
    if not wanted:
        known = ", ".join(sorted(set(names)))
        raise InputError(f"{folder}: no problems for robot {quote(robot)}; there are for {known}")
    robots: dict[Path, Robot] = {}
    sets: list[MotionSet] = []
    for k in wanted:
        described = paths[k].with_name(f"{names[k]}.urdf")
        if described not in robots:
            robots[described] = _robot(tables[k], described)
        sets.append(_set(tables[k], names[k], robots[described]))
    return tuple(sets)


def _robot_name(table: Table) -> str:
    name = table.text("robot")
    if not re.fullmatch(ROBOT_NAME, name):
        raise table.error("robot", f"{quote(name)} is not the name of a robot")
    return name


def _robot(table: Table, path: Path) -> Robot:
    if not is_file(path):
        raise table.error("robot", f"its description {path.name} is not beside this file")
    robot, pairs = read_urdf(path), path.with_suffix(".srdf")
    return replace(robot, disabled_pairs=read_srdf(pairs)) if is_file(pairs) else robot


def _set(table: Table, name: str, robot: Robot) -> MotionSet:
    problems = tuple(_problem(problem, robot) for problem in table.tables("problems"))
    if not problems:
        raise table.error("problems", "there are none in it")
    table.once("problems", [problem.name for problem in problems])
    return MotionSet(table.text("set"), name, problems)


def _problem(table: Table, robot: Robot) -> MotionProblem:
    start, goal = _joint_values(table, "start", robot), _joint_values(table, "goal", robot)
    others = _joint_values(table, "others", robot) if table.has("others") else {}
    movable = [joint for joint in robot.joints if joint.kind != "fixed"]
    moving = tuple(joint.name for joint in movable if joint.name in start)
    if len(moving) != len(start) or not moving:
        still = [name for name in start if name not in moving]
        problem = f"joint {quote(still[0])} is fixed" if still else "names no joint"
        raise table.error("start", problem)
    for joint in movable:
        if joint.name not in start and joint.name not in others:
            raise table.error("start", f"joint {quote(joint.name)} is missing, here and in others")
    if start.keys() != goal.keys():
        names = ", ".join(quote(name) for name in moving)
        raise table.error("goal", f"the joints of start are expected: {names}")
    fixed = {name: value for name, value in others.items() if name not in start}
    held = replace(robot, joints=tuple(_fix(joint, fixed) for joint in robot.joints))
    if not any(set(moving) <= _movable_before(held, link.name) for link in held.links):
        raise table.error("start", "its joints are not one chain from the base to a link")
    return MotionProblem(
        table.text("name"),
        held,
        moving,
        np.array([start[name] for name in moving]),
        np.array([goal[name] for name in moving]),
        tuple(_obstacles(table)),
    )


def _joint_values(table: Table, key: str, robot: Robot) -> dict[str, float]:
    """What a table says of joints [rad, m], by name."""
    values = table.table(key)
    kinds = {joint.name: joint.kind for joint in robot.joints}
    for name in values.names():
        if name not in kinds:
            raise values.error(name, f"robot {robot.name} has no such joint")
    most = {name: FURTHEST if kinds[name] == "prismatic" else FULL_TURN for name in kinds}
    return {name: values.number(name, low=-most[name], high=most[name]) for name in values.names()}


def _fix(joint: Joint, values: dict[str, float]) -> Joint:
    """The joint fixed at its value, if it has one and can move."""
    return joint.at(values[joint.name]) if joint.name in values else joint


def _movable_before(robot: Robot, link: str) -> set[str]:
    return {joint.name for joint in robot.chain(link) if joint.kind != "fixed"}


def _obstacles(table: Table) -> Iterator[Solid]:
    for obstacle in table.tables("obstacles"):
        kind = obstacle.text("shape", among=SHAPES)
        T = _pose(obstacle.table("pose"))
        if obstacle.has("object_pose") and not obstacle.is_null("object_pose"):
            T = _pose(obstacle.table("object_pose")) * T
        yield Solid(obstacle.text("name"), _shape(obstacle, kind), T)


def _shape(table: Table, kind: str) -> Shape:
    count = {"box": 3, "cylinder": 2, "sphere": 1}[kind]
    size = table.numbers("dimensions", count, low=0.0, high=FURTHEST)
    if not size.all():
        raise table.error("dimensions", "all have to be larger than 0")
    if kind == "box":
        return Box(size)
    return (
        Cylinder(float(size[1]), float(size[0])) if kind == "cylinder" else Sphere(float(size[0]))
    )


def _pose(table: Table) -> pin.SE3:
    p = table.numbers("position", 3, low=-FURTHEST, high=FURTHEST)
    turn = table.numbers("orientation", 4, low=-2.0, high=2.0)
    if abs(np.linalg.norm(turn) - 1.0) > UNIT:
        raise table.error("orientation", "is not a unit quaternion x, y, z, w")
    return pin.SE3(pin.Quaternion(turn / np.linalg.norm(turn)).matrix(), p)
