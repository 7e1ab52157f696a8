"""What `workbench localize` says beside the parts found."""

import pytest

from workbench.cli.main import main
from workbench.cli.picking import look
from workbench.model.scan import LocalizationResult, ScaleCheck


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
    wanted = "the CAD file of bolt seems 3.1 % too large for what was scanned"
    assert f"size: {wanted} (± 0.2 %, by 4 parts)" in said
    assert "bracket" not in said
