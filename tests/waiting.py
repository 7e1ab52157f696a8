"""How long tests wait for what must happen, and how long what they need is good."""

import time
from collections.abc import Callable
from dataclasses import replace

from workbench.model.release import Approval

PATIENCE = 300.0
"""[s] Far more than it takes, also on a machine where others compute."""


def wait_until(condition: Callable[[], bool], what: str = "it") -> None:
    """Wait for what must happen; a test fails when it does not."""
    until = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < until, f"waited {PATIENCE:.0f} s in vain for {what}"
        time.sleep(0.02)


def lasting(approval: Approval) -> Approval:
    """The same approval, good for hours: several tests share it, and some machines are slow."""
    return replace(approval, until=approval.at + 100 * PATIENCE)
