"""RAPID modules as a simulated controller: where `abb_simulated` stands otherwise."""

import math
from collections.abc import Callable

from workbench.devices.abb_simulated.faults import Fault, parse_fault
from workbench.devices.rapid.controller import Operator, RapidController
from workbench.formats.rapid.setup import read_setup
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.plugins.robot_link import Running, Simulation

FAULTS = ("emergency-stop", "pointer-lost", "empty-hand")
"""Those that a robot can have; the others are of the link.  They count motions, or grips."""

YES = 1
"""The key that an operator presses who sends robots home by himself."""


def serve_modules(cell: Cell, asked: Simulation, ready: Callable[[Running], None]) -> None:
    """Run the modules of the folder `asked.rapid` until stopped.

    Raises:
        InputError: a module cannot run, or something is asked for that only a simulation can do.
        LinkError: the port is taken.
    """
    if asked.rapid is None or asked.record is not None or asked.trace is not None:
        raise InputError("--record and --trace are of the simulated controller, not of --rapid")
    faults = [parse_fault(text) for text in asked.faults]
    for fault in faults:
        if fault.name not in FAULTS:
            raise InputError(f"fault {fault.name} is none of RAPID's: {', '.join(FAULTS)}")
    operator = Operator()
    if asked.home_after < math.inf:
        operator = Operator(usual=YES, comes_after=asked.home_after)
    controller = RapidController(
        cell,
        read_setup(asked.rapid),
        host=asked.host,
        port=asked.port,
        speed=asked.speed,
        operator=operator,
    )
    _arrange(controller, faults)
    ready(controller)
    controller.run()


def _arrange(controller: RapidController, left: list[Fault]) -> None:
    """Let faults happen: at the n-th motion of an arm, or the n-th grip."""
    counts, usual = {"moves": 0, "grips": 0}, controller.closes_at

    def due(what: str, names: tuple[str, ...]) -> list[Fault]:
        counts[what] += 1
        found = [f for f in left if f.name in names and f.after <= counts[what]]
        left[:] = [f for f in left if f not in found]
        return found

    def before_move(task: str) -> None:
        for fault in due("moves", FAULTS[:2]):
            is_emergency = fault.name == "emergency-stop"
            controller.later(
                controller.emergency_stop if is_emergency else lambda: controller.lose_pointer(task)
            )

    def closes_at(task: str) -> float:
        return 0.0 if due("grips", FAULTS[2:]) else usual(task)

    controller.before_move, controller.closes_at = before_move, closes_at
