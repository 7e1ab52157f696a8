"""Files read and written as a whole: never more than expected, never half."""

import contextlib
import os
from pathlib import Path

from workbench.model.errors import FileError

MB = 1024 * 1024


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

    Raises:
        FileError: the folder is not there, or cannot be written to.
    """
    try:
        if path.exists() and not path.is_file():  # a device or a pipe cannot be replaced
            path.write_bytes(content)
            return
        target = path.resolve()
        partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
        try:
            partial.write_bytes(content)
            partial.replace(target)
        except OSError:
            with contextlib.suppress(OSError):
                partial.unlink()
            raise
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be written") from None
    except ValueError:
        raise FileError(repr(str(path)), "is not the name of a file") from None
