"""The browser before which a plan is played: how much of it was really drawn there."""

import logging
import threading
import time
from collections.abc import Sequence

import viser

log = logging.getLogger(__name__)

LONGEST_GAP = 1.0
"""[s] On the plan's clock: between two drawings that a browser has confirmed lies no more."""

SIZE = 8
"""[pixels] Of the picture that a browser draws to confirm; nobody looks at it."""

AHEAD = 0.1
"""[s] What is asked about was sent so long before the question; viser gathers for 1/60 s."""


Span = tuple[float, float]
"""From and to [s] on the plan's clock."""


class Audience:
    """Asks one browser again and again to draw what it was sent, and believes only answers.

    A browser draws when its page is in front: one that is hidden, that hangs or that has gone does
    not answer.  What is drawn for everybody and the question travel apart, so the question comes
    a while later.  What was seen in several stretches counts together; what was drawn with the
    hands out of the picture does not.

    Lifetime: from construction until `close`, or until the browser has gone.

    Concurrency: a thread of its own, which waits for answers; any thread may call anything.
    """

    def __init__(self, client: viser.ClientHandle):
        """Nothing was seen yet.

        Args:
            client: the browser.
        """
        self._client = client
        self._changed = threading.Condition()
        self._stretch = 0
        self._is_on = self._is_closed = False
        self._drawn = self._seen = self._from = 0.0
        self._spans: tuple[Span, ...] = ((0.0, 0.0),)
        # When the hands were out of the picture: in this stretch, and in all.
        self._out: tuple[Span, ...] = ()
        self._outs: tuple[Span, ...] = ()
        threading.Thread(target=self._run, name="audience", daemon=True).start()

    def unseen(self, end: float) -> tuple[Span, ...]:
        """What of the plan, up to its end [s], was not seen yet: from and to [s], in order."""
        spans = self._spans
        ends = (*(begin for begin, _ in spans[1:]), end)
        return tuple(
            (seen, after) for (_, seen), after in zip(spans, ends, strict=True) if seen < after
        )

    def hidden(self, end: float) -> tuple[Span, ...]:
        """What of that, from and to [s], was drawn with the hands out of the picture."""
        return tuple(
            (max(begin, start), min(stop, until))
            for start, until in self.unseen(end)
            for begin, stop in self._outs
            if max(begin, start) < min(stop, until)
        )

    @property
    def is_on(self) -> bool:
        """Whether a stretch is being played."""
        return self._is_on

    @property
    def limit(self) -> float:
        """How far [s] the plan may be played now: further on it would not be seen."""
        return self._seen + LONGEST_GAP

    def begin(self, at: float) -> float:
        """A stretch is played from a time [s] on.

        Returns:
            From where: a little is repeated that was drawn before a pause, but perhaps not seen.
        """
        with self._changed:
            at = next((seen for _, seen in self._spans if seen < at <= seen + LONGEST_GAP), at)
            self._stretch += 1
            self._is_on = True
            self._drawn = self._seen = self._from = at
            self._out = ()
            self._changed.notify()
        return at

    def note_drawn(self, at: float) -> None:
        """The moment at a time [s] was sent to be drawn."""
        with self._changed:
            if self._is_on:
                self._drawn = at
                self._changed.notify()

    def out(self, begin: float, end: float) -> None:
        """From one time [s] to another the hands are out of the picture; before it is `drawn`."""
        with self._changed:
            self._out = join_spans(*self._out, (begin, end))
            self._outs = join_spans(*self._outs, (begin, end))

    def stop(self) -> None:
        """The stretch ends here; what is not confirmed now was not seen."""
        with self._changed:
            self._is_on = False

    def close(self) -> None:
        """Ask no more."""
        with self._changed:
            self._is_on, self._is_closed = False, True
            self._changed.notify()

    def _run(self) -> None:
        took = 0.0
        while True:
            with self._changed:
                self._changed.wait_for(
                    lambda: self._is_closed or (self._is_on and self._drawn > self._seen)
                )
                # A slow browser is asked seldom: the plan may go on meanwhile as far as it may.
                self._changed.wait_for(
                    lambda: self._is_closed or self._drawn >= self.limit, min(took, LONGEST_GAP)
                )
                asked = (self._stretch, self._drawn)
                self._changed.wait_for(lambda: self._is_closed, AHEAD)
                if self._is_closed:
                    return
            began = time.monotonic()
            try:
                # It waits until the browser draws, however long that takes, or has gone.
                self._client.get_render(SIZE, SIZE)
            except Exception as error:
                log.info("the browser that plays the plan does not draw it: %s", error)
            else:
                self._confirm(*asked)
            took = time.monotonic() - began

    def _confirm(self, stretch: int, at: float) -> None:
        with self._changed:
            if not self._is_on or stretch != self._stretch:
                return
            self._seen = max(self._seen, at)
            self._spans = join_spans(*self._spans, *without((self._from, self._seen), self._out))


def join_spans(*spans: Span) -> tuple[Span, ...]:
    """Stretches [s] in order, those that meet as one."""
    found: list[Span] = []
    for begin, end in sorted(spans):
        if found and begin <= found[-1][1]:
            found[-1] = (found[-1][0], max(found[-1][1], end))
        else:
            found.append((begin, end))
    return tuple(found)


def without(span: Span, outs: Sequence[Span]) -> tuple[Span, ...]:
    """What is left of a stretch [s] where others, in order and apart, are taken out of it."""
    begin, end = span
    found: list[Span] = []
    for first, last in outs:
        if begin < min(first, end):
            found.append((begin, min(first, end)))
        begin = max(begin, last)
    return (*found, (begin, end)) if begin < end else tuple(found)
