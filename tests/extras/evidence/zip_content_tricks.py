"""Ways to make a zip file mean two things: by what it says of a file, and how that is packed."""

import bz2
import lzma
import stat
import struct
import zlib
from random import Random

from zip_forging import DEFLATED, STORED, UNIX, Part, Zip, deflated, header, trick
from zip_tricks import REPORT, TEXT, another_zip, any_part, forged, restated, somewhere


@trick
def lengths_that_differ(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    field = draw.choice(("packed", "size"))
    value = len(part.body if field == "packed" else part.content)
    somewhere(part, draw, **{field: max(value + draw.choice((-9, -1, 1, 9, 400)), 0)})


@trick
def checksums_that_differ(one: Zip, draw: Random) -> None:
    somewhere(any_part(one, draw), draw, crc=draw.choice((0, draw.randrange(2**32))))


@trick
def packings_that_differ(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    other = STORED if part.method == DEFLATED else DEFLATED
    draw.choice((part.front, part.listed))["method"] = draw.choice((other, 9, 12, 99))


@trick
def bytes_behind_a_packed_file(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    part.method = DEFLATED
    other = forged(one)
    hidden = (b"\0", draw.randbytes(40), header(other) + other.body, other.body, another_zip(one))
    part.packed = deflated(part.content) + draw.choice(hidden)


@trick
def a_packed_file_that_is_cut_short(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    body = part.body
    part.packed = body[: -draw.randrange(1, min(9, len(body)))]
    if draw.random() < 0.5:
        part.both(packed=len(body))


@trick
def two_packed_files_in_the_place_of_one(one: Zip, draw: Random) -> None:
    report = one.part(REPORT)
    half = draw.randrange(len(report.content))
    first, last = deflated(report.content[:half]), deflated(report.content[half:])
    other = forged(one).body
    report.packed = draw.choice((first + last, report.body + other, other + report.body))


@trick
def lengths_behind_a_file(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    part.both(flags=8)
    told = [zlib.crc32(part.content), len(part.body), len(part.content)]
    if draw.random() < 0.5:
        part.front |= {"crc": 0, "packed": 0, "size": 0}
    if draw.random() < 0.3:
        told[draw.randrange(3)] ^= 1
    form = draw.choice(("<3L", "<3L", "<L2Q"))
    part.behind = draw.choice((b"PK\7\x08", b"PK\7\x08", b"")) + struct.pack(form, *told)
    part.behind += draw.choice((b"", b"", b"hidden"))


@trick
def other_attributes(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    kinds = (stat.S_IFLNK, stat.S_IFDIR, stat.S_IFCHR, stat.S_IFIFO, stat.S_IFSOCK, stat.S_IFREG)
    modes = [(kind | 0o644) << 16 for kind in kinds]
    modes += [0x10, 0o644 << 16 | 0x10, 0, 0o4755 << 16]
    part.listed |= {"external": draw.choice(modes), "internal": draw.choice((0, 1))}
    part.listed["made"] = draw.choice((UNIX | 20, 20, 2 << 8 | 20, 10 << 8 | 63, 19 << 8 | 20))


@trick
def flags_of_what_is_encrypted(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    flags = draw.choice((0x1, 0x41, 0x2001, 0x2000, 0x20, 0x10, 0x4000))
    somewhere(part, draw, flags=flags)
    if flags == 1 and draw.random() < 0.5:
        aes = struct.pack("<2HH2sBH", 0x9901, 7, 2, b"AE", 3, 8)
        part.both(method=99, extra=aes)


@trick
def fields_of_a_file(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    times = struct.pack("<2HBL", 0x5455, 5, 1, 1_800_000_000)
    owner = struct.pack("<2HBBLBL", 0x7875, 11, 1, 4, 0, 4, 0)
    large = struct.pack("<2H2Q", 1, 16, len(part.content), len(part.body))
    other = struct.pack("<2H2Q", 1, 16, 7, 7)
    kind = draw.choice((0x000A, 0x5455, 0x5855, 0x7855, 0x7875, 0x6375, 0x756E, 0xCAFE))
    wild = draw.randbytes(draw.choice((0, 1, 4, 5, 8, 9, 11, 12, 13, 32)))
    wild = struct.pack("<2H", kind, len(wild)) + wild
    known = (times, owner, times + owner, large, other)
    unknown = (times + times, wild, wild, wild, wild, b"\xfe\xca\xff\x00hide", b"\0")
    somewhere(part, draw, extra=draw.choice(known + unknown))
    if draw.random() < 0.1:
        somewhere(part, draw, size=2**32 - 1, packed=2**32 - 1)


@trick
def comments_of_files(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    part.listed["comment"] = draw.choice((b"hello", b"PK\5\6" + bytes(18), header(forged(one))))


@trick
def other_ways_of_packing(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    raw = lzma.compress(part.content, lzma.FORMAT_RAW, filters=[{"id": lzma.FILTER_LZMA1}])
    ways = (
        (12, bz2.compress(part.content)),
        (14, struct.pack("<BBH", 9, 4, 5) + b"\x5d\0\0\x80\0" + raw),
        *((9, part.body), (8, part.content), (0, deflated(part.content)), (93, part.content)),
        (8, zlib.compress(part.content)),
    )
    part.method, part.packed = draw.choice(ways)


@trick
def lengths_that_are_huge(one: Zip, draw: Random) -> None:
    part = any_part(one, draw)
    size = draw.choice((2**31, 2**32 - 2, 2**32 - 1))
    somewhere(part, draw, **{draw.choice(("size", "packed")): size})
    if draw.random() < 0.5:
        large = struct.pack("<2H2Q", 1, 16, draw.choice((2**40, 2**63, 2**64 - 1)), len(part.body))
        somewhere(part, draw, size=2**32 - 1, packed=2**32 - 1, extra=large)


@trick
def files_of_nothing_but_zeros(one: Zip, draw: Random) -> None:
    zeros = bytes(draw.choice((2**22, 2**24, 2**25)))
    draw.choice((one.part(REPORT), one.part(b"README.txt"))).content = zeros
    if draw.random() < 0.5:
        one.parts.append(Part(b"certificates/1.json", zeros))
        one.part(REPORT).content = TEXT
        restated(one)
