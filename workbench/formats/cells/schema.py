"""The JSON Schema of cell files, for editors: made from what the reader asks of the shipped cells.

So it says what the reader says: keys, kinds, ranges, choices and defaults.  What depends on other
keys (a capsule has a length, a ball has none) is left to the reader.  `key_meanings.toml` has what
each key means.  The schemas of part and grasp files are for the page of keys in the documents.
"""

import json
import tomllib
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from workbench.formats.cells.calibrations import read_record
from workbench.formats.cells.devices import read_localizer
from workbench.formats.cells.places import read_bin, read_places, read_stations
from workbench.formats.cells.reading import read_cell, read_poses_folder
from workbench.formats.cells.recipes import OF_INSERTION, read_recipes
from workbench.formats.cells.tools import LOAD_KEYS, read_slots, read_tcp
from workbench.formats.files.shipped import find
from workbench.formats.files.toml_keys import NOTES, Notes, Table
from workbench.formats.meshes.solids import read_solid
from workbench.formats.parts.reading import library_of, read_part, read_upright
from workbench.formats.robots.dh import read_dh
from workbench.plugins.found import Group, load, names
from workbench.plugins.options import schema_of

NOT_ALWAYS = frozenset(
    ("urdf", "srdf", "dh", "controller", "policy", "covariance", "symmetry", "pattern", "joint")
    + ("range_deg", "speed_deg", "range_mm", "speed_mm")
)
"""Keys that only some kinds of a table have, or that are read only when they are given."""

BY_SHAPE = frozenset({"size_mm", "radius_mm", "length_mm", "file"})
"""Keys that only solids of some shapes have."""

BY_AXES = frozenset({"axes", "signs", "home_deg", "joints_deg", "axis_coupling", "axis_offsets"})
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

A_PLACE = {"part": "cap", "part_position_mm": [0, 0, 0], "centred_mm": 0.1, "centred_deg": 0.1}

A_SLOT = {"tool": "cup", "fixture": "rack"}

A_STATION = {"name": "table", "size_mm": [100, 100]}

A_RECIPE = {
    "number": 1,
    "name": "caps",
    "threshold_mm": 100,
    "speed": 0.3,
    "item": [
        {"part": "cap"},
        {
            "part": "ring",
            "on": "cap",
            "position_mm": [0, 0, 0],
            "insert_mm": 50,
            "clearance_mm": 0.5,
            "look_again": True,
            "joint": {"mouth_mm": [0, 0, 0], "depth_mm": 9, "radial_clearance_mm": 1},
        },
    ],
}

A_BIN = {
    "name": "left",
    "size_mm": [100, 100, 50],
    "region": [{"name": "left", "size_mm": [50, 100, 50]}],
}

SOLIDS = (
    {"name": "box", "shape": "box", "size_mm": [1, 1, 1]},
    {"name": "rod", "shape": "cylinder", "radius_mm": 1, "length_mm": 1},
    {"name": "palm", "shape": "mesh", "file": "meshes/palm.convex.obj", "unit": "m"},
)
"""A solid of each kind that has keys of its own; the file is of the shipped YuMi."""

SOLID_TABLES = (
    "tool[].body[].",
    "tool[].finger[].",
    "fixture[].solid[].",
    "scanner.on_arm.housing[].",
    "piece[].",
)

A_GRASP = {
    "name": "top",
    "position_mm": [0, 0, 0],
    "points_along": [0, 0, 1],
    "closes_along": [0, 1, 0],
    "opening_mm": 1,
    "grip_mm": 1,
    "retreat": [0, 0, 1],
    "pattern": {},
}

GRASPS = {
    "grasp": [A_GRASP, A_GRASP | {"name": "side", "pattern": {"offsets_mm": [1]}}],
    "pair": [{"first": "top", "second": "side"}],
}

DEPENDS = frozenset(
    ("scanner.on_arm.view.joints_deg",)
    + ("arm[].axes", "arm[].signs", "arm[].tools", "arm[].controller_id", "arm[].jerk_deg")
    + ("arm[].moving_mass_kg", "policy.contact_energy_j")
    + ("arm[].axis_coupling", "arm[].axis_offsets", "arm[].tool_slot[].leave")
    + ("controller.state_port", "policy.least_air_mm", "policy.lifts", "policy.pair_gap_mm")
    + ("tool[].force_n", "tool[].mass_g", "tool[].centre_of_gravity_mm", "tool[].inertia_kgm2")
    + ("scanner.calibration.sure_mm", "scanner.calibration.sure_deg")
    + ("friction", "tolerance_mm", "arm[].place[].part_position_mm", "grasp[].retreat")
    + ("recipe[].parts", "recipe[].grasps", "recipe[].places", "recipe[].strategy")
    + ("recipe[].threshold_mm", "recipe[].speed")
    + tuple(f"recipe[].item[].{key}" for key in ("on", *OF_INSERTION))
    + tuple(f"recipe[].item[].joint.{key}_length_mm" for key in ("part", "base"))
    + ("arm[].place[].centred_mm", "arm[].place[].centred_deg")
    + ("policy.tcp_speed_mm", "policy.point_speed_mm", "policy.held_speed_mm", "bin.drop_back_mm")
    + ("bin[].drop_back_mm",)
)
"""Keys without which something else counts than a value: their meaning says what."""


def cell_schema() -> dict[str, Any]:
    """The schema, draft 2020-12."""
    with _take_notes() as notes:
        for name in ("yumi", "tx2_90"):
            read_cell(name)
        read_cell(find("robots", "yumi") / "on_arm.toml")
        _read_solids()
        file = Path("cell.toml")
        read_bin(Table(file, A_BIN, "bin."))
        read_tcp(Table(file, {"name": "left"}, "tool[].tcp."))
        read_dh(Table(file, A_TABLE, "robot.dh."), "robot")
        read_record(Table(file, A_RECORD, "scanner.calibration."))
        read_poses_folder(Table(file, {"path": "poses"}, "detections."))
        read_places(Table(file, {"place": [A_PLACE]}, "arm[]."))
        read_slots(Table(file, {"tool_slot": [A_SLOT]}, "arm[]."), ("cup",))
        read_stations(Table(file, {"station": [A_STATION]}), ())
        read_recipes(Table(file, {"recipe": [A_RECIPE]}))
        read_localizer(Table(file, {"name": names("workbench.localizers")[0]}, "localizer."))
    notes = {place: form for place, form in notes.items() if not _is_foreign(place)}
    for place in ("robot.dh", "scanner.calibration", "scanner.on_arm", "detections", "localizer"):
        notes[place] = {"type": "object", "required": False}
    schema = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "A cell of Workbench: lengths in mm, angles in degrees",
        **_object(notes, ""),
    }
    _add_options(schema)
    return schema


def part_schema() -> dict[str, Any]:
    """The schema of `part.toml`."""
    with _take_notes() as notes:
        for name in ("keyed_cylinder", "puck"):
            read_part(name)
        _read_solids()
        read_upright(Table(Path("part.toml"), {"tilt_deg": 10}, "upright."))
    notes["upright"] = {"type": "object", "required": False}
    mine = ("grasp", "pair", "search", "tool", "fixture")
    return _object({place: form for place, form in notes.items() if _top(place) not in mine}, "")


def grasp_schema() -> dict[str, Any]:
    """The schema of `grasps.toml`."""
    with _take_notes() as notes:
        library_of(Table(Path("grasps.toml"), GRASPS))
    for key in ("pair[].first", "pair[].second"):
        del notes[key]["enum"]  # the names of this library's grasps
    return _object(notes, "")


@contextmanager
def _take_notes() -> Generator[Notes]:
    """What tables are asked meanwhile."""
    notes: Notes = {}
    token = NOTES.set(notes)
    try:
        yield notes
    finally:
        NOTES.reset(token)


def _read_solids() -> None:
    file = find("robots", "yumi") / "cell.toml"
    for place in SOLID_TABLES:
        for solid in SOLIDS:
            read_solid(Table(file, solid, place))


def _meanings() -> dict[str, str]:
    """What each key means, by its place, or by `*.` and its own name."""
    return tomllib.loads(MEANINGS.read_text(encoding="utf-8"))


MEANINGS = Path(__file__).with_name("key_meanings.toml")


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
                "name": explicit["properties"]["name"],
                "kind": {"const": name, "description": _meanings()["tool[].kind"]},
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
    schema = cell_schema()
    tables = schema["properties"]
    on_arm = tables["scanner"]["properties"]["on_arm"]["properties"]
    tool = tables["tool"]["items"]["anyOf"][0]["properties"]
    for owner, key in ((tables, "bin"), (on_arm, "view"), (tool, "tcp")):
        owner[key] = {"anyOf": [owner[key], {"type": "array", "items": owner[key]}]}
    return json.dumps(schema, indent=1) + "\n"


def _is_foreign(place: str) -> bool:
    """Whether a key is of a part's files, which are read with a cell."""
    return _top(place) not in TOP


def _top(place: str) -> str:
    return place.partition(".")[0].partition("[")[0]


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
    "recipe",
    "detections",
    "localizer",
)


def _object(notes: Notes, place: str) -> dict[str, Any]:
    """The schema of the table at a place, with those in it."""
    meanings = _meanings()
    properties: dict[str, Any] = {}
    required: list[str] = []
    for full, form in notes.items():
        if not full.startswith(place) or "." in full[len(place) :]:
            continue
        key = full[len(place) :]
        hidden = {"required", "minItems", "maxItems"} if key in BY_AXES else {"required"}
        hidden |= {"default"} if full in DEPENDS else set[str]()
        shown = {name: value for name, value in form.items() if name not in hidden}
        if form["type"] == "object":
            shown = _object(notes, f"{full}.")
        elif form["type"] == "array" and form["items"] == {"type": "object"}:
            shown = {"type": "array", "items": _object(notes, f"{full}[].")}
        if meaning := meanings.get(full, meanings.get(f"*.{key}", "")):
            shown["description"] = meaning
        properties[key] = shown
        optional = NOT_ALWAYS | BY_SHAPE if f"{place}shape" in notes else NOT_ALWAYS
        if form["required"] and key not in optional:
            required.append(key)
    return {
        "type": "object",
        "properties": properties,
        "required": sorted(required),
        "additionalProperties": False,
    }
