"""A robot link on a machine that does much else: only what really never comes is missed."""

import functools
import time

from workbench.devices import abb_link
from workbench.devices.abb_patience import Patience

LONG = 120.0
"""[s] Far more than anything takes."""

PATIENT = Patience(silence=LONG, answer=LONG, stop=LONG, report=LONG, doubt=LONG)

send = functools.partial(abb_link.send, patience=PATIENT)


class Hurried:
    """A clock that goes like the others until so much time is let pass at once."""

    def __init__(self) -> None:
        self._passed = 0.0

    def __call__(self) -> float:
        return time.monotonic() + self._passed

    def let_pass(self, seconds: float) -> None:
        self._passed += seconds


def until(condition) -> None:
    """Wait for something that has no event to wait for."""
    deadline = time.monotonic() + LONG
    while not condition():
        assert time.monotonic() < deadline, "it did not happen"
        time.sleep(0.01)
