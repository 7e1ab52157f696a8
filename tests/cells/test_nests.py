"""The page "Parts where you want them", followed literally, and the cell that it is about."""

import re
import tomllib
from dataclasses import replace
from pathlib import Path

import pytest
from page_commands import follow
from shipped import without_search

from workbench.formats.cells.reading import read_cell

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "part_places.md").read_text(encoding="utf-8")
NESTS = ROOT / "robots" / "yumi" / "nests.toml"


@pytest.mark.extensive
def test_the_page_leads_to_parts_that_stand_in_nests(tmp_path, monkeypatch, capsys):
    block, _ = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    assert block.count("\n") == 4
    follow(block, tmp_path, monkeypatch)
    said = capsys.readouterr().out
    assert "nothing speaks against this cell" in said
    assert said.count("proof holds") == 2 and "right part-1" in said and "left part-2" in said


def test_the_place_on_the_page_is_that_of_the_cell():
    block, _, _ = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    said = tomllib.loads(block)["arm"]["place"][0]
    shipped = tomllib.loads(NESTS.read_text(encoding="utf-8"))["arm"][0]["place"][0]
    assert said == {"free_rotation_deg": 0, "approach": [0, 0, -1], **shipped}


def test_the_nests_are_those_of_the_shipped_cell_but_for_what_parts_are_put_on():
    cell, nests = read_cell("yumi"), read_cell(NESTS)
    assert nests.arms[0].part_places and not nests.arms[0].Ts_world_place
    assert nests.policy == cell.policy and nests.parts[0].digest == cell.parts[0].digest
    for one, other in zip(cell.arms, nests.arms, strict=True):
        assert (one.home == other.home).all() and one.joints == other.joints


def test_the_station_on_the_page_is_that_of_the_cell():
    _, _, block = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (said,) = tomllib.loads(block)["station"]
    shipped = tomllib.loads((NESTS.parent / "regrasp.toml").read_text(encoding="utf-8"))
    assert said == {"position_mm": [0, 0, 0], **shipped["station"][0]}


def test_the_cell_with_a_station_is_that_with_nests_but_for_where_parts_stand_and_its_lifts():
    nests, cell = read_cell(NESTS), read_cell(NESTS.parent / "regrasp.toml")
    # Its grasps are the same, and plans search no others.
    assert cell.parts[0].digest == without_search(nests).parts[0].digest
    assert len(cell.stations) == 1
    gap, lifts = cell.policy.pair_gap, cell.policy.lifts
    assert gap > 0 and lifts == read_cell(NESTS.parent / "full_bin.toml").policy.lifts
    assert replace(nests.policy, pair_gap=gap, lifts=lifts) == cell.policy
    for one, other in zip(cell.arms, nests.arms, strict=True):
        assert (one.home == other.home).all() and one.joints == other.joints
