"""One arm of the twin: it follows references, and its RAPID module runs each command once."""

import math

import numpy as np

from workbench.devices.abb_egm import wire
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats

TAU = 0.02
"""[s] Of the filter that references go through."""

COMM_TIMEOUT = 250
"""[reports] 1 s without an answer, and EGM stops."""

MOST_DEVIATION = np.deg2rad(30.0)
"""[rad] A reference this far from the arm is an error."""

CONVERGED = np.deg2rad(0.05)

GRIPPER = 25
"""[reports] What the gripper takes."""

SECONDS = wire.PERIOD_MS / 1000

HOMING = 1.0
"""[rad/s] Of each joint on its way home, where nobody leads the arm."""

LOAD = 7
"""Where the load begins in the numbers of an order."""

MOST_TICKETS = 16
"""This many of the last tickets are remembered, and not begun again."""


class TwinArm:
    """Where it is, what it is reported, and how its EGM stands."""

    def __init__(self, cell: Cell, arm: Arm, home_after: float = math.inf) -> None:
        """Stand at home.

        Args:
            cell: with its joints' speeds.
            arm: of the cell.
            home_after: [s] without an answer, after which somebody clears its faults, and sends it
                home.
        """
        self.arm, self._home_after = arm, home_after
        self.axes: Floats = arm.to_axes(arm.home)
        self._home = self.axes.copy()
        velocity = cell.robot.limits(arm.joints)[2]
        self._fastest = np.abs(arm.to_axes(velocity)) * SECONDS
        self._target = self.axes.copy()
        self.motors, self.mci = wire.MOTORS_ON, wire.MCI_RUNNING
        self.is_stuck = False
        self.is_attached, self.is_prompt = False, False
        self._unanswered, self._number = 0, 0
        # Before the first plan there is nothing to end either.
        self._ticket, self._done, self._busy, self._has_ended = 0.0, 0.0, 0, True
        self._begun, self._refused = list[float](), 0.0
        self._order: tuple[float, ...] = ()
        self.leg = 0
        self.load: tuple[float, ...] = ()
        """What it carries, as `abb_loads` has it; empty until it is reported."""
        self.orders: list[tuple[float, ...]] = []

    def take(self, said: wire.Reference) -> bool:
        """A sensor's answer; whether an order in it is new."""
        self.is_attached, self.is_prompt, self._unanswered = True, True, 0
        if len(said.axes) == len(self.axes) and self.mci == wire.MCI_RUNNING:
            if np.abs(said.axes - self.axes).max() > MOST_DEVIATION:
                self.mci = wire.MCI_ERROR
            else:
                self._target = said.axes
        if len(said.orders) < 6 or said.orders[0] != wire.VERSION:
            return False
        _, ticket, number, command = said.orders[:4]
        self.leg = int(said.orders[6]) if len(said.orders) > 6 else 0
        if command == wire.BEGIN and ticket != self._ticket:
            if ticket in self._begun:
                self._refused = ticket
                return False
            self._ticket, self._done, self._order, self._has_ended = ticket, 0.0, (), False
            self._begun = [*self._begun, ticket][-MOST_TICKETS:]
        at = self._order[2] if self._order else self._done
        if ticket != self._ticket or number <= at or command == wire.NONE or self._has_ended:
            return False
        self._order = said.orders[:6]
        load = list(said.orders)[LOAD : LOAD + 11]
        if command == wire.GRIP and load and load[0] > 0:
            self.load = tuple(load)
        self._busy = GRIPPER if command == wire.GRIP else 1
        self.orders.append(self._order)
        return True

    def go(self) -> None:
        """One period later."""
        self._unanswered += 1
        if self.is_attached and self._unanswered > COMM_TIMEOUT:
            self.is_attached, self.leg = False, 0
            # Outside of a plan a module takes up EGM again; otherwise a person looks first.
            if not self._has_ended:
                self.mci = wire.MCI_STOPPED
        if self._order and self._busy:
            self._busy -= 1
            if not self._busy:
                self._done = self._order[2]
                self._has_ended = self._order[3] == wire.END
                self.is_prompt = self.is_prompt and not self._has_ended
        if not self.is_attached and self._unanswered * SECONDS > self._home_after:
            self._go_home()
        if self.motors == wire.MOTORS_ON and self.mci == wire.MCI_RUNNING and not self.is_stuck:
            step = (self._target - self.axes) * SECONDS / (TAU + SECONDS)
            self.axes = self.axes + np.clip(step, -self._fastest, self._fastest)

    def _go_home(self) -> None:
        """One period nearer to home; once there it can be led again."""
        most = np.minimum(self._fastest, HOMING * SECONDS)
        self.axes = self.axes + np.clip(self._home - self.axes, -most, most)
        self._target = self.axes
        if np.array_equal(self.axes, self._home):
            self.motors, self.mci, self.is_stuck = wire.MOTORS_ON, wire.MCI_RUNNING, False

    def report(self, at: int) -> wire.Feedback:
        """What EGM reports at a time [ms]."""
        self._number = (self._number + 1) % (1 << 32)
        is_near = bool(np.abs(self._target - self.axes).max() < CONVERGED)
        words = (wire.VERSION, self._ticket, self._done, self._refused)
        return wire.Feedback(
            self._number, at, self.axes, self.motors, self.mci, wire.RAPID_RUNNING, is_near, words
        )
