"""`workbench scanner trueness` and `touch`, as they are typed."""

import json

import pytest

from workbench.cli.main import main
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud


def test_trueness_by_command(tmp_path, capsys):
    folder = tmp_path / "places"
    typed = ["scanner", "trueness", "yumi", "--scans", str(folder)]
    assert main([*typed, "--simulate"]) == 0
    assert "lengths are true" in capsys.readouterr().out
    assert main([*typed, "--limit", "0.01", "--json"]) == 3
    said = json.loads(capsys.readouterr().out)
    assert said["light"] == "bad" and len(said["sphere_spacing_errors_mm"]) == 9
    one = ["scanner", "trueness", "yumi", "--scans", str(folder / "place_1.ply")]
    for more, says in (
        (["--simulate"], "name one that is not there"),
        (["--lengths", "0", "0", "0"], "longer than their diameter"),
        (["--lengths", "80", "100"], "one length of a ball bar or three"),
        (["--lengths", "nan"], "more than the balls' diameter"),
        (["--lengths", "150"], "2 at the stated distances are needed"),
        (["--ball", "3"], "--ball"),
        (["--limit", "nan"], "--limit"),
    ):
        assert main([*one, *more]) == 2
        assert says in capsys.readouterr().err
    (folder / "place_4.ply").write_bytes(b"ply\nnot a cloud")
    assert main(typed) == 0
    assert "left out" in capsys.readouterr().out
    assert main(["scanner", "trueness", "yumi", "--scans", str(tmp_path)]) == 2
    assert "1 to 30 clouds are expected, not 0" in capsys.readouterr().err


def test_touch_test_by_command(tmp_path, capsys):
    file = tmp_path / "touch" / "touches.toml"
    typed = ["scanner", "touch", "yumi", "--touches", str(file)]
    assert main([*typed, "--simulate"]) == 2
    assert "no calibration predicts an error" in capsys.readouterr().err
    assert main([*typed, "--limit", "1", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["balls"] == [1, 2, 3] and said["found_mm"]["largest"] < 0.6
    assert main([*typed, "--simulate"]) == 2
    assert "is there already" in capsys.readouterr().err

    # The scanner hangs 3 mm from where the cell has it.
    cell, cloud = read_cell("yumi"), file.parent / "scan.ply"
    scan = read_scan(cloud, cell.scanner)
    write_cloud(cloud, type(scan)(scan.points + (0.003, 0, 0), scan.T_world_scanner, "test"))
    assert main([*typed, "--limit", "1"]) == 3
    assert "are a common shift: calibrate again" in capsys.readouterr().out

    text = file.read_text()
    last = text.rindex("[[touch]]")
    for broken, says in (
        (text[:last], "needs 3 touches; there are 2"),
        (text.replace("tip_mm = 0", "tip_mm = 30"), "touch 1: the inner diameter"),
        (text.replace('arm = "right"', 'arm = "left"'), "touch 1: "),
        (text.replace("joints_deg = [", "joints_deg = [nan, ", 1), "joints_deg"),
        (text.replace("sides_mm = [80", "sides_mm = [0"), "sides_mm"),
        (text.replace("scan.ply", "other.ply"), "there is no file 'other.ply'"),
    ):
        file.write_text(broken)
        assert main([*typed, "--limit", "1"]) == 2
        assert says in capsys.readouterr().err


@pytest.mark.parametrize("what", ["trueness", "touch"])
def test_what_is_not_there_is_said(tmp_path, capsys, what):
    option = "--scans" if what == "trueness" else "--touches"
    assert main(["scanner", what, "yumi", option, str(tmp_path / "nothing.toml")]) == 2
    assert "nothing.toml" in capsys.readouterr().err
