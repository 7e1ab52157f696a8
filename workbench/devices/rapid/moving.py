r"""Instructions that move a robot, its gripper, and functions on where it is.

Source: Technical reference manual: RAPID instructions, functions and data types (3HAC050917);
Product manual: Grippers for IRB 14000 (3HAC054949).  A time \\T and a speed give how long a way
takes, but no axis is faster than it can be.  The gripper counts what one finger travels, in mm.
"""

# The prelude gives the types of what natives take, and every call is checked against it.
# pyright: reportUnknownLambdaType=false

import copy
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import pinocchio as pin

from workbench.devices.rapid.kinematics import Axes
from workbench.devices.rapid.motion import TIME_STEP, JointWay, Mechanism
from workbench.devices.rapid.tasks import Task
from workbench.formats.rapid.problems import RapidError, RapidStop
from workbench.formats.rapid.values import single
from workbench.model.geometry import Floats

UNUSED = 9e9
"""What stands where there is no axis."""

FINGER_STROKE = 25.0
"""[mm] Of one finger."""

HAND_SECONDS = 0.2
"""[s] Of the robot's time, for any way of the fingers."""

PIECE = 0.01
"""[m] Between two computed points of a linear motion."""


class SmartGripper:
    """A Smart Gripper: where its fingers are [mm], and whether its next motion fails."""

    def __init__(self) -> None:
        self.position = self.until = 0.0
        self.is_calibrated = self.has_fault = False


class MotionInstructions:
    """These instructions, for one task; `mechanisms` are those of all tasks, by task."""

    def __init__(
        self,
        task: Task,
        mechanisms: Mapping[str, Mechanism],
        time: Callable[[], float],
        moved: Callable[[], None],
        gripped: Callable[[], float],
    ) -> None:
        """For a task.

        Args:
            task: whose instructions these are.
            mechanisms: the robots by the names of their tasks.
            time: the robot's [s].
            moved: called before each move.
            gripped: how far [mm] a finger is out when the hand has closed.
        """
        self._task, self._mechanisms, self._time = task, mechanisms, time
        self._moved, self._gripped = moved, gripped
        self.hand = SmartGripper()

    def natives(self) -> dict[str, Callable[..., Any]]:
        """By small name."""
        hand = self.hand
        return {
            "moveabsj": lambda target, number, no_offsets, *given: self._move_axes(
                target, number, *given[:-1]
            ),
            "movej": lambda *given: self._move_tool(
                *given[:-1], frame=given[-1], is_straight=False
            ),
            "movel": lambda *given: self._move_tool(*given[:-1], frame=given[-1], is_straight=True),
            "gripload": self._grip_load,
            "stopmove": lambda quick, all_tasks: self._stops(all_tasks, True),
            "startmove": lambda all_tasks: self._stops(all_tasks, False),
            "stopmovereset": lambda all_tasks: self._stops(all_tasks, False),
            "clearpath": lambda: self._mine().clear(),
            "isstopmoveact": lambda *given: "program" in self._mine().stops,
            "cjointt": lambda name: _joint_target(self._of(name).here),
            "crobt": lambda name, tool, frame: self._target(self._of(name).here, tool, frame),
            "calcrobt": lambda joints, tool, frame: self._target(self._values(joints), tool, frame),
            "calcjointt": self._joints,
            "hand_initialize": self._initialize,
            "hand_moveto": self._hand_to,
            "hand_gripinward": lambda force, target, allow, no_wait: self._grip(True, no_wait),
            "hand_gripoutward": lambda force, target, allow, no_wait: self._grip(False, no_wait),
            "hand_iscalibrated": lambda: hand.is_calibrated,
            "hand_getactualpos": lambda: single(round(hand.position, 2)),
        }

    def _mine(self) -> Mechanism:
        if self._task.mechanism is None:
            raise RapidStop(f"{self._task.name} moves no robot")
        return self._task.mechanism

    def _of(self, name: str | None) -> Mechanism:
        if name is None or name == self._task.name:
            return self._mine()
        if name not in self._mechanisms:
            raise RapidError("ERR_TASKNAME")
        return self._mechanisms[name]

    def _axes(self) -> Axes:
        return self._mine().axes

    # -- moves

    def _grip_load(self, place: Any) -> None:
        """The payload from now on; what no robot can carry is refused."""
        load = place[0][place[1]]
        _check_load(load)
        self._mine().payload = copy.deepcopy(load)

    def _move_axes(
        self,
        target: list[list[float]],
        number: float | None,
        speed: list[float],
        seconds: float | None,
        zone: list[Any],
        tool: Any,
    ) -> None:
        mine = self._mine()
        goal = self._values(target)
        self._take(tool)
        self._go(np.array([mine.end, goal]), number, speed, seconds, zone, tool)

    def _take(self, tool: Any) -> None:
        """The tool of a motion is the one that the controller reckons with."""
        self._mine().tool_load = copy.deepcopy(tool[0][tool[1]][2])

    def _move_tool(
        self,
        target: list[Any],
        number: float | None,
        speed: list[float],
        seconds: float | None,
        zone: list[Any],
        tool: Any,
        *,
        frame: Any,
        is_straight: bool,
    ) -> None:
        self._take(tool)
        mine, axes = self._mine(), self._axes()
        start = axes.flange(mine.end)
        goal = _pose(target) if frame is None else _frame(frame) * _pose(target)
        goal = goal * _tool(tool).inverse()
        length = float(np.linalg.norm(goal.translation - start.translation))
        turn = float(np.linalg.norm(pin.log3(start.rotation.T @ goal.rotation)))
        pieces = max(1, int(np.ceil(max(length / PIECE, turn / 0.05)))) if is_straight else 1
        path = [mine.end]
        for share in np.linspace(0.0, 1.0, pieces + 1)[1:]:
            at = pin.SE3(
                start.rotation @ pin.exp3(share * pin.log3(start.rotation.T @ goal.rotation)),
                start.translation + share * (goal.translation - start.translation),
            )
            found = axes.reach(at, path[-1])
            if found is None:
                raise RapidStop("50050 Position outside reach")
            path.append(found)
        self._go(np.array(path), number, speed, seconds, zone, tool)

    def _go(
        self,
        path: Floats,
        number: float | None,
        speed: list[float],
        seconds: float | None,
        zone: list[Any],
        tool: Any,
    ) -> None:
        mine, axes, task = self._mine(), self._axes(), self._task
        for k, value in enumerate(path[-1]):
            if not axes.lower[k] - 1e-6 <= value <= axes.upper[k] + 1e-6:
                what = f"axis {k + 1} of {mine.name} cannot be at {value:g}"
                raise RapidStop(f"50027 Joint Out of Range: {what}")
        if mine.is_in_step != (number is not None):
            raise RapidStop("\\ID stands in synchronised movements, and in no others")
        begin, end = axes.flange(path[0]), axes.flange(path[-1])
        tip = _tool(tool)
        a, b = (begin * tip).translation, (end * tip).translation
        length = float(np.linalg.norm(b - a)) * 1000
        turn = float(np.rad2deg(np.linalg.norm(pin.log3(begin.rotation.T @ end.rotation))))
        least = float((np.abs(np.diff(path, axis=0)).max(axis=0) / axes.velocity).max())
        least = max(least * (len(path) - 1), TIME_STEP)
        if seconds is None:
            seconds = max(length / speed[0], turn / speed[1])
        is_stop, size = zone[0], zone[1]
        share = 0.0 if is_stop or length < 1e-6 else min(size / length, 0.5)
        way = JointWay(path, max(seconds, least), share, None if number is None else int(number))
        self._moved()
        mine.add(way)
        # A stop holds the program at the instruction; it goes on when the robot may.
        task.wait(lambda: mine.lets_on(way))

    def _stops(self, all_tasks: bool | None, is_stop: bool) -> None:
        if all_tasks:
            if self._task.mechanism is not None:
                raise RapidStop("\\AllMotionTasks is for tasks that move no robot")
            those = list(self._mechanisms.values())
        else:
            those = [self._mine()]
        for mechanism in those:
            (mechanism.stops.add if is_stop else mechanism.stops.discard)("program")

    # -- where it is

    def _values(self, target: list[list[float]]) -> Floats:
        return np.array([*target[0], *target[1]][: len(self._axes().home)])

    def _target(self, axes: Floats, tool: Any, frame: Any) -> list[Any]:
        T = self._axes().flange(axes)
        T = T if tool is None else T * _tool(tool)
        T = T if frame is None else _frame(frame).actInv(T)
        q = pin.Quaternion(T.rotation)
        turns = [float(np.floor(axes[k] / 90)) for k in (0, 3, 5)]
        external = _joint_target(axes)[1]
        position = [single(float(value) * 1000) for value in T.translation]
        rotation = [single(float(value)) for value in (q.w, q.x, q.y, q.z)]
        return [position, rotation, [*turns, 0.0], external]

    def _joints(self, target: list[Any], tool: Any, frame: Any) -> list[list[float]]:
        pose = _pose(target) if frame is None else _frame(frame) * _pose(target)
        found = self._axes().reach(pose * _tool(tool).inverse(), self._mine().here)
        if found is None:
            raise RapidError("ERR_ROBLIMIT")
        return _joint_target(found)

    # -- hand

    def _initialize(self, speed: Any, force: Any, limit: Any, calibrate: bool | None) -> None:
        if calibrate:
            self.hand.is_calibrated = True
            self._fingers(0.0, None)

    def _hand_to(self, position: float, no_wait: bool | None) -> None:
        if not 0 <= position <= FINGER_STROKE:
            raise RapidError("ERR_HAND_FAILEDMOVEPOS")
        self._ready("ERR_HAND_FAILEDMOVEPOS")
        self._fingers(position, no_wait)

    def _grip(self, is_inward: bool, no_wait: bool | None) -> None:
        self._ready("ERR_HAND_FAILEDGRIPPOS")
        self._fingers(self._gripped() if is_inward else FINGER_STROKE, no_wait)

    def _ready(self, fault: str) -> None:
        if not self.hand.is_calibrated:
            raise RapidError("ERR_HAND_NOTCALIBRATED")
        if self.hand.has_fault:
            self.hand.has_fault = False
            raise RapidError(fault)

    def _fingers(self, position: float, no_wait: bool | None) -> None:
        hand, time = self.hand, self._time
        hand.position, hand.until = position, time() + HAND_SECONDS
        if not no_wait:
            self._task.wait(lambda: time() >= hand.until)


def _check_load(load: list[Any]) -> None:
    mass, cog, aom, *moments = load
    _rotation(aom)
    if mass <= 0 or not any(cog) or min(moments) < 0:
        raise RapidStop(f"a load of {mass:g} kg at {cog} with inertia {moments} cannot be carried")


def _joint_target(axes: Floats) -> list[list[float]]:
    values = [single(float(value)) for value in axes] + [UNUSED] * (12 - len(axes))
    return [values[:6], values[6:]]


def _rotation(q: list[float]) -> Floats:
    found = np.array(q)
    if abs(np.linalg.norm(found) - 1.0) > 1e-3:
        raise RapidStop(f"[{', '.join(f'{value:g}' for value in q)}] is no orientation")
    return pin.Quaternion(*(found / np.linalg.norm(found))).matrix()


def _pose(target: list[Any]) -> pin.SE3:
    return pin.SE3(_rotation(target[1]), np.array(target[0]) / 1000)


def _tool(place: Any) -> pin.SE3:
    return _pose(place[0][place[1]][1])


def _frame(place: Any) -> pin.SE3:
    frame = place[0][place[1]]
    return _pose(frame[3]) * _pose(frame[4])
