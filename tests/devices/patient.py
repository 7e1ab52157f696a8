"""A robot link on a machine that does much else: only what really never comes is missed."""

import functools
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import Protocol, TypeVar

from waiting import PATIENCE

from workbench.devices.abb_simulated.controller import SimulatedController
from workbench.model.cell import Cell
from workbench.plugins import robot_link
from workbench.plugins.robot_link import LinkPatience, Simulation

PATIENT = LinkPatience(
    silence=PATIENCE, answer=PATIENCE, stop=PATIENCE, report=PATIENCE, doubt=PATIENCE
)

send = functools.partial(robot_link.send, patience=PATIENT)


class Runs(Protocol):
    """A controller."""

    def run(self) -> None: ...

    def stop(self) -> None: ...


Controller = TypeVar("Controller", bound=Runs)


@contextmanager
def in_threads() -> Generator[Callable[[Controller], Controller]]:
    """Runs controllers, each in a thread of its own, until the block ends."""
    running: list[tuple[Controller, threading.Thread]] = []

    def started(one: Controller) -> Controller:
        thread = threading.Thread(target=one.run)
        thread.start()
        running.append((one, thread))
        return one

    try:
        yield started
    finally:
        for one, thread in running:
            one.stop()
            thread.join(PATIENCE)
            assert not thread.is_alive()


@contextmanager
def running(cell: Cell) -> Generator[SimulatedController]:
    """A simulated ABB controller with the arms of a cell."""
    with in_threads() as started:
        yield started(SimulatedController(cell, Simulation(speed=1000.0), patience=PATIENT))


class Hurried:
    """A clock that goes like the others until so much time is let pass at once."""

    def __init__(self) -> None:
        self._passed = 0.0

    def __call__(self) -> float:
        return time.monotonic() + self._passed

    def let_pass(self, seconds: float) -> None:
        self._passed += seconds
