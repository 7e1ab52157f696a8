"""The header of a PLY file: what follows it, and where.

Source: G. Turk, "The PLY Polygon File Format", Stanford 1994.
"""

import re
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from workbench.formats.files.toml_keys import quote
from workbench.model.errors import FileError
from workbench.model.messages.files import FileProblem

LONGEST_HEADER = 64 * 1024
ENCODINGS = ("ascii", "binary_little_endian", "binary_big_endian")

NUMBER_TYPES = {
    "char": "i1",
    "int8": "i1",
    "uchar": "u1",
    "uint8": "u1",
    "short": "i2",
    "int16": "i2",
    "ushort": "u2",
    "uint16": "u2",
    "int": "i4",
    "int32": "i4",
    "uint": "u4",
    "uint32": "u4",
    "float": "f4",
    "float32": "f4",
    "double": "f8",
    "float64": "f8",
}
"""PLY's names of scalar types, old and new, and NumPy's."""

LIST = ""
"""The kind of a property that is a list, of which the size is not known beforehand."""

_END = re.compile(rb"\nend_header[ \t]*\r?\n")
_COUNT = re.compile(r"[0-9]{1,18}")


@dataclass(slots=True)
class PlyElement:
    """This many rows with properties (name, NumPy kind without byte order, or `LIST`)."""

    name: str
    count: int
    properties: list[tuple[str, str]] = field(default_factory=list[tuple[str, str]])

    def size(self, path: Path) -> int:
        """How long [bytes] a row is.

        Raises:
            FileError: that is not known beforehand.
        """
        if any(kind == LIST for _, kind in self.properties):
            raise FileError(
                path,
                f"element {quote(self.name)}: lists ahead of what is read are not supported",
            )
        return sum(np.dtype(kind).itemsize for _, kind in self.properties)


@dataclass(frozen=True, slots=True)
class PlyHeader:
    """What a reader of the vertices needs.

    `count` vertices with scalar `properties` (name, NumPy kind without byte order) begin
    `skip_bytes` (binary) or `skip_lines` (ascii) after offset `end`; `notes` are the texts
    of the `obj_info` lines, `after` the elements that follow.
    """

    encoding: str
    count: int
    properties: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]
    end: int
    skip_bytes: int
    skip_lines: int
    after: tuple[PlyElement, ...]

    def size(self, path: Path) -> int:
        """How long [bytes] a vertex is."""
        return PlyElement("vertex", self.count, list(self.properties)).size(path)

    @property
    def names(self) -> tuple[str, ...]:
        """The names of the properties."""
        return tuple(name for name, _ in self.properties)


def read_header(path: Path, content: bytes) -> PlyHeader:
    """The header at the beginning of `content`.

    Raises:
        FileError: not that of a PLY file with vertices of scalar properties x, y, z.
    """
    lines, end = _split(path, content)
    encoding, elements, notes = "", list[PlyElement](), list[str]()
    for number, line in enumerate(lines[1:], start=2):
        match line.split():
            case ["format", given, "1.0"] if given in ENCODINGS and not encoding:
                encoding = given
            case ["comment", *_]:
                pass
            case ["obj_info", *words]:
                notes.append(" ".join(words))
            case ["element", name, count] if _COUNT.fullmatch(count):
                elements.append(PlyElement(name, int(count)))
            case ["property", "list", size, item, name] if {
                size,
                item,
            } <= NUMBER_TYPES.keys() and elements:
                elements[-1].properties.append((name, LIST))
            case ["property", kind, name] if kind in NUMBER_TYPES and elements:
                elements[-1].properties.append((name, NUMBER_TYPES[kind]))
            case _:
                raise FileError(path, f"line {number}: {quote(line)} has no place in a PLY header")
    if not encoding:
        raise FileError(path, f"the PLY header names no format ({', '.join(ENCODINGS)})")
    names = [element.name for element in elements]
    if names.count("vertex") != 1:
        raise FileError(path, "the PLY header must declare one element vertex")
    before = elements[: names.index("vertex")]
    vertex = elements[len(before)]
    _check_vertex(path, vertex)
    return PlyHeader(
        encoding=encoding,
        count=vertex.count,
        properties=tuple(vertex.properties),
        notes=tuple(notes),
        end=end,
        skip_bytes=0
        if encoding == "ascii"
        else sum(element.count * element.size(path) for element in before),
        skip_lines=sum(element.count for element in before),
        after=tuple(elements[len(before) + 1 :]),
    )


def _split(path: Path, content: bytes) -> tuple[list[str], int]:
    """The header's lines from `ply` up to `end_header`, and the offset behind them."""
    if not re.match(rb"ply[ \t]*\r?\n", content):
        detail = "it does not begin with a line `ply`"
        raise FileError(path, FileProblem.NO_KIND(kind="PLY", detail=detail))
    end = _END.search(content, 0, LONGEST_HEADER)
    if end is None:
        raise FileError(path, "the PLY header has no line `end_header`")
    # Comments may be in any alphabet; nothing else in a header has more than ASCII.
    lines = content[: end.start()].decode("latin-1").split("\n")
    return [line.strip() for line in lines], end.end()


def _check_vertex(path: Path, vertex: PlyElement) -> None:
    names = [name for name, _ in vertex.properties]
    for name in ("x", "y", "z"):
        if name not in names:
            raise FileError(path, f"its vertices have no property {name}")
    for name, kind in vertex.properties:
        if kind == LIST:
            raise FileError(path, f"property {quote(name)}: vertices with lists are not supported")
        if names.count(name) > 1:
            raise FileError(path, f"property {quote(name)} is declared twice")
