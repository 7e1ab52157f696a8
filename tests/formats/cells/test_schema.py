"""The schema for editors says what the reader says."""

import json
import tomllib
from pathlib import Path

import jsonschema
import pytest

from workbench.formats.cells.schema import cell_schema, schema_text
from workbench.formats.files.shipped import find

SHIPPED = Path(__file__).resolve().parents[3] / "robots" / "cell.schema.json"


def content(name: str) -> dict:
    return tomllib.loads((find("robots", name) / "cell.toml").read_text())


def test_the_file_is_what_the_reader_asks_now():
    assert SHIPPED.read_text() == schema_text(), (
        "run: workbench cell schema > robots/cell.schema.json"
    )


@pytest.mark.parametrize("name", ["yumi", "tx2_90"])
def test_the_shipped_cells_fit(name):
    jsonschema.Draft202012Validator.check_schema(cell_schema())
    jsonschema.validate(content(name), json.loads(SHIPPED.read_text()))


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
