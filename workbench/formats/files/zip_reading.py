"""Zip files of any program, taken where every reader finds the same files in them.

Readers go by the end, the directory, the headers in front of the files, or by what is well known of
each.  Where these do not agree, or leave bytes over, nothing is read.
"""

import re
import stat
import struct
from collections.abc import Iterator
from typing import IO, NamedTuple

from workbench.formats.files.zip_frame import (
    DEFLATED,
    END_SIGNATURE,
    ENTRY_SIGNATURE,
    FILE_SIGNATURE,
    LARGE_END,
    LARGE_PLACE,
    LARGE_VERSION,
    MOST_FILES,
    STORED,
    UTF_8,
    Member,
    blocks_of,
    check_contents,
    name_problems,
)

PACKING_LEVEL, LENGTHS_BEHIND = 0x6, 0x8
"""Flags: how well it is packed; checksum and lengths stand behind the file."""

LARGE_FIELD = 0x0001
TIMES_AND_OWNERS = re.compile(
    rb"\x0a\x00\x20\x00.{4}\x01\x00\x18\x00.{24}"  # times of Windows
    rb"|UT(\x05\x00[\x01\x03\x05\x07].{4}|\x09\x00[\x03\x05].{8}|\x0d\x00\x07.{12})"
    rb"|UX(\x08\x00.{8}|\x0c\x00.{12})|Ux(\x00\x00|\x04\x00.{4})"
    rb"|ux\x0b\x00\x01\x04.{4}\x04.{4}",
    re.DOTALL,
)
"""Fields, by the letters of their numbers, that change neither names nor contents."""

SYSTEMS = {0, 3, 10, 11, 14, 19}
"""MS-DOS, Unix, Windows in its two numbers, its long names, macOS: names mean the same."""

LENGTHS = b"PK\7\x08"
FIELD_FULL, LARGE_FIELD_FULL = 2**16 - 1, 2**32 - 1
LARGEST_DIRECTORY = 64 * 2**20
DOS_FOLDER = 0x10


class _Entry(NamedTuple):
    """A file or folder in the directory; `fields` are method, checksum, packed and whole length."""

    name: bytes
    flags: int
    fields: tuple[int, int, int, int]
    place: int


def files_in(file: IO[bytes]) -> list[Member]:
    """The files in a zip file; folders are left out.

    Raises:
        ValueError: it is none, or readers may find different things in it; why, as a sentence
            without its subject.
        OSError: it cannot be read.
    """
    length = file.seek(0, 2)
    count, size, start = _end(file, length)
    entries = list(_entries(_bytes(file, start, size)))
    if len(entries) != count:
        raise ValueError(f"its directory has {len(entries)} files, its end says {count}")
    members: list[Member] = []
    folders: list[str] = []
    place = 0
    for entry in sorted(entries, key=lambda entry: entry.place):
        if entry.place != place:
            raise ValueError(f"at byte {place} there is something that belongs to no file")
        member, behind = _member(file, entry)
        place = member.start + member.packed + len(behind)
        if place > start:
            raise ValueError(f"{member.name!r} is cut short")
        if _bytes(file, place - len(behind), len(behind)) != behind:
            raise ValueError(f"{member.name!r} does not say how long it is")
        if member.name.endswith("/"):
            folders.append(member.name[:-1])
            list(blocks_of(file, member))  # nothing else may lie there
        else:
            members.append(member)
    if place != start:
        raise ValueError(f"at byte {place} there is something that belongs to no file")
    for problem in name_problems((member.name for member in members), folders):
        raise ValueError(f"it {problem}")
    check_contents(file, members, length)
    return members


def _bytes(file: IO[bytes], place: int, count: int) -> bytes:
    file.seek(max(place, 0))
    found = file.read(count)
    if place < 0 or len(found) != count:
        raise ValueError("it is cut short")
    return found


def _end(file: IO[bytes], length: int) -> tuple[int, int, int]:
    """How many files the directory has, how long it is [bytes], and where it begins."""
    place = length - 22
    record = _bytes(file, place, 22)
    if not record.startswith(END_SIGNATURE):
        raise ValueError("there is no end of a zip file at its end, or a comment behind it")
    disk, first, here, count, size, start, comment = struct.unpack("<4x4H2LH", record)
    if comment or disk or first or here != count:
        raise ValueError("its end is that of several files, or has a comment")
    if _bytes(file, max(place - 20, 0), 4) == LARGE_PLACE:
        fields = (count, size, start)
        at = struct.unpack("<4xLQL", _bytes(file, place - 20, 20))
        place -= 76
        record = _bytes(file, place, 56)
        form, disk, first, here, count, size, start = struct.unpack("<4xQ4x2L4Q", record)
        if at != (0, place, 1) or disk or first or (form, here) != (44, count):
            raise ValueError("its two ends do not agree")
        if not record.startswith(LARGE_END) or any(
            stated not in (expected, full)
            for stated, expected, full in zip(
                fields,
                (count, size, start),
                (FIELD_FULL, LARGE_FIELD_FULL, LARGE_FIELD_FULL),
                strict=True,
            )
        ):
            raise ValueError("its two ends do not agree")
    if count > MOST_FILES or size > LARGEST_DIRECTORY:
        raise ValueError(f"it has more than {MOST_FILES:,} files")
    if start + size != place:
        raise ValueError("its directory is not where its end says")
    return count, size, start


def _entries(directory: bytes) -> Iterator[_Entry]:
    place = 0
    while place < len(directory):
        head = directory[place : place + 46]
        if len(head) < 46 or not head.startswith(ENTRY_SIGNATURE):
            raise ValueError("its directory cannot be read")
        made, version, flags, method, crc, packed, size, *lengths, disk, _, outer, at = (
            struct.unpack("<4x4H4x3L5H2L", head)
        )
        named, more, comment = lengths
        name = directory[place + 46 : place + 46 + named]
        place += 46 + named + more
        extra = directory[place - more : place]
        if place > len(directory) or comment or disk:
            raise ValueError("its directory is cut short, or has comments")
        if version & 0xFF > LARGE_VERSION or flags & ~(PACKING_LEVEL | LENGTHS_BEHIND | UTF_8):
            raise ValueError(f"{name!r} is encrypted, or packed in a way that is not read")
        _check_kind(name, method, made >> 8, outer)
        size, packed, at = _large(extra, size, packed, at)
        yield _Entry(name, flags, (method, crc, packed, size), at)


def _check_kind(name: bytes, method: int, system: int, outer: int) -> None:
    is_folder = name.endswith(b"/")
    if method not in (STORED, DEFLATED) or system not in SYSTEMS:
        raise ValueError(f"{name!r} is packed in a way that is not read")
    kinds = (0, stat.S_IFDIR if is_folder else stat.S_IFREG)
    if stat.S_IFMT(outer >> 16) not in kinds or (outer & DOS_FOLDER and not is_folder):
        raise ValueError(f"{name!r} is no plain file")


def _large(extra: bytes, *stated: int) -> tuple[int, ...]:
    """Numbers of 32 bits, with those of 64 bits where they are full."""
    found: dict[int, bytes] = {}
    while extra:
        kind, length = struct.unpack("<2H", extra[:4].ljust(4, b"\0"))
        field, extra = extra[: 4 + length], extra[4 + length :]
        if len(field) != 4 + length or kind in found:
            raise ValueError("it has a field that cannot be read, or is there twice")
        if kind != LARGE_FIELD and not TIMES_AND_OWNERS.fullmatch(field):
            raise ValueError(f"it has a field {kind:#06x} that is not read")
        found[kind] = field[4:]
    count = stated.count(LARGE_FIELD_FULL)
    if (LARGE_FIELD in found) != bool(count) or len(found.get(LARGE_FIELD, b"")) != 8 * count:
        raise ValueError("it has large numbers where none belong, or lacks them")
    numbers = iter(struct.unpack(f"<{count}Q", found.get(LARGE_FIELD, b"")))
    return tuple(next(numbers) if number == LARGE_FIELD_FULL else number for number in stated)


def _member(file: IO[bytes], entry: _Entry) -> tuple[Member, bytes]:
    """A member whose header agrees with the directory, and the bytes that must follow it."""
    head = _bytes(file, entry.place, 30)
    version, flags, method, crc, packed, size, named, more = struct.unpack("<4x3H4x3L2H", head)
    name = _bytes(file, entry.place + 30, named)
    numbers = _large(_bytes(file, entry.place + 30 + named, more), size, packed)
    sizes = [crc, numbers[1], numbers[0]]
    behind = b""
    if flags & LENGTHS_BEHIND:
        # Whoever reads from the front finds the end of what is packed by itself alone.
        if method == STORED:
            raise ValueError(f"{name!r} does not say how long it is")
        form = "<4sL2Q" if LARGE_FIELD_FULL in (size, packed) else "<4s3L"
        try:
            behind = struct.pack(form, LENGTHS, *entry.fields[1:])
        except struct.error:
            raise ValueError(f"{name!r} is longer than it may say behind it") from None
        sizes = [
            stated or expected for stated, expected in zip(sizes, entry.fields[1:], strict=True)
        ]
    is_same = (name, flags, (method, *sizes)) == (entry.name, entry.flags, entry.fields)
    if not is_same or not head.startswith(FILE_SIGNATURE) or version & 0xFF > LARGE_VERSION:
        raise ValueError(f"{entry.name!r} has another header than the directory says")
    method, crc, packed, size = entry.fields
    start = entry.place + 30 + named + more
    if (method == STORED and packed != size) or (name.endswith(b"/") and size):
        raise ValueError(f"{entry.name!r} has no length that can be")
    return Member(name.decode("utf-8"), method, crc, packed, size, start), behind
