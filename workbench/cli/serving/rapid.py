"""`workbench controller --rapid` and `workbench rapid`: RAPID modules, run and checked."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.devices.abb_simulated.faults import parse_fault
from workbench.model.cell import Cell
from workbench.model.errors import InputError

if TYPE_CHECKING:
    from workbench.devices.rapid.controller import Controller

MISSING = "RAPID needs the library lark: pip install 'workbench[rapid]'"

FAULTS = ("emergency-stop", "pointer-lost", "empty-hand")
"""Those of the simulated controller that a robot can have; the others are of the link."""

OPERATOR_PRESSES = 1
"""Who stands at a robot that goes home by itself says yes to every question."""


def run_modules(
    cell: Cell,
    folder: Path,
    *,
    host: str,
    port: int,
    speed: float,
    faults: Sequence[str],
    home_after: float | None,
    ready: Callable[[int, Callable[[], None]], None],
) -> None:
    """Run the modules of a folder until stopped.

    `ready` is given the port, and what ends it, before the first statement runs.

    Raises:
        InputError: lark is missing, a module cannot run, or a fault is none of a robot.
        LinkError: the port is taken.
    """
    try:
        from workbench.devices.rapid.controller import Controller, Operator
        from workbench.devices.rapid.setup import read_setup
    except ModuleNotFoundError as error:
        raise InputError(MISSING) from error
    operator = Operator()
    if home_after is not None:
        operator = Operator(usual=OPERATOR_PRESSES, comes_after=home_after)
    setup = read_setup(folder)
    one = Controller(cell, setup, host=host, port=port, speed=speed, operator=operator)
    _arrange(one, faults)
    ready(one.port, one.stop)
    one.run()


def _arrange(one: "Controller", faults: Sequence[str]) -> None:
    """Let faults happen: at the n-th motion of an arm, or the n-th grip."""
    left = [parse_fault(text) for text in faults]
    for fault in left:
        if fault.name not in FAULTS:
            raise InputError(f"fault {fault.name} is not one of RAPID's: {', '.join(FAULTS)}")
    counts = {"moves": 0, "grips": 0}
    usual = one.closes_at

    def moves(task: str) -> None:
        counts["moves"] += 1
        for fault in [f for f in left if f.name != "empty-hand" and f.after <= counts["moves"]]:
            left.remove(fault)
            if fault.name == "emergency-stop":
                one.later(one.emergency_stop)
            else:
                one.later(lambda: one.lose_pointer(task))

    def closes_at(task: str) -> float:
        counts["grips"] += 1
        for fault in [f for f in left if f.name == "empty-hand" and f.after <= counts["grips"]]:
            left.remove(fault)
            return 0.0
        return usual(task)

    one.before_move, one.closes_at = moves, closes_at
