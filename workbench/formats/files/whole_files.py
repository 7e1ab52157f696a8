"""Files read and written as a whole: reading has a limit, and a written file is never half."""

import contextlib
import hashlib
import os
import re
import select
import shutil
import stat
import tempfile
import threading
import unicodedata
from collections.abc import Collection, Generator
from pathlib import Path

from workbench.model.errors import FileError, InputError
from workbench.model.messages.files import FileProblem

MB = 1024 * 1024

SILENCE = 60.0
"""[s] Longest silence of a pipe: the writing program may have to compute first."""

LONGEST_NAME = 60
"""[characters] Longest name of an upload; a longer name loses its beginning."""

POINTER = b"version https://git-lfs.github.com/spec/"
"""Beginning of a git-lfs pointer, which stands for a large file in a repository."""

Stamp = tuple[int, int]
"""Modification time [ns] and size [bytes] of a file."""


class PointerError(FileError):
    """The file is a git-lfs pointer to a large file that was not fetched."""


def read_whole(path: Path, most: int) -> bytes:
    """The content of a file of at most `most` bytes.

    Devices and pipes have no size to ask for beforehand, so the reading itself is bounded.

    Raises:
        FileError: the file is missing, unreadable or longer; it is a silent pipe, or a pointer of
            git-lfs.
    """
    try:
        # Without the opener a named pipe would block until a program writes to it.
        with open(path, "rb", opener=_at_once) as file:
            is_file = stat.S_ISREG(os.fstat(file.fileno()).st_mode)
            content = file.read(most + 1) if is_file else _through(path, file.fileno(), most)
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be read") from None
    except ValueError:  # a name that no file can have, such as one with a NUL
        raise FileError(repr(str(path)), FileProblem.NO_FILE_NAME()) from None
    if len(content) > most:
        raise FileError(path, FileProblem.TOO_LARGE(most=f"{most / MB:g}"))
    _refuse_pointer(path, content)
    return content


def refuse_pointer(path: Path) -> None:
    """Refuse a git-lfs pointer before another reader opens it.

    Raises:
        PointerError: the file is a pointer.
        FileError: it cannot be read.
    """
    try:
        with path.open("rb") as file:
            _refuse_pointer(path, file.read(len(POINTER)))
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be read") from None


def _refuse_pointer(path: Path, content: bytes) -> None:
    if content.startswith(POINTER):
        raise PointerError(path, "is a pointer of git-lfs: fetch the file (git lfs pull)")


def _at_once(path: str, flags: int) -> int:
    # O_NOCTTY: a terminal that is read must not become the controlling one of this process.
    return os.open(path, flags | os.O_NONBLOCK | os.O_NOCTTY)


def _through(path: Path, pipe: int, most: int) -> bytes:
    """The bytes of a pipe or a device until its end, or one byte more than `most`."""
    content = bytearray()
    while len(content) <= most:
        if not select.select([pipe], [], [], SILENCE)[0]:
            raise FileError(path, f"is a pipe through which nothing has come for {SILENCE:g} s")
        with contextlib.suppress(BlockingIOError):
            block = os.read(pipe, min(MB, most + 1 - len(content)))
            if not block:
                break
            content += block
    return bytes(content)


def write_whole(path: Path, content: bytes) -> None:
    """Write a file; after a crash it has either the old or the new content.

    Its permissions stay.

    Raises:
        FileError: the folder is missing or cannot be written.
    """
    try:
        if path.exists() and not path.is_file():  # a device or a pipe cannot be replaced
            path.write_bytes(content)
            return
        target = path.resolve()
        # Each thread has its own name: two writers of the same file must not mix.
        partial = target.with_name(f".{os.getpid()}-{threading.get_ident()}.partial")
        try:
            with partial.open("wb") as file:
                file.write(content)
                if target.exists():
                    shutil.copymode(target, partial)
                # Without fsync a power cut could leave an empty file.
                file.flush()
                os.fsync(file.fileno())
            partial.replace(target)
        except OSError:
            with contextlib.suppress(OSError):
                partial.unlink()
            raise
        # Some file systems cannot sync folders; the file is written all the same.
        with contextlib.suppress(OSError):
            sync_folder(target.parent)
    except OSError as error:
        raise FileError(path, error.strerror or "cannot be written") from None
    except ValueError:
        raise FileError(repr(str(path)), FileProblem.NO_FILE_NAME()) from None


def partial_of(path: Path) -> Path:
    """The temporary name of a file that then replaces another one at once.

    Raises:
        FileError: the path, such as `.`, is not the name of a file.
    """
    try:
        return path.with_name(f".{path.name}.{os.getpid()}.partial")
    except ValueError:
        raise FileError(path, FileProblem.NO_FILE_NAME()) from None


def sync_folder(folder: Path) -> None:
    """Write the names in a folder to the disk.

    Raises:
        OSError: the folder cannot be opened or written.
    """
    number = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(number)
    finally:
        os.close(number)


def make_folder(folder: Path) -> None:
    """Make a folder and its parents, if they are missing.

    Raises:
        FileError: the folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise FileError(folder, error.strerror or "cannot be made") from None


def stamps(folder: Path, kinds: Collection[str]) -> dict[Path, Stamp]:
    """The files in a folder with one of the endings `kinds`, without hidden files.

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


def is_folder(path: Path) -> bool:
    """Whether a folder exists; False for impossible names."""
    try:
        return path.is_dir()
    except (OSError, ValueError):
        return False


def is_file(path: Path) -> bool:
    """Whether a file exists; False for impossible names."""
    try:
        return path.is_file()
    except (OSError, ValueError):
        return False


def plain_name(name: str) -> str:
    """A name with `_` for everything but letters, digits, `_`, `.` and `-`: it is never a path."""
    return re.sub(r"[^\w.-]", "_", name)


def file_name(name: str) -> str:
    """A unique file name for any name; it is never a path."""
    plain = re.sub(r"[^A-Za-z0-9_.-]", "_", name)[:100]
    return plain if plain == name else f"{plain}-{hashlib.sha256(name.encode()).hexdigest()[:8]}"


def sent_name(name: str) -> str:
    """The name of an upload, unchanged.

    Raises:
        InputError: no file can have this name, or it has folders.
    """
    is_odd = any(letter in "/\\" or unicodedata.category(letter) in ("Cc", "Cs") for letter in name)
    if is_odd or not name.strip("."):
        raise InputError(FileProblem.NAME(name=repr(name[-LONGEST_NAME:])))
    return name


@contextlib.contextmanager
def write_upload(name: str, content: bytes | memoryview) -> Generator[Path]:
    """Write an upload into a temporary folder for the duration of the block.

    Errors name the file without that folder.

    Raises:
        InputError: the name is impossible (`sent_name`).
        FileError: raised in the block; it names the file as in the upload.
    """
    with tempfile.TemporaryDirectory(prefix="workbench-") as folder:
        file = Path(folder) / sent_name(name)[-LONGEST_NAME:]
        file.write_bytes(content)
        try:
            yield file
        except FileError as error:
            if error.path != str(file):
                raise
            raise FileError(file.name, error.problem) from None
