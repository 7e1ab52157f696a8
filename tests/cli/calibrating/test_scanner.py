"""`workbench scanner fit`, as it is typed."""

import json
import shlex
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.cli.main import main
from workbench.formats.cells.edits import save_cell
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.model.calibration import CalibrationRecord
from workbench.model.scan import Scan
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


def test_parts_whose_floor_was_cut_away_are_found_after_the_fit(tmp_path, capsys):
    shutil.copytree(Path("robots/yumi"), tmp_path / "yumi")
    path = tmp_path / "yumi" / "cell.toml"
    cell = read_cell(path)
    pile = pile_of(cell, "keyed_cylinder", 3, seed=5)
    scan = synthesize(cell, pile, seed=5)
    T_bin_scanner = cell.bin.T_world_bin.actInv(scan.T_world_scanner)
    p_bin = scan.points @ T_bin_scanner.rotation.T + T_bin_scanner.translation
    is_part = (p_bin[:, 2] > 0.004) & (np.abs(p_bin[:, :2]) < cell.bin.size[:2] / 2 - 0.004).all(1)
    cloud = tmp_path / "scan.ply"
    write_cloud(cloud, Scan(scan.points[is_part], scan.T_world_scanner, "parts alone"))
    T = cell.scanner.T_world_scanner * pin.SE3(np.eye(3), np.array([0.1, 0.0, 0.2]))
    save_cell(path, replace(cell, scanner=replace(cell.scanner, T_world_scanner=T)))

    typed = ["scanner", "fit", str(cloud), "--cell", str(path), "--write"]
    assert main(typed) == 3
    out = capsys.readouterr().out
    assert "neither rim nor floor is visible" in out and "next: `workbench scanner fit" in out
    assert read_cell(path).bin.has_walls
    assert main([*typed, "--bin"]) == 3
    assert "next: `workbench localize" in capsys.readouterr().out
    assert not read_cell(path).bin.has_walls
    poses = tmp_path / "poses.json"
    assert main(["localize", str(path), "--scan", str(cloud), "--out", str(poses)]) == 0
    assert len(json.loads(poses.read_text())["detections"]) == 3


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
