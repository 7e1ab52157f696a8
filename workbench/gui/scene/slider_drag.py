"""A value that is dragged: what it gives is shown at once, what it asks for once the hand rests.

viser 1.1.1 reports each value during a drag, and not its end.  A command for each value would fill
the journal, and discard repeatedly what was computed with the value before.
"""

import threading
from collections.abc import Callable

REST = 0.4
"""[s] A hand that rests for that long has chosen."""


class SliderDrag:
    """What is asked for at the end of each drag of a slider, once.

    Lifetime: that of the browser's controls; `drop` with them, since who goes in the middle of a
    drag has not let go.

    Concurrency: any thread; it is asked for in a timer's, or in that of `finish`.
    """

    def __init__(self, ask: Callable[[], object], rest: float = REST):
        """Nothing is dragged.

        Args:
            ask: asks for the value that the slider has then; raises nothing.
            rest: [s] for which no other value has to come.
        """
        self._ask, self._rest = ask, rest
        self._timer: threading.Timer | None = None
        self._lock, self._asking = threading.Lock(), threading.Lock()

    @property
    def is_under_way(self) -> bool:
        """Whether something is still to be asked for: until then the slider is the hand's."""
        return self._timer is not None

    def note_move(self) -> None:
        """There is another value: the drag ends so much later."""
        timer = threading.Timer(self._rest, lambda: self._end(timer))
        timer.daemon = True
        self._replace(timer)
        timer.start()

    def finish(self) -> None:
        """End the drag, if there is one, now: before something that depends on its value."""
        self._end(self._timer)

    def drop(self) -> None:
        """Ask for nothing: the value was taken otherwise, or who has dragged it is gone."""
        self._replace(None)

    def _replace(self, timer: threading.Timer | None) -> None:
        with self._lock:
            before, self._timer = self._timer, timer
        if before is not None:
            before.cancel()

    def _end(self, timer: threading.Timer | None) -> None:
        # Who finishes waits for what is being asked for already.
        with self._asking:
            with self._lock:
                if timer is None or self._timer is not timer:
                    return
                self._timer = None
            timer.cancel()
            self._ask()
