"""Zip files written whole, and read with nothing taken on trust.

What comes from outside may name paths that lead elsewhere, links, the same file twice, or unpack
to more than a disk holds; none of that reaches the disk.
"""

import contextlib
import hashlib
import os
import tempfile
import zlib
from collections.abc import Callable, Generator, Iterable, Mapping
from pathlib import Path, PurePosixPath
from typing import IO

from workbench.formats.files.whole_files import partial_of, sync_folder
from workbench.formats.files.zip_frame import (
    CHUNK_BYTES,
    DEFLATED,
    LARGEST_FILE,
    MOST_FILES,
    STORED,
    Member,
    blocks_of,
    directory_of,
    header_of,
)
from workbench.formats.files.zip_reading import files_in
from workbench.model.errors import FileError

MOST_BYTES = 16 * 2**30


def write_archive(
    path: Path,
    content: Mapping[str, Path | bytes | memoryview],
    last: Callable[[str], Mapping[str, bytes]] | None = None,
) -> None:
    """Write a zip file, which afterwards is there wholly or not at all.

    The same content gives the same bytes, whenever it is written.

    Args:
        path: of the zip file.
        content: name in it, with slashes -> a file or the content itself.
        last: gives further files, which are stored as they are, for the SHA-256 of all bytes
            before them.

    Raises:
        FileError: something cannot be read or written, or is larger than what can be read again.
    """
    partial = partial_of(path)
    if len(content) > MOST_FILES:
        raise FileError(path, f"would have more than {MOST_FILES:,} files")
    try:
        with partial.open("wb+") as file:
            members = [
                _write(path, file, name, member_content) for name, member_content in content.items()
            ]
            if last is not None:
                file.seek(0)
                digest = hashlib.file_digest(file, "sha256").hexdigest()
                members += [
                    _write(path, file, name, member_content, STORED)
                    for name, member_content in last(digest).items()
                ]
            file.seek(0, 2)
            file.write(directory_of(members))
            # After a power cut there is all of it or none: it may be all that is left of something.
            file.flush()
            os.fsync(file.fileno())
        partial.replace(path)
        # There are file systems whose folders cannot be synced; the file is there all the same.
        with contextlib.suppress(OSError):
            sync_folder(path.parent)
    except OSError as error:
        raise FileError(error.filename or path, error.strerror or "cannot be written") from None
    finally:
        with contextlib.suppress(OSError):
            partial.unlink()


def _write(
    path: Path,
    file: IO[bytes],
    name: str,
    source: Path | bytes | memoryview,
    method: int = DEFLATED,
) -> Member:
    """Write one file at the end; its header is known when all of it has been packed."""
    place = file.seek(0, 2)
    member = Member(name, method, 0, 0, 0, place)
    start = place + file.write(header_of(member))
    crc = size = 0
    pack = zlib.compressobj(6, zlib.DEFLATED, -zlib.MAX_WBITS)
    for block in _blocks(source):
        crc, size = zlib.crc32(block, crc), size + len(block)
        if size > LARGEST_FILE:
            raise FileError(path, f"{name!r} is longer than {LARGEST_FILE / 2**30:.1f} GB")
        file.write(block if method == STORED else pack.compress(block))
    if method == DEFLATED:
        file.write(pack.flush())
    member = Member(name, method, crc, file.tell() - start, size, start)
    file.seek(place)
    file.write(header_of(member))
    return member


def _blocks(source: Path | bytes | memoryview) -> Iterable[bytes | memoryview]:
    if isinstance(source, bytes | memoryview):
        yield source
        return
    with source.open("rb") as file:
        while block := file.read(CHUNK_BYTES):
            yield block


def unpack(path: Path, folder: Path, most: int = MOST_BYTES) -> tuple[str, ...]:
    """Unpack a zip file from anywhere into an empty folder.

    Args:
        path: of the zip file.
        folder: to write to; nothing is written outside of it.
        most: [bytes] that may come of it.

    Returns:
        The names of the files, with slashes.

    Raises:
        FileError: it is no zip file, is damaged, names what it may not, is too large, or readers
            might find different files in it.
    """
    try:
        with path.open("rb") as packed:
            members = files_in(packed)
            if sum(member.size for member in members) > most:
                raise FileError(path, f"unpacks to more than {most / 2**20:,.0f} MB")
            for member in members:
                target = folder.joinpath(*PurePosixPath(member.name).parts)
                target.parent.mkdir(parents=True, exist_ok=True)
                with target.open("xb") as file:
                    for block in blocks_of(packed, member):
                        file.write(block)
    except ValueError as error:
        raise FileError(path, f"is no zip file that can be read: {error}") from None
    except OSError as error:
        raise FileError(error.filename or path, error.strerror or "cannot be used") from None
    return tuple(member.name for member in members)


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
