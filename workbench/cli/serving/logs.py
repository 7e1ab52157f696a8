"""Where the log of a server goes: words to standard error, or objects to files that stay small."""

import json
import logging
import logging.handlers
from pathlib import Path

from workbench.model.errors import FileError

LARGEST_LOG = 10 * 2**20
"""[bytes] A file of the log is turned when it would become larger."""

OLD_FILES = 5
"""Files before the current one."""

WORDS = "%(asctime)s %(name)s: %(message)s"


class Objects(logging.Formatter):
    """A record as one line of JSON: time [s since the epoch], level, logger, message."""

    def format(self, record: logging.LogRecord) -> str:
        """The line, without its end."""
        said = {"at": round(record.created, 3), "level": record.levelname, "logger": record.name}
        said["message"] = record.getMessage()
        if record.exc_info:
            said["traceback"] = self.formatException(record.exc_info)
        return json.dumps(said, ensure_ascii=False)


def begin_log(path: Path | None) -> None:
    """Have warnings and what is worse logged, to standard error and, where given, to a file.

    Raises:
        FileError: the file cannot be written.
    """
    logging.basicConfig(level=logging.WARNING, format=WORDS)
    if path is None:
        return
    try:
        handler = logging.handlers.RotatingFileHandler(
            path, maxBytes=LARGEST_LOG, backupCount=OLD_FILES, encoding="utf-8"
        )
    except (OSError, ValueError) as error:
        raise FileError(path, getattr(error, "strerror", None) or "cannot be written") from None
    handler.setFormatter(Objects())
    logging.getLogger().addHandler(handler)
