"""A robot link on a machine that does much else: only what really never comes is missed."""

import functools
import time

from waiting import PATIENCE

from workbench.plugins import robot_link
from workbench.plugins.robot_link import LinkPatience

PATIENT = LinkPatience(
    silence=PATIENCE, answer=PATIENCE, stop=PATIENCE, report=PATIENCE, doubt=PATIENCE
)

send = functools.partial(robot_link.send, patience=PATIENT)


class Hurried:
    """A clock that goes like the others until so much time is let pass at once."""

    def __init__(self) -> None:
        self._passed = 0.0

    def __call__(self) -> float:
        return time.monotonic() + self._passed

    def let_pass(self, seconds: float) -> None:
        self._passed += seconds
