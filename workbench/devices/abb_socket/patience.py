"""How long the two ends of a robot link wait for each other, and by which clock."""

import time
from collections.abc import Callable
from dataclasses import dataclass

SILENCE = 2.0
"""[s] Without a word from the other side, and an `abb-socket/2` link counts as dead."""


@dataclass(frozen=True, slots=True)
class Patience:
    """What a link bears; the values are those that safety wants, tests bring others.

    Times are in seconds of `clock`, which never goes back.
    """

    silence: float = SILENCE
    """`abb-socket/2`: without a word while it is spoken."""

    answer: float = 30.0
    """`abb-socket`: the robot moves between two requests; longer than this is too long."""

    stop: float = 2.0
    """How long a controller may take to acknowledge a stop."""

    report: float = 1.0
    """How long a report of the state may lag behind what the controller has done."""

    doubt: float = 0.3
    """A controller that reports a fault mostly says so on the link as well, and better."""

    clock: Callable[[], float] = time.monotonic


USUAL = Patience()
