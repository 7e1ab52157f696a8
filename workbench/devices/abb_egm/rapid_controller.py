"""A controller that runs modules in RAPID with EGM: where the twin stands otherwise."""

import math
import select
import time
from collections.abc import Callable
from typing import Any

from workbench.devices.abb_egm.rapid_guidance import Guidance
from workbench.devices.abb_egm.twin import LOCKSTEP, OTHER_ARM_WAIT, free_ports, socket_beside
from workbench.devices.rapid.controller import Operator, RapidController
from workbench.devices.rapid.motion import Mechanism
from workbench.devices.rapid.tasks import Task
from workbench.formats.rapid.setup import Setup, read_setup
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.plugins.robot_link import Running, Simulation

UNHEARD = 0.001
"""[s] Between two messages that nobody answers, faster than in real time."""

PORT_KINDS = ("motion", "states")


class GuidedController(RapidController):
    """A controller with EGM; `port` and `state_port` are UDP, those of the sensor's side.

    Faster than in real time it waits a little for each answer: nobody has to be as fast, and EGM
    does not end before the first one.
    """

    def __init__(
        self,
        cell: Cell,
        setup: Setup,
        *,
        host: str = "127.0.0.1",
        port: int = 0,
        state_port: int = 0,
        speed: float = 1.0,
        operator: Operator | None = None,
    ) -> None:
        """Load everything.

        Args:
            cell: whose arms the tasks move.
            setup: tasks, and the devices of EGM.
            host: where the sensor listens, and from where messages come.
            port: of the sensor for the first arm of the cell, the next arm has the next; 0: free.
            state_port: the same for states.
            speed: of the robots' time; 1 is real time.
            operator: who stands at the robot.

        Raises:
            InputError: a module cannot run, or a device is of no arm.
        """
        count, ports = len(cell.arms), {"motion": port, "states": state_port}
        for kind in PORT_KINDS:
            while not ports[kind] or abs(ports["motion"] - ports["states"]) < count:
                ports[kind] = free_ports(host, count)
        self._sensor, self._ports, self._in_haste = host, ports, speed > 1.0
        self._arms = [arm.name for arm in cell.arms]
        self._guidances: list[Guidance] = []
        self.when_led: Callable[[], None] | None = None
        """Called once, as soon as every arm can be led or its program has ended."""
        try:
            super().__init__(cell, setup, host=host, speed=speed, operator=operator)
        except InputError:
            self._close()
            raise

    def more_natives(self, task: Task) -> dict[str, Callable[..., Any]]:
        """EGM, for tasks that move an arm."""
        arm = self.setup.tasks[task.name].arm
        if not arm or not isinstance(task.mechanism, Mechanism):
            return {}
        ports: dict[str, tuple[str, int]] = {}
        for name, words in self.setup.devices.items():
            if len(words) != 2 or words[0] not in PORT_KINDS or words[1] not in self._arms:
                raise InputError(
                    f"device {name}: `motion` or `states` and an arm of the cell are expected, "
                    f"not {', '.join(words)}"
                )
            if words[1] == arm:
                ports[name] = (words[0], self._ports[words[0]] + self._arms.index(arm))
        count = len(self._arms)
        own = socket_beside(
            self._sensor, {first + k for first in self._ports.values() for k in range(count)}
        )
        guidance = Guidance(task, task.mechanism, ports, self._sensor, own, waits=self._in_haste)
        self._guidances.append(guidance)
        return guidance.natives()

    @property
    def port(self) -> int:
        """Where the first arm's messages go."""
        return self._ports["motion"]

    @property
    def state_port(self) -> int:
        """Where the first arm's states go."""
        return self._ports["states"]

    def advance(self) -> None:
        """One step, with a message of each arm and what is answered."""
        super().advance()
        awaited = [guidance for guidance in self._guidances if guidance.step()]
        if self._in_haste and not awaited:
            time.sleep(UNHEARD)
        until = time.monotonic() + LOCKSTEP
        while awaited and self._in_haste and (left := until - time.monotonic()) > 0:
            ready = select.select(awaited, [], [], left)[0]
            for guidance in ready:
                guidance.hear()
                awaited.remove(guidance)
                until = min(until, time.monotonic() + OTHER_ARM_WAIT)
        for guidance in awaited:
            guidance.is_prompt = not self._in_haste and guidance.is_prompt
        for guidance in self._guidances:
            guidance.hear()

    def turn(self) -> None:
        """Everybody's turn once."""
        super().turn()
        if self.when_led is not None and all(
            mechanism.is_guided or not self.tasks[name].is_running
            for name, mechanism in self.mechanisms.items()
        ):
            until, self.when_led = self.when_led, None
            until()

    def run(self) -> None:
        """Run the programs until `stop`."""
        try:
            super().run()
        finally:
            self._close()

    def _close(self) -> None:
        for guidance in self._guidances:
            guidance.close()


def serve_guided(cell: Cell, asked: Simulation, ready: Callable[[Running], None]) -> None:
    """Run the modules of the folder `asked.rapid` until stopped.

    Raises:
        InputError: a module cannot run, or something is asked for that only the twin can do.
    """
    assert asked.rapid is not None
    if asked.record is not None or asked.trace is not None or asked.faults:
        raise InputError("--record, --trace and --fault are of the twin, not of --rapid")
    operator = Operator()
    if asked.home_after < math.inf:
        raise InputError("--home-after: these modules move no arm by themselves")
    controller = GuidedController(
        cell,
        read_setup(asked.rapid),
        host=asked.host,
        port=asked.port,
        state_port=asked.state_port,
        speed=asked.speed,
        operator=operator,
    )
    # Whoever connects waits for a moment only.
    controller.when_led = lambda: ready(controller)
    controller.run()
