"""What is known of the robot, for the variables of OPC UA for Robotics; what is not stays unknown.

Nothing is made up: a variable without a reading here is reported with a status that says so.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from asyncua import ua
from asyncua.ua.status_codes import StatusCodes

from workbench.app.core.state import Phase, State
from workbench.app.runtime.live import Live
from workbench.model.cell import Arm, Cell
from workbench.model.derived.controller_axes import shown_axes, shown_units

NEVER = StatusCodes.BadNotConnected
"""Status of a value that no device reports to the workbench."""

NOT_NOW = StatusCodes.BadNoCommunication
"""It is reported at times, and not at this moment."""

OURS = StatusCodes.Uncertain
"""It is what the workbench has asked for: the controller does not say what it does itself."""

ROTARY, LINEAR = 1, 3
"""Of AxisMotionProfileEnumeration."""

OTHER, ARTICULATED = 0, 1
"""Of MotionDeviceCategoryEnumeration."""

CYCLE_MODE, STEP_MODE = 0, 2
"""Of ExecutionModeEnumeration."""

UNECE = "http://www.opcfoundation.org/UA/units/un/cefact"

Path = tuple[str, ...]
"""Names from the system down to a variable, its own the last."""

CONTROLLER, PROGRAM, TASK = "Controller", "LinkProgram", "Task"
SAFETY, MOTOR = "SafetyState", "Motor"


@dataclass(frozen=True, slots=True)
class Reading:
    """A value, None where there is none, and a status code of OPC UA (0 is good)."""

    value: Any = None
    kind: ua.VariantType = ua.VariantType.Null
    status: int = 0


UNKNOWN = Reading(status=NEVER)


def unit(code: str, symbol: str, words: str) -> Reading:
    """A unit by its code of UN/CEFACT Recommendation 20, as OPC 10000-8 (5.6.3) numbers them."""
    number = int.from_bytes(code.encode("ascii"), "big")
    found = ua.EUInformation(
        UNECE, ua.Int32(number), ua.LocalizedText(symbol), ua.LocalizedText(words)
    )
    return Reading(found, ua.VariantType.ExtensionObject)


DEGREES = unit("DD", "°", "degree [unit of angle]")
MILLIMETRES = unit("MMT", "mm", "millimetre")
CELSIUS = unit("CEL", "°C", "degree Celsius")


def axis_names(arm: Arm) -> tuple[str, ...]:
    """The axes of an arm, numbered as its controller counts them."""
    return tuple(f"Axis{number}" for number in range(1, len(arm.joints) + 1))


def train_names(arm: Arm) -> tuple[str, ...]:
    """The power trains of an arm: one for each axis, since nothing else is known."""
    return tuple(f"PowerTrain{number}" for number in range(1, len(arm.joints) + 1))


def readings(state: State, live: Live) -> Mapping[Path, Reading]:
    """What is known, by the variable that it is of."""
    cell = state.cell
    found: dict[Path, Reading] = {("ComponentName",): _text(cell.name)}
    for arm in cell.arms:
        found |= _of_arm(cell, arm, state, live.joints)
    controller: Path = ("Controllers", CONTROLLER)
    found[*controller, "ComponentName"] = _text(cell.controller.link)
    program = (*controller, "Software", PROGRAM)
    found[*program, "Model"] = _text(cell.controller.link)
    version = live.link.version
    found[*program, "SoftwareRevision"] = _string(version) if version else Reading(status=NOT_NOW)
    task: Path = (*controller, "TaskControls", TASK)
    found[*task, "ComponentName"] = _text(cell.controller.link)
    found |= _of_task(task, state, live)
    found["SafetyStates", SAFETY, "ComponentName"] = _text(cell.name)
    return found


def _of_arm(
    cell: Cell, arm: Arm, state: State, joints: Mapping[str, float]
) -> Mapping[Path, Reading]:
    own: Path = ("MotionDevices", arm.name)
    kinds = [cell.robot.joint(name).kind for name in arm.joints]
    is_articulated = len(kinds) >= 3 and set(kinds) == {"revolute"}
    found: dict[Path, Reading] = {
        (*own, "ComponentName"): _text(arm.name),
        (*own, "Model"): _text(cell.robot.name),
        (*own, "MotionDeviceCategory"): _number(ARTICULATED if is_articulated else OTHER),
        (*own, "ParameterSet", "SpeedOverride"): _speed(state),
    }
    # Where axes are coupled, one joint that is not reported leaves all of them unknown.
    shown = shown_axes(cell, arm, np.array([joints.get(name, math.nan) for name in arm.joints]))
    for axis, unit, value in zip(axis_names(arm), shown_units(cell, arm), shown, strict=True):
        is_linear = unit == "mm"
        whole: Path = (*own, "Axes", axis)
        found[*whole, "MotionProfile"] = _number(LINEAR if is_linear else ROTARY)
        position: Path = (*whole, "ParameterSet", "ActualPosition")
        found[position] = _position(float(value))
        found[*position, "EngineeringUnits"] = MILLIMETRES if is_linear else DEGREES
    for train in train_names(arm):
        temperature = (*own, "PowerTrains", train, MOTOR, "ParameterSet", "MotorTemperature")
        found[*temperature, "EngineeringUnits"] = CELSIUS
    return found


def _position(value: float) -> Reading:
    """Of `value` [deg or mm], NaN where none is reported."""
    known = Reading(value, ua.VariantType.Double)
    return known if math.isfinite(value) else Reading(status=NOT_NOW)


def _speed(state: State) -> Reading:
    """The share at which the plan goes out: ours, for the controller's own is not reported."""
    if state.phase is not Phase.SENDING or state.approval is None:
        return Reading(status=NOT_NOW)
    return Reading(state.approval.speed_share * 100, ua.VariantType.Double, OURS)


def _of_task(task: Path, state: State, live: Live) -> Mapping[Path, Reading]:
    """The plan that the controller carries out, while it reports its steps."""
    loaded: Path = (*task, "ParameterSet", "TaskProgramLoaded")
    name: Path = (*task, "ParameterSet", "TaskProgramName")
    mode: Path = (*task, "ParameterSet", "ExecutionMode")
    is_running = live.link.phase != "closed" and live.link.steps > 0
    approval = state.approval
    if state.phase is not Phase.SENDING or approval is None or not is_running:
        return dict.fromkeys((loaded, name, mode), Reading(status=NOT_NOW))
    return {
        loaded: Reading(True, ua.VariantType.Boolean),
        name: _string(approval.plan_digest),
        mode: _number(STEP_MODE if approval.is_stepped else CYCLE_MODE),
    }


def names(cell: Cell) -> Mapping[Path, Sequence[str]]:
    """What stands for the placeholders of the types, by the object that has them."""
    found: dict[Path, Sequence[str]] = {
        ("MotionDevices",): [arm.name for arm in cell.arms],
        ("Controllers",): [CONTROLLER],
        ("Controllers", CONTROLLER, "Software"): [PROGRAM],
        ("Controllers", CONTROLLER, "TaskControls"): [TASK],
        ("SafetyStates",): [SAFETY],
    }
    for arm in cell.arms:
        own: Path = ("MotionDevices", arm.name)
        found[*own, "Axes"] = axis_names(arm)
        found[*own, "PowerTrains"] = train_names(arm)
        for train in train_names(arm):
            found[*own, "PowerTrains", train] = [MOTOR]
    return found


def _text(text: str) -> Reading:
    return Reading(ua.LocalizedText(text), ua.VariantType.LocalizedText)


def _string(text: str) -> Reading:
    return Reading(text, ua.VariantType.String)


def _number(number: int) -> Reading:
    return Reading(number, ua.VariantType.Int32)
