"""A robot link on a machine that does much else: only what really never comes is missed."""

import functools
import time

from waiting import PATIENCE

from workbench.devices.abb_socket import link as abb_link
from workbench.devices.abb_socket.patience import Patience

PATIENT = Patience(
    silence=PATIENCE, answer=PATIENCE, stop=PATIENCE, report=PATIENCE, doubt=PATIENCE
)

send = functools.partial(abb_link.send, patience=PATIENT)


class Hurried:
    """A clock that goes like the others until so much time is let pass at once."""

    def __init__(self) -> None:
        self._passed = 0.0

    def __call__(self) -> float:
        return time.monotonic() + self._passed

    def let_pass(self, seconds: float) -> None:
        self._passed += seconds
