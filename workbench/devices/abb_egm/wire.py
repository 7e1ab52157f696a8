"""Messages of EGM: what a controller reports, what a sensor answers, and the numbers in both.

Fields and their numbers are those of `egm.proto` as RobotWare 7 has it; they are made here at run
time, in a pool of their own, since other packages bring the same names.  Angles are degrees on the
wire.  A controller's axis 7, as YuMi has it, is the first of `externalJoints`, after axes 1 to 6.

Sources: ABB, "Application manual - Externally Guided Motion RW7" (3HAC073318-001); field numbers as
in the foreign package `ABBRobotEGM` 1.0.7; the order of seven axes as in `abb_libegm`.
"""

import importlib
import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from workbench.model.errors import LinkError, ProtocolError
from workbench.model.geometry import Floats
from workbench.model.messages.devices import DeviceText
from workbench.plugins.extras import install_command

PERIOD_MS = 4
LONGEST_MESSAGE = 4096
"""[bytes] No message of EGM is longer."""

DATA, CORRECTION = 2, 3
MOTORS_ON, MOTORS_OFF = 1, 2
MCI_ERROR, MCI_STOPPED, MCI_RUNNING = 1, 2, 3
RAPID_STOPPED, RAPID_RUNNING = 1, 2
ROBOT_AXES = 6

VERSION = 1.0
"""First number of what both sides say beside the joints."""

NONE, BEGIN, GRIP, END = range(4)
"""Orders to the module in RAPID."""

DOUBLE, UINT64, BOOL, MESSAGE, UINT32, ENUM = 1, 4, 8, 11, 13, 14

# Message: field -> (number, type, name of the message).  An enumeration's first value is 0.
FIELDS: dict[str, dict[str, tuple[int, int, str]]] = {
    "EgmHeader": {"seqno": (1, UINT32, ""), "tm": (2, UINT32, ""), "mtype": (3, ENUM, "")},
    "EgmClock": {"sec": (1, UINT64, ""), "usec": (2, UINT64, "")},
    "EgmJoints": {"joints": (1, DOUBLE, "*")},
    "EgmPlanned": {
        "joints": (1, MESSAGE, "EgmJoints"),
        "externalJoints": (3, MESSAGE, "EgmJoints"),
        "time": (4, MESSAGE, "EgmClock"),
    },
    "EgmMotorState": {"state": (1, ENUM, "")},
    "EgmMCIState": {"state": (1, ENUM, "")},
    "EgmRapidCtrlExecState": {"state": (1, ENUM, "")},
    "EgmRAPIDdata": {"digVal": (1, BOOL, ""), "dnum": (2, DOUBLE, "*")},
    "EgmRobot": {
        "header": (1, MESSAGE, "EgmHeader"),
        "feedBack": (2, MESSAGE, "EgmPlanned"),
        "planned": (3, MESSAGE, "EgmPlanned"),
        "motorState": (4, MESSAGE, "EgmMotorState"),
        "mciState": (5, MESSAGE, "EgmMCIState"),
        "mciConvergenceMet": (6, BOOL, ""),
        "rapidExecState": (8, MESSAGE, "EgmRapidCtrlExecState"),
        "RAPIDfromRobot": (13, MESSAGE, "EgmRAPIDdata"),
    },
    "EgmSensor": {
        "header": (1, MESSAGE, "EgmHeader"),
        "planned": (2, MESSAGE, "EgmPlanned"),
        "RAPIDtoRobot": (4, MESSAGE, "EgmRAPIDdata"),
    },
}
REPEATED, OPTIONAL = 3, 1


@dataclass(frozen=True, slots=True)
class ModuleOrder:
    """The order to the module of an arm in RAPID, repeated with the joints of each reference.

    `ticket` names the approval, `number` counts orders, and `command` is one of `NONE`, `BEGIN`,
    `GRIP` and `END`.  `opening` [mm] of the fingers, 1 for `holding`; `leg` that runs, 0 between
    legs; `load` that the arm carries from then on, see `orders.Order`.
    """

    ticket: float
    number: int = 0
    command: int = NONE
    opening: float = 0.0
    holding: bool = False
    leg: int = 0
    load: tuple[float, ...] = ()

    @property
    def numbers(self) -> tuple[float, ...]:
        """As they go out in `RAPIDtoRobot.dnum`."""
        counts = map(float, (self.number, self.command))
        return (
            VERSION,
            self.ticket,
            *counts,
            self.opening,
            float(self.holding),
            float(self.leg),
            *self.load,
        )


@dataclass(frozen=True, slots=True)
class ModuleReport:
    """What the module answers: which order of which `ticket` is `done`, and a ticket `refused`."""

    ticket: float
    done: float
    refused: float | None


@dataclass(frozen=True, slots=True, eq=False)
class Feedback:
    """What a controller reports of one arm.

    `number` counts messages and `at` [ms] is the controller's clock, both modulo 2^32; `axes` (n,)
    [rad] in the controller's order; `rapid_values` are the numbers of the module in RAPID.
    """

    number: int
    at: int
    axes: Floats
    motors: int
    mci: int
    rapid: int
    is_converged: bool
    rapid_values: tuple[float, ...]

    @property
    def module(self) -> ModuleReport | None:
        """What the module in RAPID reports; None where none of this version runs."""
        if len(self.rapid_values) < 3 or self.rapid_values[0] != VERSION:
            return None
        _, ticket, done, *more = self.rapid_values
        return ModuleReport(ticket, done, more[0] if more else None)

    @property
    def fault(self) -> str:
        """What speaks against moving; empty when nothing does."""
        if self.motors != MOTORS_ON:
            return "the motors are off"
        if self.mci != MCI_RUNNING:
            words = {MCI_ERROR: "reports an error", MCI_STOPPED: "has stopped"}
            return f"EGM {words.get(self.mci, 'is in no known state')}"
        return "" if self.rapid == RAPID_RUNNING else "the RAPID program does not run"


@dataclass(frozen=True, slots=True, eq=False)
class Reference:
    """What the sensor's side answers: `axes` (n,) [rad] or (0,), and numbers for RAPID."""

    number: int
    axes: Floats
    orders: tuple[float, ...]


def module_of(arm: str, feedback: Feedback) -> ModuleReport:
    """What the module in RAPID of an arm reports.

    Raises:
        LinkError: none of this version runs.
    """
    if feedback.module is None:
        raise LinkError(DeviceText.MODULE_SILENT(arm=arm))
    return feedback.module


def read_feedback(data: bytes, axes: int) -> Feedback:
    """A report of an arm with this many axes.

    Raises:
        LinkError: it is none, or a number in it is none.
    """
    message = _parse("EgmRobot", data)
    if not message.HasField("header") or not message.HasField("feedBack"):
        raise ProtocolError("an EGM message without header or joints came")
    q = _axes(message.feedBack)
    if len(q) != axes:
        raise ProtocolError(f"the controller reports {len(q)} axes, {axes} are expected")
    words = tuple(message.RAPIDfromRobot.dnum)
    if not (np.all(np.isfinite(q)) and all(map(math.isfinite, words))):
        raise ProtocolError("the controller reports joints or orders that are no numbers")
    return Feedback(
        message.header.seqno,
        message.header.tm,
        q,
        message.motorState.state,
        message.mciState.state,
        message.rapidExecState.state,
        message.mciConvergenceMet,
        words,
    )


def feedback_bytes(feedback: Feedback) -> bytes:
    """As a controller says it."""
    message = _class("EgmRobot")()
    message.header.seqno, message.header.tm, message.header.mtype = (
        feedback.number,
        feedback.at,
        DATA,
    )
    _put_axes(message.feedBack, feedback.axes)
    message.feedBack.time.sec, ms = divmod(feedback.at, 1000)
    message.feedBack.time.usec = ms * 1000
    message.motorState.state, message.mciState.state = feedback.motors, feedback.mci
    message.rapidExecState.state = feedback.rapid
    message.mciConvergenceMet = feedback.is_converged
    message.RAPIDfromRobot.dnum.extend(feedback.rapid_values)
    return message.SerializeToString()


def reference_bytes(said: Reference, at: int) -> bytes:
    """As a sensor says it; `at` [ms] is the clock of the report that it answers."""
    message = _class("EgmSensor")()
    message.header.seqno, message.header.mtype = said.number, CORRECTION
    message.header.tm = at
    _put_axes(message.planned, said.axes)
    message.RAPIDtoRobot.dnum.extend(said.orders)
    return message.SerializeToString()


def read_reference(data: bytes) -> Reference:
    """An answer of a sensor.

    Raises:
        LinkError: it is none, or a number in it is none.
    """
    message = _parse("EgmSensor", data)
    axes, orders = _axes(message.planned), tuple(message.RAPIDtoRobot.dnum)
    if not (np.all(np.isfinite(axes)) and all(map(math.isfinite, orders))):
        raise ProtocolError("the sensor sends references or orders that are no numbers")
    return Reference(message.header.seqno, axes, orders)


def _axes(joints: Any) -> Floats:
    values = [*joints.joints.joints, *joints.externalJoints.joints]
    return np.deg2rad(np.array(values, dtype=np.float64))


def _put_axes(joints: Any, axes: Floats) -> None:
    degrees: Sequence[float] = np.rad2deg(axes).tolist()
    joints.joints.joints.extend(degrees[:ROBOT_AXES])
    joints.externalJoints.joints.extend(degrees[ROBOT_AXES:])


def _parse(name: str, data: bytes) -> Any:
    try:
        return _class(name).FromString(data)
    except Exception:  # the library throws another kind for each of its builds
        raise ProtocolError(f"a message of {len(data)} bytes came that is no {name}") from None


@cache
def _class(name: str) -> Any:
    return _classes()[name]


@cache
def _classes() -> dict[str, Any]:
    try:
        described: Any = importlib.import_module("google.protobuf.descriptor_pb2")
        pools: Any = importlib.import_module("google.protobuf.descriptor_pool")
        made: Any = importlib.import_module("google.protobuf.message_factory")
    except ModuleNotFoundError:
        raise LinkError(
            DeviceText.LIBRARY(library="protobuf", command=install_command("egm"))
        ) from None
    file = described.FileDescriptorProto(name="workbench_egm", package="abb.egm", syntax="proto2")
    states = file.enum_type.add(name="State")
    for value in range(5):
        states.value.add(name=f"STATE_{value}", number=value)
    for name, fields in FIELDS.items():
        message = file.message_type.add(name=name)
        for field, (number, kind, of) in fields.items():
            label = REPEATED if of == "*" else OPTIONAL
            descriptor = message.field.add(name=field, number=number, type=kind, label=label)
            if kind in (MESSAGE, ENUM):
                descriptor.type_name = f".abb.egm.{of or 'State'}"
    pool = pools.DescriptorPool()
    pool.Add(file)
    return {
        name: made.GetMessageClass(pool.FindMessageTypeByName(f"abb.egm.{name}")) for name in FIELDS
    }
