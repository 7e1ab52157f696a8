"""Zip files made byte by byte, so that every number in them can be another one."""

import struct
import zlib
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from random import Random

STORED, DEFLATED = 0, 8
UNIX = 3 << 8


@dataclass
class Part:
    """A file: what its header (`front`) and the directory (`listed`) say otherwise than is so."""

    name: bytes
    content: bytes
    method: int = DEFLATED
    packed: bytes | None = None
    before: bytes = b""
    behind: bytes = b""
    front: dict = field(default_factory=dict)
    listed: dict = field(default_factory=dict)
    is_listed: bool = True
    at: int = 0

    def both(self, **fields) -> None:
        self.front |= fields
        self.listed |= fields

    @property
    def body(self) -> bytes:
        if self.packed is not None:
            return self.packed
        return self.content if self.method == STORED else deflated(self.content)

    def told(self, changes: Mapping) -> dict:
        about = {"version": 20, "flags": 0, "method": self.method, "time": 0, "date": 0x21}
        about |= {"crc": zlib.crc32(self.content), "packed": len(self.body)}
        about |= {"size": len(self.content), "name": self.name, "extra": b"", "comment": b""}
        about |= {"made": UNIX | 20, "disk": 0, "internal": 0, "external": 0o644 << 16}
        return about | {"at": self.at} | changes


def deflated(content: bytes, level: int = 6) -> bytes:
    pack = zlib.compressobj(level, zlib.DEFLATED, -15)
    return pack.compress(content) + pack.flush()


def shared(told: Mapping) -> bytes:
    names = ("version", "flags", "method", "time", "date", "crc", "packed", "size")
    numbers = struct.pack("<5H3L", *(told[name] for name in names))
    return numbers + struct.pack("<2H", len(told["name"]), len(told["extra"]))


def header(part: Part) -> bytes:
    told = part.told(part.front)
    return b"PK\3\4" + shared(told) + told["name"] + told["extra"]


def entry(part: Part) -> bytes:
    told = part.told(part.listed)
    rest = (len(told["comment"]), told["disk"], told["internal"], told["external"], told["at"])
    made = struct.pack("<H", told["made"])
    texts = told["name"] + told["extra"] + told["comment"]
    return b"PK\1\2" + made + shared(told) + struct.pack("<3H2L", *rest) + texts


def ending(count: int, size: int, at: int, comment: bytes = b"", changes: Mapping = {}) -> bytes:
    told = {"disk": 0, "first": 0, "here": count, "count": count, "size": size, "at": at}
    told |= changes
    numbers = ("disk", "first", "here", "count", "size", "at")
    packed = struct.pack("<4H2L", *(told[name] for name in numbers))
    return b"PK\5\6" + packed + struct.pack("<H", len(comment)) + comment


def large_ending(count: int, size: int, at: int, place: int, changes: Mapping = {}) -> bytes:
    """A zip64 end of the directory and where it is, at `place`."""
    told = {"count": count, "size": size, "at": at} | changes
    numbers = (44, 45, 45, 0, 0, told["count"], told["count"], told["size"], told["at"])
    record = b"PK\6\6" + struct.pack("<Q2H2L4Q", *numbers)
    return record + b"PK\6\7" + struct.pack("<LQL", 0, told.get("place", place), 1)


@dataclass
class Zip:
    """A zip file to be made otherwise than it should be.

    `second` is another directory, of other files among the parts; `by_end`, `by_large` and
    `by_comment` say which of them ("first", "second") the end, a zip64 end, and an end in the
    comment name.
    """

    parts: list[Part]
    in_front: bytes = b""
    is_front_counted: bool = True
    gap: bytes = b""
    second: list[Part] | None = None
    by_end: str = "first"
    by_large: str | None = None
    by_comment: str | None = None
    is_reversed: bool = False
    large: dict = field(default_factory=dict)
    end: dict = field(default_factory=dict)
    comment: bytes = b""
    behind: bytes = b""
    change: list = field(default_factory=list)
    """Functions that change the bytes at the end."""

    def part(self, name: bytes) -> Part:
        return next(part for part in self.parts if part.name == name)

    def made(self) -> bytes:
        out = bytearray(self.in_front)
        shift = 0 if self.is_front_counted else len(out)
        for part in self.parts:
            out += part.before
            part.at = len(out) - shift
            out += header(part) + part.body + part.behind
        out += self.gap
        places = {}
        listed = [part for part in self.parts if part.is_listed]
        if self.is_reversed:
            listed.reverse()
        for name, parts in (("second", self.second or []), ("first", listed)):
            entries = b"".join(entry(part) for part in parts)
            places[name] = (len(parts), len(entries), len(out) - shift)
            out += entries
        if self.by_large:
            place = len(out) - shift
            out += large_ending(*places[self.by_large], place, self.large)
        if self.by_comment:
            self.comment = ending(*places[self.by_comment])
        out += ending(*places[self.by_end], self.comment, self.end)
        content = bytes(out) + self.behind
        for change in self.change:
            content = change(content)
        return content


def with_checksum(content: bytes, length: int, checksum: int) -> bytes:
    """A text made `length` bytes long so that its CRC-32 is that of another."""
    content = content.ljust(length - 4)
    table = [zlib.crc32(bytes([one]), 0xFFFFFFFF) ^ 0xFFFFFFFF for one in range(256)]
    by_top = {value >> 24: (value, one) for one, value in enumerate(table)}
    now, wanted, indices = zlib.crc32(content) ^ 0xFFFFFFFF, checksum ^ 0xFFFFFFFF, []
    for _ in range(4):
        value, one = by_top[wanted >> 24]
        wanted = (wanted ^ value) << 8 & 0xFFFFFFFF
        indices.insert(0, one)
    added = bytearray()
    for one in indices:
        added.append((now ^ one) & 0xFF)
        now = (now >> 8) ^ table[one]
    made = content + bytes(added)
    assert zlib.crc32(made) == checksum
    return made


TRICKS: dict[str, Callable[[Zip, Random], None]] = {}
"""By name, in words."""


def trick(change: Callable[[Zip, Random], None]) -> Callable[[Zip, Random], None]:
    """A way to change a zip file, as drawn."""
    TRICKS[change.__name__.replace("_", " ")] = change
    return change
