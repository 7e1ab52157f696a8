"""The JSON Schema of cell files, for editors: made from what the reader asks of the shipped cells.

So it says what the reader says: keys, kinds, ranges and choices.  What depends on other keys (a
capsule has a length, a ball has none) is left to the reader.
"""

import json
from pathlib import Path
from typing import Any

from workbench.formats.cells.calibrations import read_record
from workbench.formats.cells.devices import read_localizer
from workbench.formats.cells.places import read_stations
from workbench.formats.cells.reading import read_cell, read_poses_folder
from workbench.formats.cells.tools import LOAD_KEYS
from workbench.formats.files.toml_keys import NOTES, Notes, Table
from workbench.formats.robots.dh import read_dh
from workbench.plugins.found import Group, load, names
from workbench.plugins.options import schema_of

NOT_ALWAYS = frozenset(
    ("urdf", "srdf", "dh", "controller", "policy", "size_mm", "radius_mm", "length_mm", "file")
    + ("unit", "range_deg", "speed_deg", "range_mm", "speed_mm")
)
"""Keys that only some kinds of a table have, or that are read only when they are given."""

BY_AXES = frozenset({"axes", "signs", "home_deg"})
"""Lists with a number for each axis of the arm."""

A_TABLE = {
    "convention": "standard",
    "joint": [
        {"range_deg": [-1, 1], "speed_deg": 1},
        {"kind": "prismatic", "range_mm": [0, 1], "speed_mm": 1},
    ],
}
"""A Denavit-Hartenberg table with a joint of each kind: no shipped cell has one."""


A_RECORD = {
    "at": "2026-01-31T12:00:00Z",
    "by": "somebody",
    "poses": 8,
    "rms_mm": 0.1,
    "sure_mm": 0.2,
    "sure_deg": 0.02,
    "covariance": [0.0] * 21,
}

A_STATION = {"name": "table", "size_mm": [100, 100]}


def cell_schema() -> dict[str, Any]:
    """The schema, draft 2020-12."""
    notes: Notes = {}
    token = NOTES.set(notes)
    try:
        for name in ("yumi", "tx2_90"):
            read_cell(name)
        file = Path("cell.toml")
        read_dh(Table(file, A_TABLE, "robot.dh."), "robot")
        read_record(Table(file, A_RECORD, "scanner.calibration."))
        read_poses_folder(Table(file, {"path": "poses"}, "detections."))
        read_stations(Table(file, {"station": [A_STATION]}), ())
        read_localizer(Table(file, {"name": names("workbench.localizers")[0]}, "localizer."))
    finally:
        NOTES.reset(token)
    notes = {place: form for place, form in notes.items() if not _is_foreign(place)}
    for place in ("robot.dh", "scanner.calibration", "detections", "localizer"):
        notes[place] = {"type": "object", "required": False}
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A cell of Workbench: lengths in mm, angles in degrees",
        **_object(notes, ""),
    }
    _add_options(schema)
    return schema


def _add_options(schema: dict[str, Any]) -> None:
    """The keys that each installed plug-in has of its own, and tools by their kind."""
    tables = schema["properties"]
    seams: tuple[tuple[str, str, Group], ...] = (
        ("scanner", "source", "workbench.scanners"),
        ("controller", "protocol", "workbench.robot_links"),
        ("localizer", "name", "workbench.localizers"),
    )
    for table, key, group in seams:
        tables[table]["properties"]["options"] = {"type": "object"}
        tables[table]["allOf"] = [_with_options(key, name, group) for name in names(group)]
    # A tool of a kind has its name, its load and options; any other has what the reader asks of it.
    explicit = tables["tool"]["items"]
    loads = {key: explicit["properties"][key] for key in LOAD_KEYS}
    kinds = [
        {
            "type": "object",
            "properties": {
                "name": {"type": "string"},
                "kind": {"const": name},
                "options": schema_of(load("workbench.tools", name).Options),
                **loads,
            },
            "required": ["kind", "name"],
            "additionalProperties": False,
        }
        for name in names("workbench.tools")
    ]
    tables["tool"]["items"] = {"anyOf": [explicit, *kinds]}


def _with_options(key: str, name: str, group: Group) -> dict[str, Any]:
    """Where a table names this plug-in, its options are those that it has."""
    return {
        "if": {"properties": {key: {"const": name}}, "required": [key]},
        "then": {"properties": {"options": schema_of(load(group, name).Options)}},
    }


def schema_text() -> str:
    """The schema as the file `robots/cell.schema.json` has it."""
    return json.dumps(cell_schema(), indent=1) + "\n"


def _is_foreign(place: str) -> bool:
    """Whether a key is of a part's files, which are read with a cell."""
    top = place.partition(".")[0].partition("[")[0]
    return top not in TOP


TOP = (
    "name",
    "parts",
    "robot",
    "tool",
    "arm",
    "bin",
    "scanner",
    "controller",
    "policy",
    "fixture",
    "station",
    "detections",
    "localizer",
)


def _object(notes: Notes, place: str) -> dict[str, Any]:
    """The schema of the table at a place, with those in it."""
    properties: dict[str, Any] = {}
    required: list[str] = []
    for full, form in notes.items():
        if not full.startswith(place) or "." in full[len(place) :]:
            continue
        key = full[len(place) :]
        hidden = {"required", "minItems", "maxItems"} if key in BY_AXES else {"required"}
        shown = {name: value for name, value in form.items() if name not in hidden}
        if form["type"] == "object":
            shown = _object(notes, f"{full}.")
        elif form["type"] == "array" and form["items"] == {"type": "object"}:
            shown = {"type": "array", "items": _object(notes, f"{full}[].")}
        properties[key] = shown
        if form["required"] and key not in NOT_ALWAYS:
            required.append(key)
    return {
        "type": "object",
        "properties": properties,
        "required": sorted(required),
        "additionalProperties": False,
    }
