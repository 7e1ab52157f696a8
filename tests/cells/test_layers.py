"""The section on pallets in layers of the page "Parts where you want them", and its cell."""

import re
import tomllib
from pathlib import Path

from page_commands import follow

from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell

ROOT = Path(__file__).resolve().parents[2]
PAGE = (ROOT / "docs" / "part_places.md").read_text(encoding="utf-8")
PALLET = ROOT / "robots" / "tx2_90" / "pallet.toml"


def test_the_page_leads_to_a_part_on_the_pallet(tmp_path, monkeypatch, capsys):
    _, block = re.findall(r"```sh\n(.*?)```", PAGE, re.DOTALL)
    follow(block, tmp_path, monkeypatch)
    said = capsys.readouterr().out
    assert "right pallet 1: 8 places in layers" in said
    assert "nothing speaks against this cell" in said and said.count("proof holds") == 2


def test_a_pitch_that_is_too_small_is_told(tmp_path, monkeypatch, capsys):
    text = PALLET.read_text(encoding="utf-8").replace("100, 14]", "100, 12]")
    for end in ("urdf", "srdf"):
        text = text.replace(f'"tx2_90.{end}"', f'"{PALLET.parent}/tx2_90.{end}"')
    text = text.replace('"../../parts', f'"{ROOT}/parts')
    (tmp_path / "cell.toml").write_text(text, encoding="utf-8")
    (tmp_path / "meshes").symlink_to(PALLET.parent / "meshes")
    assert main(["cell", "check", str(tmp_path / "cell.toml")]) != 0
    said = " ".join(capsys.readouterr().out.split())
    assert (
        "problem: right arm: pallet 1 of parts puck: in layer 2 a part is released 9.0 mm" in said
    )
    assert "layers are 12.0 mm apart, and the part is 14.0" in said


def test_the_pallet_on_the_page_is_that_of_the_cell():
    _, block, _ = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (said,) = tomllib.loads(block)["arm"]["place"]
    shipped = tomllib.loads(PALLET.read_text(encoding="utf-8"))["arm"][0]
    assert shipped["place"] == [said] and shipped["keeps_parts"]


def test_the_cell_is_that_of_full_bins_but_for_its_pallet():
    full, cell = read_cell(PALLET.parent / "full_bin.toml"), read_cell(PALLET)
    assert full.policy == cell.policy and full.parts[0].digest == cell.parts[0].digest
    assert (full.arms[0].home == cell.arms[0].home).all()
    assert len(cell.arms[0].part_places) == 8 and not cell.arms[0].Ts_world_place
