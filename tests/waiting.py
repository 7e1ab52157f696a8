"""How long tests wait for what must happen."""

import time
from collections.abc import Callable

PATIENCE = 300.0
"""[s] Far more than it takes, also on a machine where others compute."""


def wait_until(condition: Callable[[], bool], what: str = "it") -> None:
    """Wait for what must happen; a test fails when it does not."""
    until = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < until, f"waited {PATIENCE:.0f} s in vain for {what}"
        time.sleep(0.02)
