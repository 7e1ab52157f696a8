"""The JSON Schema of cell files, for editors: made from what the reader asks of the shipped cells.

So it says what the reader says: keys, kinds, ranges and choices.  What depends on other keys (a
capsule has a length, a ball has none) is left to the reader.
"""

import json
from pathlib import Path
from typing import Any

from workbench.formats.cells.calibrations import read_record
from workbench.formats.cells.reading import read_cell, read_poses_folder
from workbench.formats.files.toml_keys import NOTES, Notes, Table
from workbench.formats.robots.dh import read_dh

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


A_RECORD = {"at": "2026-01-31T12:00:00Z", "by": "somebody", "poses": 8, "rms_mm": 0.1}


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
    finally:
        NOTES.reset(token)
    notes = {place: form for place, form in notes.items() if not _is_foreign(place)}
    for place in ("robot.dh", "scanner.calibration", "detections"):
        notes[place] = {"type": "object", "required": False}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A cell of Workbench: lengths in mm, angles in degrees",
        **_object(notes, ""),
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
    "detections",
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
