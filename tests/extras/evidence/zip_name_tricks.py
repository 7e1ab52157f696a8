"""Ways to make a zip file mean two things: by the names of its files."""

import stat
import struct
import zlib
from random import Random

from zip_forging import STORED, UNIX, Part, Zip, trick
from zip_tricks import REPORT, forged, restated, somewhere

LINK = stat.S_IFLNK | 0o777


@trick
def names_that_differ(one: Zip, draw: Random) -> None:
    name = draw.choice((b"report.htm_", b"../report.html", b"REPORT.HTML", b"log.json", b""))
    draw.choice((one.part(REPORT).front, one.part(REPORT).listed))["name"] = name


@trick
def a_name_twice(one: Zip, draw: Random) -> None:
    one.parts.insert(draw.randrange(len(one.parts) + 1), forged(one))


@trick
def a_name_in_other_capitals(one: Zip, draw: Random) -> None:
    name = draw.choice((b"Report.html", b"REPORT.HTML", b"report.HTML"))
    one.parts.insert(draw.randrange(len(one.parts) + 1), forged(one, name))


@trick
def names_that_lead_elsewhere(one: Zip, draw: Random) -> None:
    name = draw.choice(
        (
            *(b"../report.html", b"/report.html", b"a/../report.html", b"./report.html"),
            *(b"//report.html", b"a//report.html", b"report.html/", b"..", b"", b"~/report.html"),
        )
    )
    one.parts.insert(draw.randrange(len(one.parts) + 1), forged(one, name))


@trick
def names_with_backslashes_or_nul(one: Zip, draw: Random) -> None:
    name = draw.choice(
        (
            *(b"..\\report.html", b"certificates\\1.json", b"C:\\report.html", b".\\report.html"),
            *(b"report.html\0", b"report.html\0.txt", b"\0report.html", b"report.html\\"),
        )
    )
    other = forged(one, name)
    other.listed["made"] = draw.choice((UNIX | 20, 20))
    one.parts.insert(draw.randrange(len(one.parts) + 1), other)


@trick
def names_that_a_system_changes(one: Zip, draw: Random) -> None:
    name = draw.choice(
        (
            *(b"report.html.", b"report.html ", b" report.html", b"report.html:x", b"con"),
            *(b"aux.txt", b"certificates/nul", b"x" * 200, b"a/" * 200 + b"x", b"-rf", b"a\nb"),
        )
    )
    one.parts.insert(draw.randrange(len(one.parts) + 1), forged(one, name))
    if draw.random() < 0.5:
        restated(one)


@trick
def names_in_other_letters(one: Zip, draw: Random) -> None:
    name = draw.choice(
        (
            *("répört.html".encode(), "re\u0301port.html".encode(), b"r\x82port.html"),
            *(b"r\xe9port.html", b"\xff\xfe.html", b"\xc0\xafreport.html", "report.htmⅼ".encode()),
        )
    )
    other = forged(one, name)
    other.both(flags=draw.choice((0, 0x800)))
    if draw.random() < 0.3:
        other.front["flags"] = 0x800
    one.parts.insert(draw.randrange(len(one.parts) + 1), other)


@trick
def a_field_with_another_name(one: Zip, draw: Random) -> None:
    part = one.part(REPORT)
    if draw.random() < 0.5:
        part = forged(one, b"certificates/1.json")
        one.parts.append(part)
    name = draw.choice((REPORT, b"certificates/2.json", b"../report.html"))
    told = struct.pack("<BL", 1, zlib.crc32(part.name)) + name
    somewhere(part, draw, extra=struct.pack("<2H", 0x7075, len(told)) + told)


@trick
def links(one: Zip, draw: Random) -> None:
    target = draw.choice((b"log.json", b"../report.html", b"/etc/hostname", b"."))
    other = Part(draw.choice((b"a", b"certificates/x", REPORT)), target, STORED)
    other.listed["external"] = LINK << 16
    if other.name == REPORT:
        one.parts.remove(one.part(REPORT))
    one.parts.insert(0, other)
