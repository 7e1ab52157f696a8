"""Files read and written as a whole: never more than expected, never half."""

import contextlib
import hashlib
import os
import re
import shutil
import threading
from collections.abc import Collection
from pathlib import Path

from workbench.model.errors import FileError

MB = 1024 * 1024

Stamp = tuple[int, int]
"""When a file was written [ns], and its size [bytes]."""


def read_whole(path: Path, most: int) -> bytes:
    """The content of a file of at most `most` bytes.

    Devices and pipes have no size to ask for beforehand, so the reading itself is bounded.

    Raises:
        FileError: not there, not to be read, or longer.
    """
    try:
        with path.open("rb") as file:
            content = file.read(most + 1)
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be read") from None
    except ValueError:  # a name that no file can have, such as one with a NUL
        raise FileError(repr(str(path)), "is not the name of a file") from None
    if len(content) > most:
        raise FileError(path, f"is longer than {most / MB:g} MB, the most that is read")
    return content


def write_whole(path: Path, content: bytes) -> None:
    """Put `content` into a file that afterwards is either the new one or still the old one.

    Who may read and write it stays as it was.

    Raises:
        FileError: the folder is not there, or cannot be written to.
    """
    try:
        if path.exists() and not path.is_file():  # a device or a pipe cannot be replaced
            path.write_bytes(content)
            return
        target = path.resolve()
        # A name of its own for each thread: two that write the same file must not mix.
        partial = target.with_name(f".{os.getpid()}-{threading.get_ident()}.partial")
        try:
            partial.write_bytes(content)
            if target.exists():
                shutil.copymode(target, partial)
            partial.replace(target)
        except OSError:
            with contextlib.suppress(OSError):
                partial.unlink()
            raise
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be written") from None
    except ValueError:
        raise FileError(repr(str(path)), "is not the name of a file") from None


def make_folder(folder: Path) -> None:
    """Make a folder, and those above it, if it is not there.

    Raises:
        FileError: it cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, error.strerror or "cannot be made") from None


def stamps(folder: Path, kinds: Collection[str]) -> dict[Path, Stamp]:
    """The files in a folder whose names end like one of `kinds`, hidden ones left out.

    Raises:
        OSError: the folder cannot be read.
    """
    found: dict[Path, Stamp] = {}
    for path in folder.iterdir():
        if path.suffix.lower() in kinds and not path.name.startswith("."):
            with contextlib.suppress(OSError):  # it was renamed in between
                status = path.stat()
                found[path] = (status.st_mtime_ns, status.st_size)
    return found


def is_file(path: Path) -> bool:
    """Whether there is a file; also for names that no file can have."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def file_name(name: str) -> str:
    """A file name for a thing of any name: another one for each, and never a path."""
    plain = re.sub(r"[^A-Za-z0-9_.-]", "_", name)[:100]
    return plain if plain == name else f"{plain}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"
