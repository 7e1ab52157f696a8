"""`workbench scanner fit`, as it is typed."""

import json
import shlex
import shutil
from dataclasses import replace
from pathlib import Path

from workbench.cli.main import main
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.model.calibration import CalibrationRecord
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize


def test_a_first_scan_is_written_into_the_cell(tmp_path, capsys, monkeypatch):
    shutil.copytree(Path("robots/yumi"), tmp_path / "yumi")
    path = tmp_path / "yumi" / "cell.toml"
    text = path.read_text()
    moved = text.replace("[scanner]\n", '[scanner]\nunit = "inch"\n', 1)
    path.write_text(moved)
    cell = read_cell("yumi")
    scan = synthesize(cell, pile_of(cell, "keyed_cylinder", 2, seed=1), seed=1)
    cloud = tmp_path / "scan.ply"
    write_cloud(cloud, scan, unit="mm", axes="z_back")

    typed = ["scanner", "fit", str(cloud), "--cell", str(path)]
    assert main([*typed, "--json"]) == 3
    said = json.loads(capsys.readouterr().out)
    assert (said["unit"], said["cloud_axes"], said["is_bin_found"]) == ("mm", "z_back", True)
    assert len(said["says"]) == 2 and not said["written"]
    assert path.read_text() == moved

    assert main([*typed, "--write"]) == 0
    out = capsys.readouterr().out
    assert "written into" in out
    written = read_cell(path)
    assert abs(read_scan(cloud, written.scanner).points - scan.points).max() < 1e-9
    assert main(typed) == 0

    following = shlex.split(out.partition("next: `workbench ")[2].partition("`")[0])
    monkeypatch.chdir(tmp_path)
    assert main(following) == 0  # as printed, nothing missing
    assert (tmp_path / "poses.json").is_file()


def test_sessions_are_looked_through_for_drift(tmp_path, capsys):
    shutil.copytree(Path("robots/yumi"), tmp_path / "yumi")
    path = tmp_path / "yumi" / "cell.toml"
    typed = ["scanner", "drift", str(path), "sessions/example"]
    assert main(typed) == 2
    assert "was never calibrated" in capsys.readouterr().err
    cell = read_cell(path)
    record = CalibrationRecord(1.0, "Ada", 8, 2e-4)
    save_cell(path, replace(cell, scanner=replace(cell.scanner, calibration=record)))
    assert main([*typed, "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert (said["sessions"], said["scans"], said["left_out"]) == (1, 1, [])
    assert [one["thing"] for one in said["things"]] == ["bin", "table"]
    assert main(typed) == 0
    said = capsys.readouterr().out
    assert "Where table has the scanner" in said
    assert "- there are scans of 1 days; 4 are needed to compare them" in said
    before = path.read_bytes()
    assert main([*typed, "--save"]) == 2
    assert main([*typed, "--save", "--by", "Ada"]) == 2
    assert "nothing recorded says that the scanner hangs elsewhere" in capsys.readouterr().err
    assert path.read_bytes() == before
