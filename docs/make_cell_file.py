"""The page of all keys of cell, part and grasp files, `cell_file.md`, made from their schemas.

`python docs/make_cell_file.py` writes it anew; a test says when that is due.
"""

import json
import re
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from workbench.formats.cells.schema import cell_schema, grasp_schema, part_schema

PAGE = Path(__file__).with_name("cell_file.md")

HEAD = """# Keys of cell, part and grasp files

Made from the readers' schemas; `workbench cell schema` prints that of cell files for editors. In
brackets stand the values of a key and, behind a semicolon, its default; *needed* keys have none.

A table with a *pose* has `position_mm` (x, y, z) and `rpy_deg` (roll, pitch, yaw about the fixed
axes x, y, z); both are zero by default.

Examples: `robots/yumi/cell.toml`, `parts/keyed_cylinder`.
"""

SOLIDS = """## Solids

Each table of a solid (`[[tool.body]]`, `[[tool.finger]]`, `[[fixture.solid]]`, `[[piece]]`) has
these keys.
"""

KINDS = "A `[[tool]]` with a `kind` has `name`, the keys of its load, and these options."

POSE = {
    "position_mm": "shift along x, y, z",
    "rpy_deg": "roll, pitch, yaw about the fixed axes x, y, z",
}
"""What the keys of a usual pose mean; the head of the page explains them once."""

UNITS = {
    "acceleration_deg": "deg/s2",
    "jerk_deg": "deg/s3",
    "speed_deg": "deg/s",
    "speed_mm": "mm/s",
    "tcp_speed_mm": "mm/s",
    "point_speed_mm": "mm/s",
    "held_speed_mm": "mm/s",
    "approval_minutes": "min",
    "calibration_days": "days",
    "packet_bytes": "bytes",
    "seconds": "s",
    "inertia_kgm2": "kg m2",
}
ENDINGS = {"mm": "mm", "deg": "deg", "g": "g", "n": "N", "s": "s", "ms": "ms", "us": "us"}
ENDINGS |= {"px": "pixels"}

NUMBERS = {"number": "number", "integer": "whole number", "boolean": "true or false"}

PLUGINS = (("scanner", "source"), ("controller", "protocol"), ("localizer", "name"))

Schema = Mapping[str, Any]


def page() -> str:
    """The whole page."""
    cell, part = cell_schema(), part_schema()
    solid = part["properties"].pop("piece")
    tool, *kinds = cell["properties"]["tool"]["items"]["anyOf"]
    cell["properties"]["tool"]["items"] = tool
    lines = [HEAD, "## cell.toml", *_table(cell)]
    lines += ["", KINDS]
    for kind in kinds:
        keys = kind["properties"]
        name = keys["kind"]["const"]
        lines += ["", f'### `[tool.options]` with `kind = "{name}"`', *_rows(keys["options"])]
    for table, key in PLUGINS:
        earlier: dict[str, Schema] = {}
        for case in cell["properties"][table]["allOf"]:
            name = case["if"]["properties"][key]["const"]
            options = case["then"]["properties"]["options"]
            if options["properties"]:
                lines += ["", f'### `[{table}.options]` with `{key} = "{name}"`']
                lines += _further_rows(options, earlier)
                earlier[name] = options["properties"]
    part["properties"]["piece"] = {"type": "array", "description": solid["description"]}
    lines += ["", "## part.toml", *_table(part), "", SOLIDS.rstrip(), *_rows(solid["items"])]
    return "\n".join([*lines, "", "## grasps.toml", *_table(grasp_schema())]) + "\n"


def _further_rows(options: Schema, earlier: Mapping[str, Schema]) -> Iterator[str]:
    """The keys of a driver, without those of an earlier one whose keys it has all."""
    keys = options["properties"]
    for name, known in earlier.items():
        if known.items() <= keys.items():
            keys = {key: form for key, form in keys.items() if key not in known}
            yield from ("", f"The keys of `{name}`, and:")
            break
    yield from _rows({**options, "properties": keys})


def _table(
    schema: Schema, place: str = "", is_array: bool = False, is_needed: bool = False
) -> Iterator[str]:
    """The rows of a table and, below their headings, of those in it; solids stand elsewhere."""
    inner = schema.get("items", schema)
    if place:
        meaning = schema["description"]
        name = f"[[{place}]]" if is_array else f"[{place}]"
        notes = f"{' Needed.' if is_needed else ''}{' Has a pose.' if _has_pose(inner) else ''}"
        yield from ("", f"### `{name}`", "", f"{meaning[0].upper()}{meaning[1:]}.{notes}")
    yield from _rows(inner)
    for key, form in inner["properties"].items():
        if _has_section(form):
            full = f"{place}.{key}".lstrip(".")
            yield from _table(form, full, form["type"] == "array", key in inner["required"])


def _has_section(form: Schema) -> bool:
    """Whether a key is a table with a heading of its own; solids and poses have none."""
    keys = form.get("items", form).get("properties", {})
    return bool(keys) and "shape" not in keys and keys.keys() != POSE.keys()


def _has_pose(schema: Schema) -> bool:
    forms = schema["properties"]
    return all(forms.get(key, {}).get("description") == text for key, text in POSE.items())


def _rows(schema: Schema) -> Iterator[str]:
    """A line for each key."""
    hidden = POSE.keys() if _has_pose(schema) else ()
    forms = {
        key: form
        for key, form in schema["properties"].items()
        if key not in hidden and not _has_section(form)
    }
    yield from [""] if forms else ()
    for key, form in sorted(forms.items(), key=lambda item: item[0] != "name"):
        if form.get("type") == "object" and key == "options":
            continue
        usual = "*needed*" if key in schema["required"] else _usual(form)
        value, unit = _type(form), _unit(key)
        value += f"{',' if value[-1].isalpha() else ''} {unit}" if unit else ""
        values = "; ".join(filter(None, (value, usual)))
        yield f"- `{key}` ({values}): {form.get('description', '')}"


def _usual(form: Schema) -> str:
    usual = form.get("default", [])
    text = json.dumps(usual)
    if not isinstance(usual, str):
        text = re.sub(r"(\d)\.0\b", r"\1", text)
    return "" if usual in ([], "") else f"`{text}`"


def _type(form: Schema) -> str:
    if "enum" in form:
        return ", ".join(f"`{choice}`" for choice in form["enum"])
    match form.get("type"):
        case "string":
            return "text"
        case "object":
            return "pose" if form.get("properties", {}).keys() == POSE.keys() else "table"
        case "array" if "items" not in form or form["items"].get("type") == "object":
            return "tables"
        case "array":
            low, high = form.get("minItems"), form.get("maxItems")
            count = "" if low is None else f"{low} " if low == high else f"{low} or {high} "
            return f"{count}{'texts' if form['items']['type'] == 'string' else 'numbers'}"
        case kind:
            return _range(form) or NUMBERS[str(kind)]


def _range(form: Schema) -> str:
    low, high = form.get("minimum"), form.get("maximum")
    whole = "whole, " if form["type"] == "integer" else ""
    return "" if low is None or high is None else f"{whole}{low:.10g} to {high:.10g}"


def _unit(key: str) -> str:
    return UNITS.get(key, ENDINGS.get(key.rpartition("_")[2], "") if "_" in key else "")


if __name__ == "__main__":
    PAGE.write_text(page(), encoding="utf-8")
