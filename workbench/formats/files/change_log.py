"""Logs of changes next to the changed files: one JSON object a line."""

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from workbench.model.errors import FileError

LOG = "changes.log"


def utc(at: float) -> str:
    """A time [s since the epoch] as files have it, in whole seconds."""
    return datetime.fromtimestamp(at, UTC).strftime("%Y-%m-%dT%H:%M:%SZ")


def add_line(log: Path, entry: Mapping[str, Any]) -> None:
    """Add a line to a log, which is made when it is not there.

    Raises:
        FileError: it cannot be written.
    """
    try:
        with log.open("a", encoding="utf-8") as file:
            file.write(json.dumps(entry, ensure_ascii=False) + "\n")
    except OSError as error:
        raise FileError(log, error.strerror or "cannot be written") from None
