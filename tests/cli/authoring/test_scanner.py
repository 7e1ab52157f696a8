"""`workbench scanner fit`, as it is typed."""

import json
import shutil
from pathlib import Path

from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.perception.simulation.piles import pile_of
from workbench.perception.simulation.synthesize import synthesize


def test_a_first_scan_is_written_into_the_cell(tmp_path, capsys):
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
    assert "written into" in capsys.readouterr().out
    written = read_cell(path)
    assert abs(read_scan(cloud, written.scanner).points - scan.points).max() < 1e-9
    assert main(typed) == 0
