"""SIGINT and SIGTERM: how a person ends a running command."""

import signal
from queue import SimpleQueue
from types import FrameType


def queue_end_signals() -> "SimpleQueue[int]":
    """A queue that holds the number of each SIGINT and SIGTERM from now on.

    A queue of this kind has no lock that Python knows: the one of a `threading.Event` may be held
    by the very thread that the signal interrupts, which would then wait for itself for good.
    """
    signals: SimpleQueue[int] = SimpleQueue()

    def put_signal(signum: int, frame: FrameType | None) -> None:
        signals.put(signum)

    signal.signal(signal.SIGINT, put_signal)
    signal.signal(signal.SIGTERM, put_signal)
    return signals
