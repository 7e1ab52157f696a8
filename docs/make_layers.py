"""The layers, their folders, and who imports whom, drawn from the code as `pictures/layers.svg`.

`python docs/make_layers.py` draws it anew; a test says when that is due.  An arrow that follows
from others is left out: who imports by way of a third one is clear without it.
"""

import ast
import tomllib
from collections.abc import Iterator
from dataclasses import dataclass
from html import escape
from itertools import pairwise
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PACKAGE = ROOT / "workbench"
PICTURE = ROOT / "docs" / "pictures" / "layers.svg"

COLUMNS = {
    "extras": (0, 12),
    "api": (2, 3.5),
    "cli": (3.5, 12),
    "web": (3.5, 6),
    "gui": (6, 10.5),
    "studies": (10.5, 12),
    "words": (5, 7),
    "testing": (0, 2),
    "app": (2, 12),
    "perception": (0, 3),
    "planning": (3, 7),
    "devices": (7, 10),
    "journal": (10, 11),
    "proof": (11, 12),
    "formats": (4.5, 10),
    "plugins": (0, 10),
    "model": (0, 12),
}
"""From which to which of twelve columns a layer reaches; the rows are those of import-linter."""

LEFT_OUT = {("words", "model"), ("web", "devices")}
"""Arrows that have no way down between the layers."""

COLUMN, GAP, BETWEEN, EDGE = 75, 12, 34, 16
LINE, CHIP, LETTER = 28, 22, 6.4
"""[px] Height of a line of folders and of one of them, and the usual width of a letter."""

STYLE = """
text { font: 11px system-ui, "DejaVu Sans", sans-serif; fill: #33404d }
.name { font-size: 14px; font-weight: 600 }
.in { text-anchor: middle }
.layer { fill: #eef2f6; stroke: #9fb0c0 }
.folder { fill: #ffffff; stroke: #d3dce4 }
.arrow { stroke: #7d8fa0; stroke-width: 1.5; fill: none; marker-end: url(#tip) }
"""


@dataclass(frozen=True)
class Drawn:
    """A layer on the sheet: its edges [px], and its folders line by line."""

    left: float
    right: float
    top: float
    bottom: float
    lines: list[list[str]]


def layers() -> list[list[str]]:
    """The rows of layers from top to bottom, as import-linter checks them."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    contracts = project["tool"]["importlinter"]["contracts"]
    (rows,) = (one for one in contracts if one["id"] == "layers")
    return [row.split(" | ") for row in rows["layers"]]


def imports() -> dict[str, set[str]]:
    """Which layers each layer imports, wherever in a file."""
    known = [name for row in layers() for name in row]
    found: dict[str, set[str]] = {name: set() for name in known}
    for layer in known:
        files = (PACKAGE / layer).rglob("*.py") if _is_folder(layer) else [PACKAGE / f"{layer}.py"]
        for file in files:
            for node in _run(ast.parse(file.read_text(encoding="utf-8"))):
                if isinstance(node, ast.ImportFrom) and node.module is not None:
                    root, _, rest = node.module.partition(".")
                    other = rest.partition(".")[0]
                    if root == "workbench" and other in found and other != layer:
                        found[layer].add(other)
    return found


def _run(tree: ast.AST) -> Iterator[ast.AST]:
    """All of a file but what is imported for readers of types alone."""
    for node in ast.iter_child_nodes(tree):
        is_for_types = isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
        if not is_for_types:
            yield node
            yield from _run(node)


def without_detours(graph: dict[str, set[str]]) -> list[tuple[str, str]]:
    """The arrows that follow from no others; there are no circles, as import-linter checks."""

    def beyond(name: str) -> set[str]:
        return graph[name].union(*(beyond(other) for other in graph[name]))

    return [
        (one, other)
        for one in graph
        for other in sorted(graph[one])
        if not any(other in beyond(third) for third in graph[one])
    ]


def placed() -> dict[str, Drawn]:
    """Where each layer is drawn; layers of one row are equally high."""
    found: dict[str, Drawn] = {}
    top = float(EDGE)
    for row in layers():
        wrapped = {name: _wrapped(name) for name in row}
        bottom = top + 32 + max(len(lines) for lines in wrapped.values()) * LINE
        for name, lines in wrapped.items():
            left, right = (EDGE + COLUMN * column for column in COLUMNS[name])
            found[name] = Drawn(left, right - GAP, top, bottom, lines)
        top = bottom + BETWEEN
    return found


def _wrapped(layer: str) -> list[list[str]]:
    """The folders of a layer in lines that fit into it."""
    first, last = COLUMNS[layer]
    room = (last - first) * COLUMN - GAP
    lines: list[list[str]] = []
    used = room
    for folder in sorted((PACKAGE / layer).glob("*/__init__.py")):
        width = _width(folder.parent.name) + 6
        if used + width > room - 14:
            lines.append([])
            used = 0
        lines[-1].append(folder.parent.name)
        used += width
    return lines


def _is_folder(layer: str) -> bool:
    return (PACKAGE / layer).is_dir()


def _width(text: str) -> float:
    return LETTER * len(text) + 14


def arrow(one: str, other: str, places: dict[str, Drawn]) -> str:
    """A straight arrow down, where no layer is in between."""
    start, end = places[one], places[other]
    between = [
        (box.left, box.right)
        for box in places.values()
        if start.bottom < box.top and box.bottom < end.top
    ]
    low, high = max(start.left, end.left), min(start.right, end.right)
    stops = sorted({low, high, *(x for pair in between for x in pair if low < x < high)})
    free = [
        (right - left, (left + right) / 2)
        for left, right in pairwise(stops)
        if not any(a < (left + right) / 2 < b for a, b in between)
    ]
    if not free or max(free)[0] < GAP:
        raise ValueError(f"no way down from {one} to {other}: give them other COLUMNS")
    x = max(free)[1]
    return f'<path class="arrow" d="M {x:g} {start.bottom:g} V {end.top - 2:g}"/>'


def drawing() -> str:
    """The picture as SVG."""
    places = placed()
    width = 2 * EDGE + 12 * COLUMN - GAP
    height = max(box.bottom for box in places.values()) + EDGE
    lines = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height:g}" '
        f'width="{width}" height="{height:g}" role="img">',
        "<title>The layers of Workbench, their folders, and which imports which</title>",
        f"<style>{STYLE}</style>",
        '<marker id="tip" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="7" markerHeight="7" '
        'orient="auto"><path d="M 0 0 L 8 4 L 0 8 z" fill="#7d8fa0"/></marker>',
        f'<rect width="{width}" height="{height:g}" fill="#ffffff"/>',
    ]
    for name, box in places.items():
        lines += _box(name if _is_folder(name) else f"{name}.py", box)
    shown = [pair for pair in without_detours(imports()) if pair not in LEFT_OUT]
    lines += [arrow(one, other, places) for one, other in shown]
    return "\n".join([*lines, "</svg>"]) + "\n"


def _box(title: str, box: Drawn) -> list[str]:
    lines = [
        f'<rect class="layer" x="{box.left:g}" y="{box.top:g}" width="{box.right - box.left:g}" '
        f'height="{box.bottom - box.top:g}" rx="6"/>',
        f'<text class="name" x="{box.left + 10:g}" y="{box.top + 21:g}">{escape(title)}</text>',
    ]
    for number, folders in enumerate(box.lines):
        x, y = box.left + 10, box.top + 32 + number * LINE
        for folder in folders:
            wide = _width(folder)
            lines += [
                f'<rect class="folder" x="{x:g}" y="{y:g}" width="{wide:g}" '
                f'height="{CHIP}" rx="3"/>',
                f'<text class="in" x="{x + wide / 2:g}" y="{y + 15:g}">{escape(folder)}</text>',
            ]
            x += wide + 6
    return lines


if __name__ == "__main__":
    PICTURE.write_text(drawing(), encoding="utf-8")
