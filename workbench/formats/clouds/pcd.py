"""Point clouds in PCD files: ascii, binary, and compressed; with the colours of points.

Source: Point Cloud Library, "The PCD (Point Cloud Data) file format", version 0.7; M. Lehmann,
LibLZF, for how compressed data is packed.
"""

from pathlib import Path
from typing import NamedTuple

import numpy as np

from workbench.formats.clouds.colours import PACKED, unpack_colours
from workbench.formats.files.text_rows import read_rows
from workbench.formats.files.toml_keys import quote
from workbench.model.errors import FileError
from workbench.model.geometry import Floats
from workbench.model.messages.files import FileProblem

LONGEST_HEADER = 64 * 1024
MOST_VALUES = 10_000
"""Of one field: more than any descriptor of a point has."""

NUMBER_TYPES = {
    ("F", 4): "<f4", ("F", 8): "<f8", ("U", 1): "<u1", ("U", 2): "<u2", ("U", 4): "<u4",
    ("U", 8): "<u8", ("I", 1): "<i1", ("I", 2): "<i2", ("I", 4): "<i4", ("I", 8): "<i8",
}  # fmt: skip


AXIS_NAMES = ("x", "y", "z")


class Layout(NamedTuple):
    """What a header says: fields with their types and how many values each has, and the size."""

    names: tuple[str, ...]
    kinds: tuple[str, ...]
    counts: tuple[int, ...]
    width: int
    height: int
    encoding: str
    end: int


class PcdCloud(NamedTuple):
    """Points (n, 3) in the file's own unit; columns and rows of an organised one.

    `colours` (n, 3), 0 to 255, are None where the file has none.
    """

    points: Floats
    resolution: tuple[int, int] | None
    colours: np.ndarray | None


def read_pcd(path: Path, content: bytes, most: int) -> PcdCloud:
    """The points of a PCD file.

    Raises:
        FileError: not a PCD file, more than `most` points, cut off, or without x, y, z.
    """
    layout = _layout(path, content)
    count = layout.width * layout.height
    if not 0 < count <= most:
        raise FileError(path, f"declares {count} points, 1 to {most} are read")
    if any(layout.names.count(axis) != 1 for axis in AXIS_NAMES) or not all(
        many for name, many in zip(layout.names, layout.counts, strict=True) if name in AXIS_NAMES
    ):
        raise FileError(path, f"FIELDS {' '.join(layout.names)[:80]}: x, y and z are expected")
    packed = _find_packed(layout)
    names = AXIS_NAMES if packed is None else (*AXIS_NAMES, packed)
    match layout.encoding:
        case "ascii":
            columns = _ascii(path, content, layout, count, names)
        case "binary":
            columns = _binary(path, content[layout.end :], layout, count, names)
        case _:
            columns = _decompress(path, content[layout.end :], layout, count, names)
    with np.errstate(invalid="ignore"):
        points = np.column_stack([column.astype(np.float64) for column in columns[:3]])
    colours = None if packed is None else unpack_colours(columns[3])
    organised = (layout.width, layout.height) if layout.height > 1 else None
    return PcdCloud(points, organised, colours)


def _find_packed(layout: Layout) -> str | None:
    """The field that holds colours, if there is one, once, of four bytes."""
    for name, kind, count in zip(layout.names, layout.kinds, layout.counts, strict=True):
        if name in PACKED and layout.names.count(name) == 1 and kind[2] == "4" and count == 1:
            return name
    return None


def _layout(path: Path, content: bytes) -> Layout:
    head = content[:LONGEST_HEADER]
    items: dict[str, list[str]] = {}
    end = 0
    while "DATA" not in items:
        line, newline, _ = head[end:].partition(b"\n")
        if not newline:
            detail = "its header has no line DATA"
            raise FileError(path, FileProblem.NO_KIND(kind="PCD", detail=detail))
        end += len(line) + 1
        try:
            words = line.decode("ascii").split()
        except UnicodeDecodeError:
            detail = "its header is not text"
            raise FileError(path, FileProblem.NO_KIND(kind="PCD", detail=detail)) from None
        if words and not words[0].startswith("#"):
            items[words[0].upper()] = words[1:]
    names = items.get("FIELDS", [])
    sizes = _wholes(path, items, "SIZE", len(names))
    types = items.get("TYPE", [])
    if not names or len(types) != len(names):
        raise FileError(path, f"TYPE: {len(names)} letters are expected, as there are FIELDS")
    kinds = [
        NUMBER_TYPES.get((kind.upper(), size)) for kind, size in zip(types, sizes, strict=True)
    ]
    if None in kinds:
        raise FileError(path, f"TYPE {quote(types)} with SIZE {sizes}: is not known")
    counts = _wholes(path, items, "COUNT", len(names)) if "COUNT" in items else [1] * len(names)
    (width,) = _wholes(path, items, "WIDTH", 1)
    (height,) = _wholes(path, items, "HEIGHT", 1)
    encoding = " ".join(items["DATA"]).lower()
    if encoding not in ("ascii", "binary", "binary_compressed"):
        raise FileError(path, f"DATA {quote(encoding)}: ascii, binary or binary_compressed")
    if max(counts) > MOST_VALUES:
        raise FileError(path, f"COUNT {max(counts)}: a field has at most {MOST_VALUES} values")
    known = tuple(kind for kind in kinds if kind is not None)
    return Layout(tuple(names), known, tuple(counts), width, height, encoding, end)


def _wholes(path: Path, items: dict[str, list[str]], key: str, count: int) -> list[int]:
    words = items.get(key, [])
    if len(words) != count or not all(word.isdigit() and len(word) < 10 for word in words):
        raise FileError(path, f"{key} {quote(' '.join(words))}: {count} whole numbers expected")
    return [int(word) for word in words]


def _row(layout: Layout) -> np.dtype:
    return np.dtype(
        [
            (f"{number}", kind, (count,))
            for number, (kind, count) in enumerate(zip(layout.kinds, layout.counts, strict=True))
        ]
    )


def _binary(
    path: Path, data: bytes, layout: Layout, count: int, names: tuple[str, ...]
) -> list[np.ndarray]:
    row = _row(layout)
    if len(data) < count * row.itemsize:
        raise FileError(path, FileProblem.CUT_OFF(detail=f"{count} points were declared"))
    rows = np.frombuffer(data, row, count)
    return [rows[f"{layout.names.index(name)}"][:, 0] for name in names]


def _ascii(
    path: Path, content: bytes, layout: Layout, count: int, names: tuple[str, ...]
) -> list[np.ndarray]:
    starts = np.cumsum([0, *layout.counts])
    columns = [int(starts[layout.names.index(name)]) for name in names]
    values = read_rows(path, content, layout.end, columns=columns, count=count)
    kinds = [layout.kinds[layout.names.index(name)] for name in names]
    with np.errstate(invalid="ignore", over="ignore"):
        return [
            column.astype(kind if name in PACKED else np.float64)
            for name, kind, column in zip(names, kinds, values.T, strict=True)
        ]


def _decompress(
    path: Path, data: bytes, layout: Layout, count: int, names: tuple[str, ...]
) -> list[np.ndarray]:
    """Field by field, packed by LZF behind the two sizes."""
    from workbench.formats.clouds.lzf import unpack  # what compiles is large; most are not packed

    if len(data) < 8:
        raise FileError(path, "is cut off")
    length, size = np.frombuffer(data, "<u4", 2).tolist()
    row = _row(layout)
    if size != count * row.itemsize or len(data) < 8 + length:
        raise FileError(path, "is cut off, or its sizes do not fit its points")
    fields = np.zeros(size, np.uint8)
    if unpack(np.frombuffer(data, np.uint8, length, 8), fields) != size:
        raise FileError(path, "its compressed data is broken")
    columns = dict[str, np.ndarray]()
    start = 0
    for number, (name, kind, values) in enumerate(
        zip(layout.names, layout.kinds, layout.counts, strict=True)
    ):
        length = count * row[f"{number}"].itemsize
        if name in names:
            columns[name] = fields[start : start + length].view(kind).reshape(count, values)[:, 0]
        start += length
    return [columns[name] for name in names]
