"""Ways to make a zip file mean two things: by what stands around its files.

Each trick takes a zip file with the files of a bundle and changes it, as drawn.
"""

import struct
import zlib
from random import Random

from tampering import ENDS, Opened
from zip_forging import Part, Zip, ending, entry, header, large_ending, trick, with_checksum

REPORT = b"report.html"
TEXT = b"<h1>Nothing was ever moved</h1>"


def forged(one: Zip, name: bytes = REPORT) -> Part:
    """Another report, as long as the right one and with its checksum."""
    report = one.part(REPORT).content
    return Part(name, with_checksum(TEXT, len(report), zlib.crc32(report)))


def another_zip(one: Zip) -> bytes:
    return Zip([forged(one)]).made()


def any_part(one: Zip, draw: Random) -> Part:
    return draw.choice([part for part in one.parts if part.is_listed])


def somewhere(part: Part, draw: Random, **fields) -> None:
    """Fields of the header, of the directory, or of both."""
    where = draw.choice(("front", "listed", "both"))
    if where != "listed":
        part.front |= fields
    if where != "front":
        part.listed |= fields


def restated(one: Zip) -> None:
    """Have the manifest name all files, and sign it with the right key."""
    opened = Opened({part.name.decode(): part.content for part in one.parts})
    opened.made_good()
    opened.as_of_0_2_0()
    for name in ENDS:
        one.part(name.encode()).content = opened.files[name]


@trick
def bytes_behind_the_end(one: Zip, draw: Random) -> None:
    one.behind = draw.choice((b"\0", b"x" * 100, draw.randbytes(70), another_zip(one)))


@trick
def bytes_in_front(one: Zip, draw: Random) -> None:
    one.in_front = draw.choice((b"#!/bin/sh\nexit\n", b"MZ" + bytes(200), another_zip(one)))
    one.is_front_counted = draw.random() < 0.5


@trick
def a_comment_at_the_end(one: Zip, draw: Random) -> None:
    one.comment = draw.choice((b"hello", b"PK\5\6" + bytes(18), another_zip(one)))


@trick
def a_second_directory(one: Zip, draw: Random) -> None:
    other = forged(one)
    other.is_listed = False
    one.parts.insert(draw.randrange(len(one.parts) + 1), other)
    one.second = [part for part in one.parts if part.name != REPORT] + [other]
    one.by_end = draw.choice(("first", "second"))
    if draw.random() < 0.5:
        one.by_comment = "second" if one.by_end == "first" else "first"


@trick
def a_zip64_end_beside_the_other(one: Zip, draw: Random) -> None:
    a_second_directory(one, draw)
    one.by_comment = None
    one.by_large = draw.choice(("first", "second"))
    full = {"count": 0xFFFF, "here": 0xFFFF, "size": 2**32 - 1, "at": 2**32 - 1}
    one.end = draw.choice(({}, full, {"at": 2**32 - 1}))
    one.large = draw.choice(({}, {}, {"count": 3}, {"place": 7}))


@trick
def a_directory_in_the_place_of_a_file(one: Zip, draw: Random) -> None:
    """Another report and a directory with it lie behind the packed bytes of the last file."""
    last, other = one.parts[-1], forged(one)
    other.is_listed = False
    one.second = [part for part in one.parts if part.name != REPORT] + [other]
    one.parts.append(other)
    hidden = len(header(other)) + len(other.body) + sum(len(entry(part)) for part in one.second)
    last.both(packed=len(last.body) + hidden)
    one.by_end, one.by_large = draw.choice(
        (("first", "second"), ("second", "first"), ("second", None))
    )


@trick
def an_end_that_says_otherwise(one: Zip, draw: Random) -> None:
    count = len(one.parts)
    one.end = draw.choice(
        (
            {"count": count - 1, "here": count - 1},
            {"count": count + 1, "here": count + 1},
            {"here": 1},
            {"size": draw.randrange(300)},
            {"at": draw.randrange(300)},
            {"disk": 1, "first": 1},
            {"disk": 0xFFFF},
            {"count": 0, "here": 0, "size": 0},
        )
    )


@trick
def a_file_that_is_not_in_the_directory(one: Zip, draw: Random) -> None:
    other = forged(one, draw.choice((REPORT, b"certificates/1.json")))
    other.is_listed = False
    one.parts.insert(draw.randrange(len(one.parts) + 1), other)


@trick
def a_file_in_the_directory_alone(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    other = Part(b"certificates/1.json", part.content, part.method)
    one.second = [*one.parts, other]
    one.by_end = "second"
    other.listed["at"] = draw.choice((0, 30, 2**31))


@trick
def files_that_overlap(one: Zip, draw: Random) -> None:
    first, *others = one.parts
    other = Part(b"certificates/1.json", first.content)
    if draw.random() < 0.5:
        other.listed["at"] = 0
        other.is_listed = False
        one.second, one.by_end = [*one.parts, other], "second"
    else:
        # A packed file that begins with the next file's header, and goes on with that file's.
        block = header(others[0])
        quoted = b"\0" + struct.pack("<2H", len(block), len(block) ^ 0xFFFF)
        first.packed = quoted
        first.both(packed=len(quoted) + len(block) + len(others[0].body))


@trick
def what_is_cut_short(one: Zip, draw: Random) -> None:
    share = draw.choice((0.0, 0.3, 0.9, 1.0))
    one.change.append(lambda content: content[: int(len(content) * share) - draw.randrange(1, 60)])


@trick
def a_byte_that_was_changed(one: Zip, draw: Random) -> None:
    share, other = draw.random(), draw.randrange(1, 256)
    from_end = draw.random() < 0.5

    def change(content):
        bent = bytearray(content)
        place = len(bent) - 1 - int(share * 900) if from_end else int(share * len(bent))
        bent[place] ^= other
        return bytes(bent)

    one.change.append(change)


@trick
def a_zip_file_in_a_gap(one: Zip, draw: Random) -> None:
    hidden = another_zip(one)
    where = draw.choice(("gap", "before", "behind"))
    if where == "gap":
        one.gap = hidden
    else:
        setattr(any_part(one, draw), where, hidden)


@trick
def ends_in_a_gap(one: Zip, draw: Random) -> None:
    end = ending(1, 60, 0)
    large = large_ending(1, 60, 0, 60)
    one.gap = draw.choice((end, large, large + end, end + bytes(40)))
