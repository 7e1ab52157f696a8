"""The page of keys is made from the schemas of the readers, and each key on it has a meaning."""

import re
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from workbench.formats.cells.schema import MEANINGS, cell_schema, grasp_schema, part_schema

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "cell_file.md"


def test_the_page_is_what_the_readers_ask(monkeypatch):
    monkeypatch.setattr(sys, "path", [*sys.path, str(ROOT / "docs")])
    from make_cell_file import page

    assert PAGE.read_text(encoding="utf-8") == page(), "python docs/make_cell_file.py makes it anew"


def test_every_key_has_a_meaning():
    rows = re.findall(r"^- `(\w+)` \(.*?\): ?(.*)$", PAGE.read_text(encoding="utf-8"), re.M)
    assert len(rows) > 180
    assert [key for key, meaning in rows if not meaning] == []


def test_no_meaning_is_of_a_key_that_is_not_there():
    schemas = cell_schema(), part_schema(), grasp_schema()
    known = {place for schema in schemas for place in places(schema)}
    known |= {f"*.{place.rpartition('.')[2]}" for place in known}
    assert set(tomllib.loads(MEANINGS.read_text(encoding="utf-8"))) - known == set()


def places(schema: dict[str, Any], place: str = "") -> Iterator[str]:
    """The places of all keys, tables in arrays being called `[]`."""
    for key, form in schema.get("properties", {}).items():
        yield f"{place}{key}"
        inner, items = f"{place}{key}.", form.get("items", {})
        for one in (form, *form.get("anyOf", ())):
            yield from places(one, inner)
        for one in (items, *items.get("anyOf", ())):
            yield from places(one, f"{place}{key}[].")
