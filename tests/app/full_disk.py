"""A disk that is full for a while, as the journal meets it."""

from workbench.journal.journal import Journal
from workbench.model.errors import JournalError


class FullDisk:
    """A disk that is full until the test says so."""

    def __init__(self, monkeypatch):
        self.tries = 0
        self._append, self._patch = Journal.append, monkeypatch

    def fill(self, *, after=0):
        """From now on, or after so many more entries, nothing can be written."""
        left = [after]

        def append(journal, *arguments):
            if left[0] > 0:
                left[0] -= 1
                return self._append(journal, *arguments)
            self.tries += 1
            raise JournalError("no space left on device")

        self._patch.setattr(Journal, "append", append)

    def free(self):
        self._patch.setattr(Journal, "append", self._append)
