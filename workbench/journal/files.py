"""Files named by what they hold: `<folder>/aa/<sha256>`, written once, never changed."""

import contextlib
import hashlib
import os
import re
import tempfile
from pathlib import Path

from workbench.formats.files.whole_files import sync_folder
from workbench.model.errors import JournalError

DIGEST = re.compile(r"[0-9a-f]{64}")


def file_path(folder: Path, digest: str) -> Path:
    """Where the file with this SHA-256 (64 hexadecimal digits) lies.

    Raises:
        JournalError: the text is no SHA-256, so it may not become a path.
    """
    if DIGEST.fullmatch(digest) is None:
        raise JournalError(f"{digest!r} is not a SHA-256 in 64 hexadecimal digits")
    return folder / digest[:2] / digest


Content = bytes | memoryview


def write_file(folder: Path, digest: str, content: Content) -> None:
    """Put a file on the disk so that after a crash it is there wholly or not at all.

    One that is there already stays, and its content is not checked again.

    Raises:
        JournalError: the content does not have that digest, or the disk refuses.
    """
    path = file_path(folder, digest)
    if path.exists():
        return
    actual = hashlib.sha256(content).hexdigest()
    if actual != digest:
        raise JournalError(f"content announced as {digest} has the digest {actual}")
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        _write_durably(path, content)
        # The new names count only once the folders that hold them are on the disk too.
        for holder in (path.parent, folder, folder.parent):
            sync_folder(holder)
    except OSError as error:
        raise JournalError(f"{path}: cannot be written: {error.strerror}") from error


def read_file(folder: Path, digest: str) -> bytes:
    """The file's content, checked against its name.

    Raises:
        JournalError: it is missing, cannot be read, or holds something else now.
    """
    path = file_path(folder, digest)
    # A pipe would be waited at, and a device read, without end.
    if path.exists() and not path.is_file():
        raise JournalError(f"{path}: is no file")
    try:
        content = path.read_bytes()
    except OSError as error:
        raise JournalError(f"{path}: cannot be read: {error.strerror}") from error
    if hashlib.sha256(content).hexdigest() != digest:
        raise JournalError(f"{path}: its content was changed after it was written")
    return content


def _write_durably(path: Path, content: Content) -> None:
    number, name = tempfile.mkstemp(dir=path.parent, prefix="writing-")
    try:
        with open(number, "wb") as stream:
            stream.write(content)
            stream.flush()
            os.fsync(stream.fileno())
        os.replace(name, path)
    except BaseException:
        with contextlib.suppress(OSError):
            os.unlink(name)
        raise
