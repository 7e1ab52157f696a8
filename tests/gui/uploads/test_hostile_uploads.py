"""Files that people send: whatever they hold, the page's process reads none of it."""

import json
import threading
import zipfile
from types import SimpleNamespace

import numpy as np
import pytest
import viser
from waiting import wait_until

from workbench.app.core.state import Phase
from workbench.app.records.keeping import write_backup
from workbench.formats.clouds import scans
from workbench.formats.clouds.scans import write_cloud
from workbench.formats.meshes import cad_look, reading, repair
from workbench.formats.plans import pose_files
from workbench.formats.plans.pose_files import write_poses
from workbench.gui.parts.panel import PartsPanel
from workbench.gui.statistics.restoring import RestoreControls
from workbench.gui.uploads import cad_pick
from workbench.gui.uploads.cad_pick import CadPick
from workbench.model.errors import JobCancelled
from workbench.studies.stalls.large_files import cad_file

READERS = (
    *((cad_look, name) for name in ("read_cad", "joined_corners", "examine_surface")),
    *((repair, name) for name in ("joined_corners", "examine_surface")),
    (reading, "read_mesh"),
    *((scans, name) for name in ("parse_scan", "parse_cloud", "read_pcd")),
    *((pose_files, name) for name in ("parse_poses", "parse_json")),
    (zipfile, "ZipFile"),
    (np, "unique"),
)
"""What reads files, or goes through what they hold."""

ODD_NAMES = ["a\0.stl", "../a.stl", "/tmp/a.stl", "C:\\a.stl", ".."]


@pytest.fixture
def nothing_is_read_here(monkeypatch):
    def read(*_, **__):
        raise AssertionError("this process has read a file that somebody sent")

    def forbid():
        for module, name in READERS:
            monkeypatch.setattr(module, name, read)

    yield forbid
    monkeypatch.undo()


@pytest.fixture
def pick(visitor):
    return CadPick(visitor, "Choose", lambda: None)


@pytest.fixture
def panel(visitor):
    return PartsPanel(visitor)


@pytest.fixture
def restoring(visitor):
    return RestoreControls(visitor)


def sent(button, name, content):
    """What viser says once a file has come."""
    button._impl.value = viser.UploadedFile(name, content)
    return SimpleNamespace(target=button)


def refusals(panel):
    """What was told, but that a file is being read, as it is on slow machines."""
    return [one for one in panel._visitor.client.told if "being read" not in one]


@pytest.mark.parametrize("kind", [".stl", ".obj", ".ply", ".glb"])
def test_what_a_cad_file_holds_is_told(pick, kind, nothing_is_read_here):
    content = cad_file(kind, 2000)
    nothing_is_read_here()
    pick._choose(sent(pick._pick, f"ring{kind}", content))
    wait_until(lambda: pick.look is not None or "wb-bad" in pick._line.content)
    assert pick.look is not None, pick._line.content
    assert pick.look.surface.is_watertight
    assert pick.look.surface.triangles == pytest.approx(2000, rel=0.05)
    np.testing.assert_allclose(pick.look.surface.size, [0.084, 0.084, 0.024], rtol=0.01)
    assert pick._pick.value.content == b"", "viser holds what was taken"


def test_a_scan_becomes_one(panel, bench, scan, tmp_path, nothing_is_read_here):
    write_cloud(tmp_path / "big.ply", scan)
    nothing_is_read_here()
    event = sent(panel._scan, "big.ply", (tmp_path / "big.ply").read_bytes())
    panel._upload(event, panel._scan_of)
    assert bench.state.phase is Phase.SCANNED, panel._visitor.client.told
    assert bench.state.scan.digest == scan.digest
    assert bench.state.scan.source == "big.ply"


def test_poses_become_parts_found(panel, bench, detections, tmp_path, nothing_is_read_here):
    write_poses(tmp_path / "poses.json", detections)
    nothing_is_read_here()
    event = sent(panel._poses, "poses.json", (tmp_path / "poses.json").read_bytes())
    panel._upload(event, panel._poses_of)
    found = bench.state.detections
    assert found is not None, panel._visitor.client.told
    assert [one.score for one in found] == [one.score for one in detections]
    assert str(bench.state.message) == "2 poses taken from poses.json, by Ada"


def test_what_a_backup_would_change_is_told(restoring, tmp_path, monkeypatch, nothing_is_read_here):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "parts" / "thing").mkdir(parents=True)
    (tmp_path / "parts" / "thing" / "note.txt").write_text("kept")
    write_backup(tmp_path, tmp_path / "kept.zip", ("parts",), {})
    content = (tmp_path / "kept.zip").read_bytes()
    nothing_is_read_here()
    restoring._upload(sent(restoring._pick, "kept.zip", content))
    wait_until(lambda: "reading" not in restoring._told.content)
    assert "stays the same" in restoring._told.content


def test_what_cannot_be_read_is_told_in_a_sentence(panel, bench):
    panel._upload(sent(panel._scan, "a.ply", b"no scan"), panel._scan_of)
    assert bench.state.scan is None
    assert refusals(panel) == ["a.ply: is neither a PLY nor a PCD file"]


def test_poses_in_more_bytes_than_poses_have_are_refused(panel):
    content = json.dumps({"format": "workbench-poses/1", "detections": [0] * 2_000_000}).encode()
    panel._upload(sent(panel._poses, "a.json", content), panel._poses_of)
    (told,) = refusals(panel)
    assert told.startswith("a.json: is longer than 4 MB")


@pytest.mark.parametrize("name", ODD_NAMES)
def test_a_name_that_no_file_has_is_refused_in_a_sentence(pick, panel, restoring, name, caplog):
    pick._choose(sent(pick._pick, name, b"x"))
    assert "is not the name of a file" in pick._line.content
    assert pick.drawing is None
    for button, made in ((panel._scan, panel._scan_of), (panel._poses, panel._poses_of)):
        panel._upload(sent(button, name, b"x"), made)
    told = refusals(panel)
    assert len(told) == 2 and all("is not the name of a file" in one for one in told)
    restoring._upload(sent(restoring._pick, name, b"x"))
    assert "is not the name of a file" in restoring._told.content
    assert "Traceback" not in caplog.text


def test_another_file_ends_the_reading_of_the_one_before(pick, monkeypatch):
    began, ended = threading.Event(), threading.Event()

    def read(name, content, unit, solid, *, cancelled):
        if name == "second.stl":
            return "second"
        began.set()
        wait_until(cancelled)
        ended.set()
        raise JobCancelled("the first")

    monkeypatch.setattr(cad_pick, "cad_look", read)
    monkeypatch.setattr(cad_pick, "look_message", str)
    pick._choose(sent(pick._pick, "first.stl", b"1"))
    wait_until(began.is_set)
    pick._choose(sent(pick._pick, "second.stl", b"2"))
    wait_until(ended.is_set)
    wait_until(lambda: pick.look == "second")
    assert "second.stl: second" in pick._line.content


def test_who_leaves_waits_for_no_file_any_more(pick, visitor, monkeypatch):
    ended = threading.Event()

    def read(name, content, unit, solid, *, cancelled):
        wait_until(cancelled)
        ended.set()
        raise JobCancelled(name)

    monkeypatch.setattr(cad_pick, "cad_look", read)
    pick._choose(sent(pick._pick, "first.stl", b"1"))
    visitor.end(is_gone=True)
    wait_until(ended.is_set)
