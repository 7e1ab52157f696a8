"""One program writes to a session: it holds a lock on the folder, which names it to the others."""

import fcntl
import json
import os
import socket
import time
from pathlib import Path

from workbench.model.errors import JournalError

LOCK_FILE = "writer.lock"


class Writer:
    """The right to write to a session's folder.

    Lifetime: from construction until `close`, or until the process dies, however that comes: the
    operating system takes the lock back. The file stays and says who was the last.
    """

    def __init__(self, folder: Path, at: float) -> None:
        """Take it.

        Args:
            folder: of the session.
            at: seconds since the epoch, for the message to later programs.

        Raises:
            JournalError: another program has it, or the folder cannot be written.
        """
        path = folder / LOCK_FILE
        try:
            self._file = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o644)
        except OSError as error:
            raise JournalError(f"{path}: cannot be written: {error.strerror}") from error
        try:
            fcntl.flock(self._file, fcntl.LOCK_EX | fcntl.LOCK_NB)
            owner = {"process": os.getpid(), "machine": socket.gethostname(), "since": at}
            os.ftruncate(self._file, 0)
            os.pwrite(self._file, json.dumps(owner).encode(), 0)
        except BlockingIOError as error:
            says = _owner(os.pread(self._file, 4096, 0))
            os.close(self._file)
            raise JournalError(f"{folder}: is written to by {says}") from error
        except OSError as error:
            os.close(self._file)
            raise JournalError(f"{path}: cannot be written: {error.strerror}") from error

    def close(self) -> None:
        """Give it back; once."""
        os.close(self._file)


def _owner(written: bytes) -> str:
    """Who has written this into the file, in words."""
    try:
        owner = json.loads(written)
        since = time.strftime("%Y-%m-%d %H:%M:%S UTC", time.gmtime(owner["since"]))
        return f"process {int(owner['process'])} on {owner['machine']!s} since {since}"
    except (ValueError, KeyError, TypeError, OverflowError, OSError):
        return "another program"
