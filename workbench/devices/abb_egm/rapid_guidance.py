r"""Instructions of EGM for modules in RAPID that are executed: an arm, its UDP devices, its motion.

ABB's manual of EGM (3HAC073318) was not to be had.  What stands here is what modules say that
others have published and run, and what ABB's people answered, at github.com: `abb_libegm` (issues
104 and 125), `abb_robot_driver` (issue 29), examples of `ABB-EGM-Python`:

- EGMGetId, EGMSetupUC, EGMActJoint and EGMRunJoint follow each other, after a fine point; EGMReset
  gives an identity back.  EGMStreamStart states where the arm is, and hears nothing.
- While EGMRunJoint runs, the arm follows the references that are answered to its messages, and the
  program waits there; traps run.  It ends by EGMStop, or when all axes were within their
  `egm_minmax` of the references for `\CondTime`; with EGM_STOP_HOLD the arm stays where it is.
- Nothing heard for `\CommTimeout`, 1 s where it is not said, is ERR_UDPUC_COMM.
- `\DataFromSensor` holds the numbers of the last answer, `\DataToSensor` goes with each message.

Other arguments and ways to stop are not modelled: they are refused by their names.
"""

# The prelude gives the types of what natives take, and every call is checked against it.
# pyright: reportUnknownLambdaType=false

import math
import socket
from collections.abc import Callable, Mapping
from contextlib import suppress
from typing import Any

import numpy as np

from workbench.devices.abb_egm import wire
from workbench.devices.rapid.motion import TIME_STEP, Mechanism
from workbench.devices.rapid.tasks import Task
from workbench.formats.rapid.problems import RapidError, RapidStop
from workbench.formats.rapid.values import Place
from workbench.model.errors import LinkError

USUAL_TIMEOUT = 1.0
"""[s]"""

UNITS = {1: "ROB1", 2: "ROB2", 3: "ROBL", 4: "ROBR"}
"""Mechanical units by the numbers that the prelude gives them."""

MOST_ID = 4
"""A task has this many identities."""


class Guidance:
    """EGM of one task; `step` has to be called once for each step of the robots' time.

    Args:
        task: that moves the arm.
        mechanism: the arm.
        ports: where its devices send to, by name: (`motion` or `states`, port).
        host: of the sensor.
        own: from where messages come; it is closed with this.
        waits: whether silence counts only once somebody has answered.
    """

    def __init__(
        self,
        task: Task,
        mechanism: Mechanism,
        ports: Mapping[str, tuple[str, int]],
        host: str,
        own: socket.socket,
        *,
        waits: bool = False,
    ) -> None:
        self._task, self._arm, self._ports, self._host = task, mechanism, ports, host
        self._socket = own
        self._socket.setblocking(False)
        self._devices: dict[int, tuple[str, int, float]] = {}
        self._used: set[int] = set()
        self._active: dict[int, dict[str, Any]] = {}
        self._streams: dict[int, int] = {}
        self._running: int | None = None
        self._ticks, self._numbers = 0, dict[int, int]()
        self._target, self._converged = np.array(mechanism.here), 0
        self._unheard, self._error, self._waits = 0, "", waits
        self._is_heard = False
        self.is_prompt = False
        """Whether the last message was answered."""

    def fileno(self) -> int:
        """For `select`."""
        return self._socket.fileno()

    def close(self) -> None:
        """Let the port go."""
        self._socket.close()

    def natives(self) -> dict[str, Callable[..., Any]]:
        """By small name."""
        return {
            "egmreset": self._reset,
            "egmgetid": self._get_id,
            "egmsetupuc": self._set_up,
            "egmstreamstart": self._stream,
            "egmactjoint": self._act,
            "egmrunjoint": self._run,
            "egmstop": lambda ident, mode: self._stop(self._find(ident)),
        }

    # -- instructions

    def _find(self, place: Place) -> int:
        number = int(place[0][place[1]])
        if number not in self._used:
            raise RapidStop("this egmident has no identity: EGMGetId comes first")
        return number

    def _reset(self, place: Place) -> None:
        number = int(place[0][place[1]])
        for kept in (self._devices, self._active, self._streams, self._numbers):
            kept.pop(number, None)
        self._used.discard(number)
        place[0][place[1]] = 0.0

    def _get_id(self, place: Place) -> None:
        free = [k for k in range(1, MOST_ID + 1) if k not in self._used]
        if not free:
            raise RapidStop("all identities of EGM are taken: EGMReset gives one back")
        self._used.add(free[0])
        place[0][place[1]] = float(free[0])

    def _set_up(
        self, unit: float, place: Place, config: str, device: str, joint: Any, timeout: float | None
    ) -> None:
        number = self._find(place)
        if UNITS[int(unit)] != self._task.name.replace("_", "").removeprefix("T").upper():
            raise RapidStop(f"{self._task.name} does not move {UNITS[int(unit)]}")
        if device not in self._ports:
            raise RapidStop(f"there is no UDPUC device {device!r}")
        if not joint:
            raise RapidStop("EGMSetupUC without \\Joint is not executed here")
        self._devices[number] = (*self._ports[device], timeout or USUAL_TIMEOUT)

    def _device(self, place: Place, kind: str) -> int:
        number = self._find(place)
        if number not in self._devices:
            raise RapidStop("EGMSetupUC comes first")
        if self._devices[number][0] != kind:
            raise RapidStop(f"this device is configured for {self._devices[number][0]}")
        return number

    def _stream(self, place: Place, rate: float | None) -> None:
        self._streams[self._device(place, "states")] = _periods(rate)

    def _act(self, place: Place, to: Place | None, given: Place | None, *more: Any) -> None:
        *windows, bandwidth, rate, fastest = more
        number = self._device(place, "motion")
        if _periods(rate) != 1:
            raise RapidStop("EGMActJoint with another \\SampleRate than 4 is not executed here")
        count = len(self._arm.here)
        if any(window is None for window in windows[:count]):
            raise RapidStop(f"EGMActJoint without \\J1 to \\J{count} is not executed here")
        limits = np.array([self._window(window) for window in windows[:count]])
        delay = 1 / (2 * math.pi * bandwidth) if bandwidth else 0.0
        self._active[number] = {
            "to": to, "from": given, "limits": limits, "delay": delay,
            "fastest": fastest or math.inf,
        }  # fmt: skip

    def _window(self, window: list[float]) -> list[float]:
        if not window[0] <= 0 <= window[1]:
            raise RapidStop(f"egm_minmax [{window[0]:g},{window[1]:g}] does not hold 0")
        return window

    def _run(self, place: Place, mode: float, *more: Any) -> None:
        *axes, seconds = more
        number = self._find(place)
        if number not in self._active:
            raise RapidStop("EGMActJoint comes first")
        if not all(axes[: len(self._arm.here)]):
            raise RapidStop("EGMRunJoint that does not lead all axes is not executed here")
        if not self._arm.is_standing:
            raise RapidStop("EGM begins at a fine point only")
        self._target, self._converged, self._unheard = np.array(self._arm.here), 0, 0
        self._error, self._running, self._arm.is_guided = "", number, True
        self._is_heard = not self._waits
        wanted = max(round((1.0 if seconds is None else seconds) / TIME_STEP), 1)
        try:
            self._task.wait(lambda: self._is_over(number, wanted))
        finally:
            self._running, self._arm.is_guided, self.is_prompt = None, False, False
        if self._error:
            raise RapidError(self._error)

    def _is_over(self, number: int, wanted: int) -> bool:
        return self._running != number or bool(self._error) or self._converged >= wanted

    def _stop(self, number: int) -> None:
        if self._running == number:
            self._running = None

    # -- one step of the robots' time

    def step(self) -> bool:
        """Follow, and tell; whether an answer is awaited."""
        self._ticks += 1
        for number, periods in self._streams.items():
            if self._ticks % periods == 1 or periods == 1:
                self._say(self._report(number, ()), self._devices[number][1])
        if self._running is None:
            return False
        active, (_, port, timeout) = self._active[self._running], self._devices[self._running]
        self._unheard += self._is_heard
        if self._unheard * TIME_STEP > timeout:
            self._error = "ERR_UDPUC_COMM"
            return False
        if not self._arm.stops:
            self._follow(active)
        place = active["to"]
        words = tuple(place[0][place[1]]) if place else ()
        self._say(self._report(self._running, words), port)
        return self.is_prompt

    def _follow(self, active: dict[str, Any]) -> None:
        off = self._target - self._arm.here
        most = np.minimum(self._arm.axes.velocity, active["fastest"]) * TIME_STEP
        # As the filter lets it, and no faster than it may.
        self._arm.here = self._arm.here + np.clip(
            off * TIME_STEP / (active["delay"] + TIME_STEP), -most, most
        )
        off = self._target - self._arm.here
        limits = active["limits"]
        is_in = bool(np.all((off >= limits[:, 0]) & (off <= limits[:, 1])))
        self._converged = self._converged + 1 if is_in else 0

    def _report(self, ident: int, words: tuple[float, ...]) -> wire.Feedback:
        self._numbers[ident] = (self._numbers.get(ident, 0) + 1) % (1 << 32)
        # Motors are off in a stop, and EGM with them.
        motors = wire.MOTORS_OFF if self._arm.stops else wire.MOTORS_ON
        runs = wire.RAPID_RUNNING if self._task.is_running else wire.RAPID_STOPPED
        return wire.Feedback(
            self._numbers[ident],
            round(self._ticks * TIME_STEP * 1000) % (1 << 32),
            np.deg2rad(self._arm.here),
            motors,
            wire.MCI_RUNNING,
            runs,
            self._converged > 0,
            words,
        )

    def _say(self, feedback: wire.Feedback, port: int) -> None:
        with suppress(OSError):  # nobody listens yet
            self._socket.sendto(wire.feedback_bytes(feedback), (self._host, port))

    def hear(self) -> None:
        """Take what was answered."""
        while True:
            try:
                data = self._socket.recv(wire.LONGEST_MESSAGE)
            except OSError:
                return
            with suppress(LinkError):  # what is no answer of a sensor is no fault of the controller
                self._take(wire.read_reference(data))

    def _take(self, said: wire.Reference) -> None:
        if self._running is None:
            return
        self._unheard, self._is_heard, self.is_prompt = 0, True, True
        if len(said.axes) == len(self._arm.here):
            self._target = np.rad2deg(np.asarray(said.axes, dtype=np.float64))
        if (given := self._active[self._running]["from"]) is not None:
            array = given[0][given[1]]
            array[: len(said.orders)] = said.orders[: len(array)]


def _periods(rate: float | None) -> int:
    """Of 4 ms, between two messages."""
    periods = (rate or wire.PERIOD_MS) / wire.PERIOD_MS
    if periods < 1 or periods != int(periods):
        raise RapidStop("\\SampleRate is a multiple of 4 ms")
    return int(periods)
