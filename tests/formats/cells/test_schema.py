"""The schema for editors says what the reader says."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from workbench.formats.cells.schema import cell_schema, schema_text
from workbench.formats.files.shipped import find

SHIPPED = Path(__file__).resolve().parents[3] / "robots" / "cell.schema.json"


CELLS = sorted(str(path.relative_to(SHIPPED.parent)) for path in SHIPPED.parent.glob("*/*.toml"))


def content(name: str) -> dict:
    return tomllib.loads((find("robots", name) / "cell.toml").read_text())


def test_the_file_is_what_the_reader_asks_now():
    assert SHIPPED.read_text() == schema_text(), (
        "run: workbench cell schema > robots/cell.schema.json"
    )


@pytest.mark.parametrize("name", CELLS)
def test_the_shipped_cells_fit(name):
    jsonschema.Draft202012Validator.check_schema(cell_schema())
    cell = tomllib.loads((SHIPPED.parent / name).read_text())
    jsonschema.validate(cell, json.loads(SHIPPED.read_text()))


def test_regions_and_solids_of_every_shape_fit():
    cell = content("yumi")
    cell["bin"]["region"] = [{"name": "left", "size_mm": [100, 100, 50]}]
    cell["fixture"][0]["solid"] = [
        {"name": "post", "shape": "cylinder", "radius_mm": 10, "length_mm": 50},
        {"name": "frame", "shape": "mesh", "file": "frame.stl", "unit": "m", "convex": False},
    ]
    jsonschema.validate(cell, json.loads(SHIPPED.read_text()))


@pytest.mark.parametrize(
    ("key", "default"),
    [("margin_mm", 5.0), ("approvers", 1), ("planner", "rrtconnect"), ("least_air_mm", None)],
)
def test_a_default_is_what_the_reader_takes(key, default):
    assert cell_schema()["properties"]["policy"]["properties"][key].get("default") == default


@pytest.mark.parametrize(
    ("table", "key", "value"),
    [
        ("bin", "size_mm", [1, 2]),
        ("bin", "colour", "red"),
        ("policy", "planner", "magic"),
        ("policy", "speed", 3),
        ("scanner", "near_mm", "near"),
        ("controller", "port", 1.5),
    ],
)
def test_what_the_reader_refuses_does_not_fit(table, key, value):
    wrong = content("yumi")
    wrong[table][key] = value
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(wrong, cell_schema())


def test_reading_without_notes_takes_none():
    from workbench.formats.files.toml_keys import NOTES

    cell_schema()
    assert NOTES.get() is None
