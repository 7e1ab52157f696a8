"""What `workbench localize` says beside the parts found."""

import json

import numpy as np
import pytest
from PIL import Image

from workbench.cli.main import main
from workbench.cli.measuring import scans as measuring
from workbench.cli.picking import look
from workbench.formats.cells.reading import read_cell
from workbench.model.scan import Detection, LocalizationResult, OffsetCheck, ScaleCheck
from workbench.studies import scans


@pytest.fixture(scope="module")
def scan(tmp_path_factory):
    path = tmp_path_factory.mktemp("look") / "scan.ply"
    assert main(["scan", "yumi", "--parts", "1", "--out", str(path)]) == 0
    return path


def test_a_cad_file_of_another_size_is_said_to_be_one(monkeypatch, scan, tmp_path, capsys):
    sizes = (ScaleCheck("bolt", 0.97, 0.002, 4), ScaleCheck("bracket", 1.001, 0.002, 5))
    monkeypatch.setattr(look, "find_parts", lambda *_, **__: LocalizationResult((), scales=sizes))
    monkeypatch.setattr(look, "make_ready", lambda *_: True)
    out = tmp_path / "poses.json"
    assert main(["localize", "yumi", "--scan", str(scan), "--out", str(out)]) == 0
    said = capsys.readouterr().out
    wanted = "the CAD file of bolt seems 3.1% too large for the scan"
    assert f"size: {wanted} (± 0.2 %, by 4 parts)" in said
    assert "--scale bolt=0.97" in said
    assert "bracket" not in said


def test_a_surface_that_lies_off_is_said_to(monkeypatch, scan, tmp_path, capsys):
    offsets = (OffsetCheck("bolt", -0.002, 0.0001, 4), OffsetCheck("bracket", 0.0001, 0.0001, 5))
    found = LocalizationResult((), offsets=offsets)
    monkeypatch.setattr(look, "find_parts", lambda *_, **__: found)
    monkeypatch.setattr(look, "make_ready", lambda *_: True)
    words = ["--scan", str(scan), "--out", str(tmp_path / "poses.json")]
    assert main(["localize", "yumi", *words]) == 0
    said = capsys.readouterr().out
    wanted = "the surface of bolt seems to lie 2.0 mm inside of its CAD file"
    assert f"surface: {wanted} (± 0.1 mm, by 4 parts)" in said and "--learn" in said
    assert "bracket" not in said


@pytest.mark.extensive
def test_what_is_found_is_drawn_over_the_scan(monkeypatch, scan, tmp_path):
    there = LocalizationResult((Detection("keyed_cylinder", read_cell("yumi").bin.T_world_bin),))
    monkeypatch.setattr(look, "find_parts", lambda *_, **__: there)
    monkeypatch.setattr(look, "make_ready", lambda *_: True)
    pictures = []
    for findings in (there, LocalizationResult(())):
        monkeypatch.setattr(look, "find_parts", lambda *_, found=findings, **__: found)
        path = tmp_path / "overlay.png"
        words = ["--scan", str(scan), "--out", str(tmp_path / "o.json"), "--overlay", str(path)]
        assert main(["localize", "yumi", *words]) == 0
        with Image.open(path) as image:
            pictures.append(np.asarray(image))
    assert pictures[0].shape == pictures[1].shape and pictures[0].shape[1] > 600
    assert (pictures[0] != pictures[1]).any()


def test_a_part_is_searched_in_the_size_that_is_typed(monkeypatch, scan, tmp_path, capsys):
    searched = []

    def find(_, cell, **__):
        searched.append(cell)
        return LocalizationResult(())

    monkeypatch.setattr(look, "find_parts", find)
    monkeypatch.setattr(look, "make_ready", lambda *_: True)
    words = ["localize", "yumi", "--scan", str(scan), "--out", str(tmp_path / "o.json")]
    assert main(words) == 0 and main([*words, "--scale", "keyed_cylinder=0.92"]) == 0
    whole, less = (np.ptp(one.parts[0].mesh.points, axis=0) for one in searched)
    assert less == pytest.approx(0.92 * whole)
    for typed, said in (("rod=1", "no part of the cell"), ("keyed_cylinder", "PART=SIZE"),
                        ("keyed_cylinder=9", "0.5 to 2")):  # fmt: skip
        capsys.readouterr()
        assert main([*words, "--scale", typed]) == 2
        assert said in capsys.readouterr().err


def test_a_folder_of_scans_is_searched_scan_by_scan(monkeypatch, scan, tmp_path, capsys):
    there = LocalizationResult(
        (Detection("keyed_cylinder", read_cell("yumi").bin.T_world_bin, probability=0.9),)
    )
    monkeypatch.setattr(scans, "find_parts", lambda *_, **__: there)
    monkeypatch.setattr(measuring, "make_ready", lambda *_: True)
    words = ["study", "scans", "yumi", str(scan.parent), "--overlays", str(tmp_path / "o")]
    assert main([*words, "--json"]) == 0
    (told,) = json.loads(capsys.readouterr().out)["scans"]
    assert (told["scan"], told["found"], told["sure"]) == (scan.stem, 1, 1)
    assert (tmp_path / "o" / f"{scan.stem}.png").is_file()
    assert main(["study", "scans", "yumi", str(tmp_path)]) == 2
