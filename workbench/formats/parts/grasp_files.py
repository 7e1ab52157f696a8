"""Grasp libraries written: as a person would write them, and what people wrote left alone."""

import tomllib
from collections.abc import Iterable
from dataclasses import replace
from itertools import chain, count
from pathlib import Path
from typing import Any

import numpy as np
import tomlkit
from tomlkit.items import AoT

from workbench.formats.files.toml_documents import millimetres, read_document, short, shorts
from workbench.formats.files.toml_keys import Table
from workbench.formats.files.whole_files import write_whole
from workbench.formats.parts.reading import library_of, read_grasps
from workbench.model.errors import FileError
from workbench.model.geometry import Floats
from workbench.model.part import Entry, Grasp, GraspLibrary, GraspPair, GraspPattern
from workbench.model.part_edits import grasp_of

GRASPS = "grasps.toml"

HEAD = "Grasps of this part; lengths in mm, angles in degrees, in the part's frame (see part.toml)."

PATTERN_DEFAULTS = {"axis": [0, 0, 1], "across": [1, 0, 0], "through_mm": [0, 0, 0]}
"""What a pattern has when nothing is said."""


def save_grasps(path: Path, library: GraspLibrary) -> None:
    """Write a library into a grasp file, changing only what differs from it; comments stay.

    Raises:
        FileError: the file is there and cannot be read, or it cannot be written.
    """
    if path.is_file():
        old = read_grasps(path)
        if are_written_alike(old, library):
            return
        document: Any = read_document(path)
    else:
        old, document = GraspLibrary(), tomlkit.document()
        document.add(tomlkit.comment(HEAD))
        document.add(tomlkit.nl())
    # Tables in one line, as they may stand in a list, cannot be edited key by key.
    is_in_lines = isinstance(document.get("grasp"), AoT)
    kept = old.entries if is_in_lines else ()
    tables = dict(zip((e.name for e in kept), document["grasp"] if kept else (), strict=True))
    before = {entry.name: keys_of(entry) for entry in kept}
    grasps = tomlkit.aot()
    for entry in library.entries:
        table = tables.get(entry.name)
        grasps.append(_edit(table, before.get(entry.name, {}), keys_of(entry)))
    _put(document, "grasp", grasps)
    if old.searches != library.searches:
        _put_search(document, is_on=library.searches)
    if old.pairs != library.pairs:
        pairs = tomlkit.aot()
        for pair in library.pairs:
            pairs.append(_edit(None, {}, _pair_keys(pair)))
        _put(document, "pair", pairs)
    text = tomlkit.dumps(document)
    library_of(_table(path, text))  # what nobody could read again is not written
    write_whole(path, text.encode())


def add_grasps(path: Path, grasps: Iterable[Grasp]) -> tuple[str, ...]:
    """Write grasps behind those of a file, which is made when it is not there.

    Returns:
        Their names in the file: one that is taken gets a number behind it.

    Raises:
        FileError: the file cannot be read, or would hold what it may not; it is left as it is.
    """
    library = read_grasps(path) if path.exists() else GraspLibrary()
    taken = {entry.name for entry in library.entries} | {grasp.name for grasp in library.grasps}
    added: list[Grasp] = []
    for grasp in grasps:
        added.append(replace(grasp, name=_make_unused(grasp.name, taken)))
        taken.add(added[-1].name)
    save_grasps(path, replace(library, entries=(*library.entries, *added)))
    return tuple(grasp.name for grasp in added)


def _make_unused(name: str, taken: set[str]) -> str:
    """The name, with the first number behind it that makes it new."""
    numbered = (f"{name}-{number}" for number in count(2))
    return next(joint for joint in chain([name], numbered) if joint not in taken)


def are_written_alike(library: GraspLibrary, other: GraspLibrary) -> bool:
    """Whether two libraries make the same file, except for its comments."""

    def keys(grasp_library: GraspLibrary) -> list[dict[str, Any]]:
        return [keys_of(entry) for entry in grasp_library.entries] + [
            _pair_keys(p) for p in grasp_library.pairs
        ]

    return keys(library) == keys(other) and library.searches == other.searches


def as_written(library: GraspLibrary) -> GraspLibrary:
    """The library as it comes back from its file.

    Raises:
        FileError: it holds what no file may hold; names the key and what is expected.
    """
    document = tomlkit.document()
    if library.searches:
        document["search"] = True
    document["grasp"] = [keys_of(entry) for entry in library.entries]
    document["pair"] = [_pair_keys(pair) for pair in library.pairs]
    try:
        return library_of(_table(Path(GRASPS), tomlkit.dumps(document)))
    except ValueError as error:  # a text that TOML cannot hold
        raise FileError(GRASPS, f"cannot be written: {error}") from None


def keys_of(entry: Entry) -> dict[str, Any]:
    """The keys and values of an entry's table; what has its default is left out."""
    grasp = grasp_of(entry)
    R = np.asarray(grasp.T_part_tcp.rotation)
    keys: dict[str, Any] = {
        "name": grasp.name,
        "position_mm": millimetres(grasp.T_part_tcp.translation),
        "points_along": _direction(R[:, 2]),
        "closes_along": _direction(R[:, 1]),
        "opening_mm": short(grasp.opening * 1000),
        "grip_mm": short(grasp.grip * 1000),
        "approach": _direction(grasp.approach),
        "approach_length_mm": short(grasp.approach_length * 1000),
    }
    if keys["approach"] == [0, 0, 1]:
        del keys["approach"]
    if grasp.retreat is not None:
        keys["retreat"] = _direction(grasp.retreat)
    others = {
        "retreat_length_mm": (short(grasp.retreat_length * 1000), 100),
        "priority": (grasp.priority, 0),
        "enabled": (grasp.is_enabled, True),
        "arms": (list(grasp.arms), []),
        "tool": (grasp.tool, ""),
        "tcp": (grasp.tcp, ""),
        "free_rotation_deg": (_degrees(grasp.free_rotation), 0),
        "tilt_deg": (_degrees(grasp.tilt), 0),
        "slide_mm": (short(grasp.slide * 1000), 0),
    }
    keys |= {key: value for key, (value, usual) in others.items() if value != usual}
    if isinstance(entry, GraspPattern):
        keys["pattern"] = _pattern_keys(entry)
    return keys


def _pattern_keys(pattern: GraspPattern) -> dict[str, Any]:
    keys: dict[str, Any] = {
        "axis": _direction(pattern.axis),
        "through_mm": millimetres(pattern.through),
        "angles_deg": [_degrees(angle) for angle in pattern.angles],
        "offsets_mm": [short(offset * 1000) for offset in pattern.offsets],
    }
    if len(pattern.across_offsets) > 1 or any(pattern.across_offsets):
        keys["across"] = _direction(pattern.across)
        keys["across_mm"] = [short(offset * 1000) for offset in pattern.across_offsets]
    return {
        key: value
        for key, value in keys.items()
        if PATTERN_DEFAULTS.get(key) != value or key == "axis"
    }


def _pair_keys(pair: GraspPair) -> dict[str, Any]:
    ordered = {"ordered": True} if pair.is_ordered else {}
    return {"first": pair.first, "second": pair.second, **ordered}


def _edit(table: Any, before: dict[str, Any], now: dict[str, Any]) -> Any:
    """A table with what has changed; a new one where there was none."""
    table = tomlkit.table() if table is None else table
    for key in before.keys() - now.keys():
        table.pop(key, None)
    for key, value in now.items():
        if key == "pattern":
            old = before.get(key, {})
            table[key] = _edit(table.get(key), old, value)
        elif key not in before or before[key] != value:
            table[key] = value
    return table


def _put(document: Any, key: str, tables: Any) -> None:
    if not isinstance(document.get(key), AoT):
        # Where a list stood, other keys may follow, which must not get into the last table.
        document.pop(key, None)
    if len(tables):
        document[key] = tables
    else:
        document.pop(key, None)


def _put_search(document: Any, *, is_on: bool) -> None:
    """Keys of the file itself stand before its tables."""
    document.pop("search", None)
    if is_on:
        tables = {key: document.pop(key) for key in ("grasp", "pair") if key in document}
        document["search"] = True
        document.update(tables)


def _table(path: Path, text: str) -> Table:
    return Table(path, tomllib.loads(text))


def _direction(vector: Floats) -> list[float | int]:
    return shorts(vector, 6)


def _degrees(angle: float) -> float | int:
    return short(float(np.rad2deg(angle)))
