"""`workbench scanner trueness` and `touch`, as they are typed."""

import json

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
    file, cloud = tmp_path / "touch" / "joints.csv", tmp_path / "touch" / "scan.ply"
    typed = ["scanner", "touch", "yumi", "--scan", str(cloud), "--joints", str(file)]
    assert main([*typed, "--simulate"]) == 2
    assert "no calibration predicts an error" in capsys.readouterr().err
    assert main([*typed, "--limit", "1", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["balls"] == [1, 2, 3] and said["found_mm"]["largest"] < 0.6
    assert main([*typed, "--simulate"]) == 2
    assert "is there already" in capsys.readouterr().err

    # The scanner hangs 3 mm from where the cell has it.
    scan = read_scan(cloud, read_cell("yumi").scanner)
    write_cloud(cloud, type(scan)(scan.points + (0.003, 0, 0), scan.T_world_scanner, "test"))
    assert main([*typed, "--limit", "1"]) == 3
    assert "are a common shift: calibrate again" in capsys.readouterr().out

    rows = file.read_text().splitlines()
    for broken, more, says in (
        (rows[:2], (), "needs 3 touches; there are 2"),
        ([rows[0], rows[0], rows[0]], (), "lie on one line"),
        (["nan" + rows[0][rows[0].index(",") :]], (), "line 1: 7 joint values within the limits"),
        (["# a remark", "900" + rows[0][rows[0].index(",") :]], (), "line 2: 7 joint values"),
        (["1, 2, 3"], (), "line 1: 7 joint values"),
        (["one, two"], (), "line 1: 7 joint values"),
        ([""], (), "there are 0"),
        (rows, ("--tip", "30"), "touch 1: the inner diameter"),
        (rows, ("--arm", "left"), "touch 1: the tip is"),
        (rows, ("--arm", "third"), "third"),
        (rows, ("--lengths", "80"), "the tip is"),
        (rows, ("--lengths", "0"), "more than the balls' diameter"),
        (rows * 11, (), "touches in --joints"),
    ):
        file.write_text("\n".join(broken))
        assert main([*typed, "--limit", "1", *more]) == 2
        assert says in capsys.readouterr().err, broken


def test_files_that_are_not_there_are_named(tmp_path, capsys):
    missing = str(tmp_path / "nothing.ply")
    assert main(["scanner", "trueness", "yumi", "--scans", missing]) == 2
    assert "nothing.ply" in capsys.readouterr().err
    assert main(["scanner", "touch", "yumi", "--scan", missing, "--joints", missing]) == 2
    assert "nothing.ply" in capsys.readouterr().err
