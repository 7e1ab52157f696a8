"""The one form in which the workbench packs a zip file: files back to back, nothing between them.

Name, packing, checksum and lengths of each file give every byte around the contents.  A reader
makes these bytes again and compares them, so nothing can hide there.

`verify.py` of evidence carries this file along, so it imports nothing but Python's own.
"""

import itertools
import re
import struct
import zlib
from collections.abc import Iterable, Iterator
from typing import IO, Any, NamedTuple

STORED, DEFLATED = 0, 8
FILE_SIGNATURE, ENTRY_SIGNATURE, END_SIGNATURE = b"PK\3\4", b"PK\1\2", b"PK\5\6"
LARGE_END, LARGE_PLACE = b"PK\6\6", b"PK\6\7"
"""What records begin with: PKWARE APPNOTE 4.3."""

VERSION, LARGE_VERSION, UNIX, UTF_8 = 20, 45, 3 << 8, 0x800
NEW_YEAR_1980 = 1 << 5 | 1
ORDINARY = 0o644 << 16
LARGE = 2**31 - 1
"""[bytes] Beyond this the frame has 64-bit numbers; `zipfile` of Python draws the same line."""

LARGEST_FILE = LARGE * 20 // 21
"""[bytes] Of one file; packed it may be a little longer."""

MOST_FILES = 100_000
MOST_GROWTH = 300
"""This many times as large as the zip file may its content be; scans come to about 3."""

LONGEST_NAME = 500
ENTRY_NAME = re.compile(r"(?! )[\w.+ -]{0,119}[\w+-]", re.ASCII)
"""What a folder or file in a zip file may be called; Windows drops dots and spaces at the end."""

CHUNK_BYTES = 2**20


class Member(NamedTuple):
    """A file in a zip file.

    `packed` and `size` are its lengths [bytes]; `start` is where its packed content begins.
    """

    name: str
    method: int
    crc: int
    packed: int
    size: int
    start: int


def name_problems(files: Iterable[str], folders: Iterable[str] = ()) -> Iterator[str]:
    """Why no reader on any system should unpack files and folders of these names."""
    named = [(name, False) for name in files] + [(name, True) for name in folders]
    for name, _ in named:
        if len(name) > LONGEST_NAME or not all(map(ENTRY_NAME.fullmatch, name.split("/"))):
            yield f"names {name[:100]!r}, which is no plain path below a folder"
    # A file system may not tell capitals from small letters.  What is in a folder comes behind it.
    ordered = sorted(
        (name.lower().replace("/", "\0"), is_folder, name) for name, is_folder in named
    )
    for (above, is_folder, name), (below, _, other) in itertools.pairwise(ordered):
        if above == below:
            yield f"names {other!r} twice"
        elif not is_folder and below.startswith(above + "\0"):
            yield f"names {name!r}, which is a file and a folder"


def header_of(member: Member) -> bytes:
    """What stands in front of a file's packed content."""
    return FILE_SIGNATURE + _numbers(member, VERSION) + struct.pack("<H", 0) + member.name.encode()


def _numbers(member: Member, version: int) -> bytes:
    """What the header and the directory tell of a file alike."""
    numbers = (NEW_YEAR_1980, member.crc, member.packed, member.size, len(member.name.encode()))
    flags = 0 if member.name.isascii() else UTF_8
    return struct.pack("<5H3LH", version, flags, member.method, 0, *numbers)


def directory_of(members: Iterable[Member]) -> bytes:
    """What stands behind the last file: the directory and the end of the zip file."""
    entries: list[bytes] = []
    start = 0
    for member in members:
        name = member.name.encode()
        at, version, more = member.start - 30 - len(name), VERSION, b""
        if at > LARGE:
            at, version, more = 2**32 - 1, LARGE_VERSION, struct.pack("<2HQ", 1, 8, at)
        rest = struct.pack("<4H2L", len(more), 0, 0, 0, ORDINARY, at)
        entries += (
            ENTRY_SIGNATURE,
            struct.pack("<H", UNIX | version),
            _numbers(member, version),
            rest,
        )
        entries += name, more
        start = member.start + member.packed
    listed = b"".join(entries)
    count, end = len(entries) // 6, b""
    if count >= 2**16 or max(start, len(listed)) > LARGE:
        numbers = (44, LARGE_VERSION, LARGE_VERSION, 0, 0, count, count, len(listed), start)
        end = LARGE_END + struct.pack("<Q2H2L4Q", *numbers)
        end += LARGE_PLACE + struct.pack("<LQL", 0, start + len(listed), 1)
    count, size, start = min(count, 2**16 - 1), len(listed), min(start, 2**32 - 1)
    return listed + end + END_SIGNATURE + struct.pack("<4H2LH", 0, 0, count, count, size, start, 0)


def members_of(file: IO[bytes]) -> list[Member]:
    """The files in a zip file as the workbench packs it; ValueError at anything else."""
    length = file.seek(0, 2)
    members: list[Member] = []
    place = 0
    while True:
        file.seek(place)
        head = file.read(30)
        if len(head) < 30 or not head.startswith(FILE_SIGNATURE):
            break
        method, _, _, crc, packed, size, named = struct.unpack("<8x3H3LH2x", head)
        name = file.read(named)
        member = Member(name.decode("utf-8"), method, crc, packed, size, place + 30 + named)
        if header_of(member) != head + name or not _is_plausible(member):
            raise ValueError(f"at byte {place} it was changed, or another program packed it")
        members.append(member)
        place = member.start + packed
        if len(members) > MOST_FILES:
            raise ValueError(f"it has more than {MOST_FILES:,} files")
    expected = directory_of(members)
    file.seek(place)
    rest = file.read(len(expected) + 1)
    if rest != expected:
        remark = "there are bytes behind its end" if rest.startswith(expected) else ""
        raise ValueError(
            remark or f"from byte {place} on it was changed, or another program packed it"
        )
    for problem in name_problems(member.name for member in members):
        raise ValueError(f"it {problem}")
    check_contents(file, members, length)
    return members


def _is_plausible(member: Member) -> bool:
    if member.method == STORED:
        return member.packed == member.size <= LARGEST_FILE
    return member.method == DEFLATED and member.size <= LARGEST_FILE


def check_contents(file: IO[bytes], members: Iterable[Member], length: int) -> None:
    """ValueError when files unpack to too much, or the zip file [bytes] is something else, too."""
    if sum(member.size for member in members) > length * MOST_GROWTH:
        raise ValueError(f"it unpacks to more than {MOST_GROWTH} times its length")
    # Readers that look at the content take it for a disk (ECMA-119, 8.1) or a tape (POSIX ustar).
    file.seek(32769)
    if file.read(5) == b"CD001":
        raise ValueError("it is the picture of a disk as well")
    file.seek(0)
    block = file.read(512)
    others = block[:148] + b" " * 8 + block[156:]
    signed = sum(others) - 256 * sum(byte > 127 for byte in others)
    checksum = re.match(rb"[ \0]*([0-7]+)", block[148:156])
    if checksum and int(checksum[1], 8) in (sum(others), signed):
        raise ValueError("it is a tar file as well")


def blocks_of(file: IO[bytes], member: Member) -> Iterator[bytes]:
    """The content of a file, in pieces; ValueError when it is not exactly what was announced."""
    file.seek(member.start)
    left, size, crc = member.packed, 0, 0
    unpack = zlib.decompressobj(-zlib.MAX_WBITS)
    while left:
        block = file.read(min(left, CHUNK_BYTES))
        if not block:
            raise ValueError(f"{member.name} is cut short")
        left -= len(block)
        for piece in (block,) if member.method == STORED else _unpack(unpack, block):
            size, crc = size + len(piece), zlib.crc32(piece, crc)
            if size > member.size:
                raise ValueError(f"{member.name} is longer than it says")
            yield piece
        if unpack.unused_data or (unpack.eof and left):
            raise ValueError(f"{member.name} has bytes behind its end")
    is_whole = member.method == STORED or unpack.eof
    if not is_whole or (size, crc) != (member.size, member.crc):
        raise ValueError(f"{member.name} is damaged")


def _unpack(unpack: Any, block: bytes) -> Iterator[bytes]:
    try:
        while piece := unpack.decompress(block, CHUNK_BYTES):
            yield piece
            block = unpack.unconsumed_tail
    except zlib.error as error:
        raise ValueError(f"it is damaged: {error}") from None
