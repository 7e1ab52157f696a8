"""`workbench controller`: the simulated one, in a process of its own."""

import logging
import math
import sys
import threading
from collections.abc import Callable
from dataclasses import replace
from queue import SimpleQueue

from workbench.app.core.cycle.arm_scanner import view_named
from workbench.cli.arguments import top as arguments
from workbench.cli.serving.ending import queue_end_signals
from workbench.cli.terminal import check_number, check_whole, print_json
from workbench.formats.cells.reading import read_cell
from workbench.plugins.robot_link import Running, Simulation, link_named

HIGHEST_PORT = 65535


def controller(typed: arguments.ControllerArguments) -> int:
    """Run the simulated controller until SIGINT, SIGTERM, or the end of standard input."""
    state_port = typed.state_port
    if state_port is None:
        state_port = typed.port + 1 if typed.port else 0
    check_whole("--port", typed.port, 0, HIGHEST_PORT)
    check_whole("--state-port", state_port, 0, HIGHEST_PORT)
    check_number("--speed", typed.speed, 0.01, 1000)
    if typed.home_after is not None:
        check_number("--home-after", typed.home_after, 0.0, 3600.0)
    logging.basicConfig(level=logging.INFO, format="%(asctime)s %(message)s")
    cell = read_cell(typed.cell)
    if typed.before_view:
        carrier = view_named(cell, "")
        arms = (replace(a, home=carrier.home) if a.name == carrier.arm else a for a in cell.arms)
        cell = replace(cell, arms=tuple(arms))

    def ready(running: Running) -> None:
        _end_with(running.stop, typed.until_eof)
        ports = {"host": typed.host, "port": running.port, "state_port": running.state_port}
        if typed.json:
            print_json(ports)
        else:
            what = "RAPID" if typed.rapid is not None else "simulated controller"
            state = (
                f"state on {typed.host}:{running.state_port}" if running.state_port else "no state"
            )
            print(
                f"{what} of cell {cell.name}: motion on {typed.host}:{running.port}, {state}; "
                "Ctrl-C ends it",
                flush=True,
            )

    simulation = Simulation(
        host=typed.host,
        port=typed.port,
        state_port=state_port,
        speed=typed.speed,
        record=typed.record,
        trace=typed.trace,
        faults=typed.fault,
        home_after=math.inf if typed.home_after is None else typed.home_after,
        rapid=typed.rapid,
    )
    link_named(cell.controller.link).serve(cell, simulation, ready)
    return 0


def _end_with(stop: Callable[[], None], at_eof: bool) -> None:
    """Stop at SIGINT, SIGTERM, and perhaps the end of standard input."""
    signals = queue_end_signals()

    def end() -> None:
        signals.get()
        stop()

    threading.Thread(target=end, daemon=True).start()
    if at_eof:
        threading.Thread(target=_signal_at_eof, args=(signals,), daemon=True).start()


def _signal_at_eof(signals: "SimpleQueue[int]") -> None:
    while sys.stdin.buffer.read(4096):
        pass
    signals.put(0)
