"""The page "Recipes", its part about kits followed literally, and the cell that it is about."""

import re
import tomllib
from pathlib import Path

import pytest
from page_commands import follow

from workbench.formats.cells.reading import read_cell

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "recipes.md").read_text(encoding="utf-8")
KITS = ROOT / "robots" / "yumi" / "kits.toml"


@pytest.mark.extensive
def test_the_page_leads_to_a_kit(tmp_path, monkeypatch, capsys):
    block, _ = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    assert block.count("\n") == 4
    follow(block, tmp_path, monkeypatch)
    said = capsys.readouterr().out
    assert "proof holds" in said and re.search(r"[12] of 2 kits complete", said)


def test_the_recipe_on_the_page_is_that_of_the_cell():
    _, block, _ = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    said = tomllib.loads(block)["recipe"][0]
    assert said == tomllib.loads(KITS.read_text(encoding="utf-8"))["recipe"][0]


def test_both_arms_reach_one_tray_and_the_grasps_are_those_of_full_bins():
    cell, full = read_cell(KITS), read_cell(KITS.parent / "full_bin.toml")
    assert cell.policy == full.policy
    assert cell.part("keyed_cylinder").digest == full.part("keyed_cylinder").digest
    assert [fixture.name for fixture in cell.fixtures] == ["table", "kit_tray"]
    for arm in cell.arms:
        assert {round(float(T.translation[0]), 3) for T in arm.Ts_world_place} == {0.24}
