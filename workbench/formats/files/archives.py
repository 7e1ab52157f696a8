"""Zip files written whole, and read with nothing taken on trust.

What comes from outside may name paths that lead elsewhere, links, the same file twice, or unpack
to more than a disk holds; none of that reaches the disk.
"""

import contextlib
import lzma
import re
import stat
import tempfile
import zipfile
import zlib
from collections.abc import Generator, Iterable, Mapping
from pathlib import Path, PurePosixPath
from typing import IO

from workbench.formats.files.whole_files import partial_of
from workbench.model.errors import FileError

MOST_FILES = 100_000
MOST_BYTES = 16 * 2**30
MOST_GROWTH = 300
"""So many times as large as the zip file may its content be; scans come to about 3."""

NAME = re.compile(r"[\w.+ -]{1,120}", re.ASCII)
"""What a folder or file in a zip file may be called."""

CHUNK = 2**20

UNREADABLE = (
    *(zipfile.BadZipFile, zlib.error, lzma.LZMAError, EOFError),
    *(NotImplementedError, RuntimeError, ValueError),
)
"""What `zipfile` raises at files that are damaged, encrypted, or packed in unknown ways."""


def write_archive(path: Path, content: Mapping[str, Path | bytes | memoryview]) -> None:
    """Write a zip file, which afterwards is there wholly or not at all.

    Args:
        path: of the zip file.
        content: name in it, with slashes -> a file or the content itself.

    Raises:
        FileError: something cannot be read or written.
    """
    partial = partial_of(path)
    try:
        with zipfile.ZipFile(partial, "w", zipfile.ZIP_DEFLATED, compresslevel=6) as archive:
            for name, source in content.items():
                # The same content gives the same bytes, whenever it is written.
                entry = zipfile.ZipInfo(name)
                entry.compress_type = zipfile.ZIP_DEFLATED
                entry.external_attr = 0o644 << 16
                if isinstance(source, bytes | memoryview):
                    archive.writestr(entry, source)
                else:
                    entry.file_size = source.stat().st_size
                    with source.open("rb") as file, archive.open(entry, "w") as target:
                        while block := file.read(CHUNK):
                            target.write(block)
        partial.replace(path)
    except OSError as error:
        raise FileError(error.filename or path, error.strerror or "cannot be written") from None
    finally:
        with contextlib.suppress(OSError):
            partial.unlink()


def unpack(path: Path, folder: Path, most: int = MOST_BYTES) -> tuple[str, ...]:
    """Unpack a zip file from anywhere into an empty folder.

    Args:
        path: of the zip file.
        folder: to write to; nothing is written outside of it.
        most: [bytes] that may come of it.

    Returns:
        The names of the files, with slashes.

    Raises:
        FileError: it is no zip file, is damaged, names what it may not, or is too large.
    """
    try:
        with zipfile.ZipFile(path) as archive:
            entries = [entry for entry in archive.infolist() if not entry.is_dir()]
            _check(path, entries, most)
            for entry in entries:
                target = folder.joinpath(*PurePosixPath(entry.filename).parts)
                target.parent.mkdir(parents=True, exist_ok=True)
                with archive.open(entry) as source, target.open("xb") as file:
                    _copy(path, entry, source, file)
    except UNREADABLE as error:
        raise FileError(path, f"is no zip file that can be read: {error}") from None
    except OSError as error:
        raise FileError(error.filename or path, error.strerror or "cannot be used") from None
    return tuple(entry.filename for entry in entries)


def _check(path: Path, entries: Iterable[zipfile.ZipInfo], largest: int) -> None:
    seen: set[str] = set()
    total, count = 0, 0
    most = min(largest, max(path.stat().st_size, 1) * MOST_GROWTH)
    for entry in entries:
        name, count = entry.filename, count + 1
        parts = name.split("/")
        if any(not NAME.fullmatch(part) or part.strip(". ") == "" for part in parts):
            raise FileError(path, f"names {name[:100]!r}, which is no plain path below a folder")
        # A file system may not tell capitals from small letters.
        if name.casefold() in seen:
            raise FileError(path, f"names {name!r} twice")
        seen.add(name.casefold())
        kind = stat.S_IFMT(entry.external_attr >> 16)
        if kind not in (0, stat.S_IFREG):
            raise FileError(path, f"{name!r} is no plain file")
        total += entry.file_size
        if total > most or count > MOST_FILES:
            raise FileError(
                path, f"unpacks to more than {most / 2**20:,.0f} MB or {MOST_FILES:,} files"
            )


def _copy(path: Path, entry: zipfile.ZipInfo, source: IO[bytes], target: IO[bytes]) -> None:
    """Copy no more than was announced, whatever comes."""
    left = entry.file_size
    while block := source.read(CHUNK):
        left -= len(block)
        if left < 0:
            raise FileError(path, f"{entry.filename!r} is longer than it says")
        target.write(block)


@contextlib.contextmanager
def unpacked_beside(path: Path, folder: Path) -> Generator[Path]:
    """Unpack into a folder of its own on the disk of `folder`, gone when the block ends.

    Raises:
        FileError: see `unpack`.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
        holder = tempfile.TemporaryDirectory(dir=folder, prefix=".unpacking-")
    except OSError as error:
        raise FileError(folder, error.strerror or "cannot be written") from None
    with holder as place:
        unpack(path, Path(place))
        yield Path(place)
