"""How fast a browser may speak: what is too much waits, and of two values the newest is kept."""

from collections import deque
from dataclasses import dataclass

from workbench.web.page.messages import BrowserMessage, is_press, subject

PER_SECOND = 80.0
"""Messages in the long run; a busy hand makes some 40."""

AT_ONCE = 160
"""Messages that may come together before the rest has to wait."""

MOST_WAITING = 256
"""Messages; a browser that has more of them is no hand."""


@dataclass(slots=True)
class _Waiting:
    message: BrowserMessage


class RateLimit:
    """Messages of one browser on their way to viser, in order.

    Nothing is lost: a press waits its turn, a value is overtaken only by a newer one of the same
    widget; never past a press, which would then see a value from after it.

    Concurrency: one thread.
    """

    def __init__(self, now: float, per_second: float = PER_SECOND, at_once: int = AT_ONCE) -> None:
        """Nothing has been sent; `now` [s] is of the clock that `ready` is asked with."""
        self._per_second = per_second
        self._at_once = float(at_once)
        self._credit = float(at_once)
        self._counted = now
        self._queue: deque[_Waiting] = deque()
        self._newest: dict[tuple[str, str], _Waiting] = {}

    def __len__(self) -> int:
        """How many wait."""
        return len(self._queue)

    def add(self, message: BrowserMessage) -> bool:
        """Take a message; False when too many wait already."""
        if is_press(message):
            self._newest.clear()
        else:
            earlier = self._newest.get(subject(message))
            if earlier is not None:
                earlier.message = message
                return True
        if len(self._queue) >= MOST_WAITING:
            return False
        entry = _Waiting(message)
        self._queue.append(entry)
        if not is_press(message):
            self._newest[subject(message)] = entry
        return True

    def ready(self, now: float) -> BrowserMessage | None:
        """The next message that may go at this time [s], if any may."""
        self._credit = min(self._at_once, self._credit + (now - self._counted) * self._per_second)
        self._counted = now
        if not self._queue or self._credit < 1.0:
            return None
        self._credit -= 1.0
        entry = self._queue.popleft()
        if not is_press(entry.message) and self._newest.get(subject(entry.message)) is entry:
            del self._newest[subject(entry.message)]
        return entry.message

    def patience(self) -> float:
        """How long [s] until one more may go; as of the last call of `ready`."""
        return max(0.0, (1.0 - self._credit) / self._per_second)
