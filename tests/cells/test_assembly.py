"""The page "Recipes", its part about assemblies followed literally, and the cell of it."""

import re
import tomllib
from pathlib import Path

import pytest
from page_commands import follow

from workbench.formats.cells.reading import read_cell

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "recipes.md").read_text(encoding="utf-8")
ASSEMBLY = ROOT / "robots" / "yumi" / "assembly.toml"


@pytest.mark.extensive
def test_the_page_leads_to_a_bolt_with_a_spacer_over_it(tmp_path, monkeypatch, capsys):
    _, block = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    assert block.count("\n") == 3
    follow(block, tmp_path, monkeypatch)
    said = capsys.readouterr().out
    assert "then plan-2.json" in said and said.count("the proof holds") == 3


def test_the_item_on_the_page_is_that_of_the_cell():
    _, _, block = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (said,) = tomllib.loads(block)["recipe"]["item"]
    shipped = tomllib.loads(ASSEMBLY.read_text(encoding="utf-8"))["recipe"][0]["item"][1]
    assert {"rpy_deg": [0, 0, 0], **said} == shipped


def test_the_cell_that_assembles_is_that_with_nests_but_for_its_parts():
    cell, nests = read_cell(ASSEMBLY), read_cell(ASSEMBLY.parent / "nests.toml")
    assert [fixture.name for fixture in cell.fixtures] == [one.name for one in nests.fixtures]
    for one, other in zip(cell.arms, nests.arms, strict=True):
        assert (one.home == other.home).all() and one.joints == other.joints
    full = read_cell(ASSEMBLY.parent / "full_bin.toml")
    assert cell.policy == full.policy
