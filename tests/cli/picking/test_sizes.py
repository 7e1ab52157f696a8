"""The size of a part over its CAD file: learnt from a scan, kept with the part."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from workbench.cli.main import main
from workbench.cli.picking import look
from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.formats.parts.saves import save_part
from workbench.formats.parts.scales import write_shape
from workbench.model.errors import FileError
from workbench.model.scan import LocalizationResult, OffsetCheck, ScaleCheck
from workbench.perception.parts.sizing import learn_sizes

SHIPPED = Path(__file__).parents[3] / "parts" / "bracket"


@pytest.fixture
def bracket(tmp_path):
    shutil.copytree(SHIPPED, tmp_path / "bracket")
    return tmp_path / "bracket"


def length(part):
    return np.ptp(part.mesh.points, axis=0)


def of_size(true, shown_share):
    """A search of parts that are `true` times as large, of which it sees a share of the rest."""
    first = None

    def search(cell):
        nonlocal first
        first = first or length(cell.parts[0])[0]
        left = true / float(length(cell.parts[0])[0] / first)
        ratio = 1.0 + shown_share * (left - 1.0)
        return LocalizationResult((), scales=(ScaleCheck(cell.parts[0].name, ratio, 0.0005, 4),))

    return search


def test_a_size_is_searched_for_until_the_scan_shows_no_other():
    findings, cell, sizes = learn_sizes(read_cell("yumi"), of_size(0.92, 0.8), ["keyed_cylinder"])
    assert sizes["keyed_cylinder"] == pytest.approx(0.92, abs=0.005)
    assert length(cell.parts[0]) == pytest.approx(
        sizes["keyed_cylinder"] * length(read_cell("yumi").parts[0])
    )
    assert not findings.scales[0].is_off


def test_a_size_that_is_right_stays():
    yumi = read_cell("yumi")
    assert learn_sizes(yumi, of_size(1.0, 1.0), ["keyed_cylinder"])[2] == {}
    assert learn_sizes(yumi, of_size(0.92, 1.0), ["another"])[2] == {}


def test_a_part_is_as_large_as_its_file_times_the_scale_and_so_are_its_bodies(bracket):
    before = read_part(bracket)
    assert write_shape(bracket, 0.9, 0.0) == (0.9, 0.0)
    after = read_part(bracket)
    assert length(after) == pytest.approx(0.9 * length(before))
    reaches = [max(piece.reach for piece in part.pieces) for part in (before, after)]
    assert reaches[1] == pytest.approx(0.9 * reaches[0])
    text = (bracket / "part.toml").read_text()
    (bracket / "part.toml").write_text(text[: text.index("[[piece]]")])
    made = np.vstack([p.T_owner_shape.act(corner) for p in read_part(bracket).pieces
                      for corner in p.shape.points])  # fmt: skip
    assert np.ptp(made, axis=0) == pytest.approx(0.9 * length(before), abs=0.002)
    assert after.digest != before.digest


def test_a_shape_is_read_as_it_is_written_and_comments_stay(bracket):
    file = bracket / "part.toml"
    file.write_text("# ours\n" + file.read_text())
    before = file.read_text()
    as_meant = read_part(bracket, (0.8123, 0.0004))
    assert write_shape(bracket, 0.81234, 0.000401) == (0.8123, 0.0004)
    assert file.read_text().startswith("# ours\n") and "scale = 0.8123" in file.read_text()
    after = read_part(bracket)
    assert (after.scale, after.offset, after.digest) == (0.8123, 0.0004, as_meant.digest)
    assert write_shape(bracket, 1.0, 0.0) == (1.0, 0.0)
    assert file.read_text() == before


def test_a_part_that_is_saved_has_its_size_in_its_file(bracket):
    before, resized = read_part(bracket), read_part(bracket, (0.9, -0.0005))
    save_part(bracket, before, resized, actor="ada", at=0.0, remark="as seen")
    assert read_part(bracket).digest == resized.digest
    save_part(bracket, resized, before, actor="ada", at=1.0, remark="not so")
    assert read_part(bracket).digest == before.digest


def test_a_scale_that_can_only_be_a_wrong_unit_is_refused(bracket):
    with pytest.raises(FileError, match="unit may be wrong"):
        write_shape(bracket, 0.04, 0.0)
    assert "scale" not in (bracket / "part.toml").read_text()


def test_a_surface_lies_as_far_out_as_the_file_says_and_its_bodies_hold_it(bracket):
    before = read_part(bracket)
    assert write_shape(bracket, 1.0, 0.0014) == (1.0, pytest.approx(0.0014))
    after = read_part(bracket)
    assert length(after) == pytest.approx(length(before) + 0.0028, abs=1e-6)
    assert after.pieces[0].shape.size == pytest.approx(before.pieces[0].shape.size + 0.0028)
    assert after.digest != before.digest and after.tolerance is None


def test_bodies_of_a_thinner_part_stay_as_they_are(bracket):
    before = read_part(bracket)
    write_shape(bracket, 1.0, -0.001)
    after = read_part(bracket)
    assert (length(after) < length(before) - 0.001).all()
    assert after.pieces[0].shape.size == pytest.approx(before.pieces[0].shape.size)


@pytest.mark.parametrize("name", ["bracket", "keyed_cylinder", "bolt"])
def test_bodies_are_larger_by_the_tolerance_that_a_part_states(tmp_path, name):
    folder = tmp_path / name
    shutil.copytree(SHIPPED.parent / name, folder)
    before = read_part(folder)
    file = folder / "part.toml"
    file.write_text(file.read_text().replace("[mesh]\n", "[mesh]\ntolerance_mm = 1.5\n"))
    after = read_part(folder)
    assert after.tolerance == pytest.approx(0.0015)
    assert after.mesh.points == pytest.approx(before.mesh.points)
    for one, other in zip(before.pieces, after.pieces, strict=True):
        assert other.reach >= one.reach + 0.0014


def test_an_offset_that_can_only_be_another_part_is_refused(bracket):
    with pytest.raises(FileError, match="another part"):
        write_shape(bracket, 1.0, 0.012)
    assert "offset" not in (bracket / "part.toml").read_text()


def test_what_is_learnt_is_written_with_the_part(monkeypatch, bracket, tmp_path, capsys):
    cell = tmp_path / "cell"
    shutil.copytree(SHIPPED.parents[1] / "robots" / "yumi", cell)
    file = cell / "cell.toml"
    file.write_text(file.read_text().replace('["keyed_cylinder"]', '["../bracket"]'))
    cloud = str(tmp_path / "scan.ply")
    assert main(["scan", str(file), "--parts", "1", "--out", cloud]) == 0
    monkeypatch.setattr(look, "make_ready", lambda *_: True)
    search = of_size(0.95, 1.0)
    monkeypatch.setattr(look, "find_parts", lambda _, cell, **__: search(cell))
    words = ["--scan", cloud, "--out", str(tmp_path / "o.json"), "--learn"]
    assert main(["localize", str(file), *words]) == 0
    assert "scale = 0.95 is written" in capsys.readouterr().out
    assert length(read_part(bracket)) == pytest.approx(0.95 * length(read_part(SHIPPED)))
    off = LocalizationResult((), offsets=(OffsetCheck("bracket", -0.001, 0.0001, 4),))
    monkeypatch.setattr(look, "find_parts", lambda *_, **__: off)
    assert main(["localize", str(file), *words]) == 0
    said = " ".join(capsys.readouterr().out.split())
    assert "offset_mm = -1 is written" in said and "does not show" not in said
    monkeypatch.setattr(look, "find_parts", lambda *_, **__: LocalizationResult(()))
    assert main(["localize", str(file), *words]) == 0
    assert "this scan does not show its size" in capsys.readouterr().out
