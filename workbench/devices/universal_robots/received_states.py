"""What the client reports of the controller, checked before anything is done with it."""

import math
from dataclasses import dataclass
from typing import Any

from workbench.devices.universal_robots.rtde import RUNNING_MODE, STANDS
from workbench.model.cell import Arm, Cell
from workbench.model.errors import ProtocolError
from workbench.model.geometry import Floats
from workbench.plugins.report_checks import bounds_of, check_time

MODES = {
    -1: "has no controller",
    0: "is disconnected",
    1: "waits for a confirmation of its safety configuration",
    2: "starts",
    3: "is powered off",
    4: "is powered on, its brakes are not released",
    5: "is idle, its brakes are not released",
    6: "is in free drive",
    8: "updates its firmware",
}

SAFETY = {
    2: "protective stop",
    3: "recovery mode",
    4: "safeguard stop",
    5: "system emergency stop",
    6: "robot emergency stop",
    7: "emergency stop",
    8: "safety violation",
    9: "safety fault",
    10: "stopped for safety",
}
"""Bits of `safety_status_bits`."""


@dataclass(frozen=True, slots=True, eq=False)
class UrState:
    """One report of the controller, `at` [s] of its own clock; `q` (6,) [rad] in chain order.

    `leg` is what register `PROGRESS` holds, `begun` what those of `BEGUN` do.
    """

    at: float
    q: Floats
    mode: int
    safety: int
    runtime: int
    leg: int
    begun: tuple[int, ...]

    @property
    def fault(self) -> str:
        """What speaks against moving; empty when nothing does."""
        stops = [words for bit, words in SAFETY.items() if self.safety >> bit & 1]
        if stops:
            return ", ".join(stops)
        if self.mode == RUNNING_MODE:
            return ""
        return f"the robot {MODES.get(self.mode, f'is in mode {self.mode}')}"

    @property
    def stands(self) -> bool:
        """Whether no program moves the robot."""
        return self.runtime in STANDS


class States:
    """The states in the messages of a client, each once.

    Lifetime: one connection.
    """

    def __init__(self, cell: Cell, arm: Arm) -> None:
        self._arm, self._bounds = arm, bounds_of(cell, arm)
        self._at = -math.inf

    def take(self, message: dict[str, Any] | None, *, in_motion: bool = True) -> UrState | None:
        """A state that is news; None where this is none: the client reports the last one again.

        Args:
            message: from the client.
            in_motion: whether a program of ours moves the arm.

        Raises:
            ProtocolError: a number in it is none, or cannot be, or the clock goes back.
        """
        if message is None or "q" not in message:
            return None
        at = check_time(message["at"], "a time")
        if at < self._at:
            raise ProtocolError(
                f"the controller's clock goes back, from {self._at:.3f} to {at:.3f} s"
            )
        if at == self._at:
            return None
        self._at = at
        if len(message["q"]) != len(self._arm.joints):
            raise ProtocolError(f"the controller reports {len(message['q'])} axes, 6 are expected")
        q = self._bounds.take(self._arm.from_axes(message["q"]), in_motion=in_motion)
        mode, safety, runtime, leg = (
            message[name] for name in ("mode", "safety", "runtime", "leg")
        )
        return UrState(at, q, mode, safety, runtime, leg, tuple(message.get("begun", ())))
