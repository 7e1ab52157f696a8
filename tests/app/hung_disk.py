"""A disk that hangs in the middle of an append, until the test lets it go on."""

import threading
from contextlib import contextmanager

from waiting import PATIENCE


class HungDisk:
    """Appends of one journal wait from `hang` on, until `free`."""

    def __init__(self, journal, monkeypatch):
        self._hangs, self._may_end = threading.Event(), threading.Event()
        self._journal, self._append, self._patch = journal, journal.append, monkeypatch

    @contextmanager
    def during(self, *commanded):
        """While the block runs, what `commanded` tells a bench's `do` hangs at the disk."""
        do, *arguments = commanded
        self._patch.setattr(self._journal, "append", self._wait)
        thread = threading.Thread(target=do, args=arguments)
        thread.start()
        try:
            assert self._hangs.wait(PATIENCE)
            yield
        finally:
            self.free()
            thread.join(PATIENCE)

    def free(self):
        self._may_end.set()

    def _wait(self, *words):
        self._hangs.set()
        assert self._may_end.wait(PATIENCE)
        return self._append(*words)
