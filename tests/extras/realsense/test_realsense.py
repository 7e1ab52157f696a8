"""RealSense: recordings that the maker's library has made, played by the same library."""

import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from realsense_recordings import COLUMNS, ROWS, SERIAL, Camera, points, record
from scanner_calls import made, taken
from waiting import PATIENCE

from workbench.extras.realsense.scanner import RealsenseOptions, RealsenseScanner
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import InputError, JobCancelled, LinkError
from workbench.model.messages.message import Message
from workbench.plugins.options import options_of
from workbench.plugins.scanner import ScanRequest
from workbench.testing import check_scanner

FRAMES = 6


@pytest.fixture(scope="module")
def recording(tmp_path_factory):
    return record(tmp_path_factory.mktemp("realsense") / "bin.db3", FRAMES)


def scanner(file, **options):
    patience = options.pop("patience", 60.0)
    given = {"file": str(file), "skipped_frames": 3, **options}
    return made(RealsenseScanner, "", patience, options=given)


@pytest.mark.parametrize("skipped", [0, 3, FRAMES - 1])
def test_an_image_is_where_its_counts_and_the_camera_say(recording, skipped):
    scan = taken(scanner(recording, skipped_frames=skipped, serial=SERIAL))
    right = points(skipped + 1).reshape(-1, 3)
    measured = np.flatnonzero(np.isfinite(right[:, 2]))
    assert 0 < len(measured) < COLUMNS * ROWS
    assert scan.resolution == (COLUMNS, ROWS)
    np.testing.assert_array_equal(scan.pixels, measured)
    np.testing.assert_allclose(scan.points, right[measured], rtol=1e-6, atol=1e-7)
    assert scan.source == f"{recording} frame {skipped + 1}"


def test_it_keeps_the_promises_of_its_seam(recording):
    cell = read_cell("yumi")
    options = {"file": str(recording), "skipped_frames": 1}
    mount = replace(cell.scanner, source="realsense", options=options)
    check_scanner(RealsenseScanner, replace(cell, scanner=mount))


AGAIN = """
import sys
from workbench.extras.realsense.scanner import RealsenseOptions, RealsenseScanner
from workbench.formats.cells.reading import read_cell
from workbench.plugins.scanner import ScanRequest

scanner = RealsenseScanner(read_cell("yumi"), RealsenseOptions(file=sys.argv[1], skipped_frames=1))
for _ in range(100):
    scanner.scan(ScanRequest(), lambda *_: None, lambda: False)
print("all taken")
"""


@pytest.mark.extensive
def test_a_recording_may_be_left_while_it_plays_as_often_as_one_likes(recording):
    # In a process of its own, which the library ended when it was stopped while it played.
    command = [sys.executable, "-c", AGAIN, str(recording)]
    ran = subprocess.run(command, capture_output=True, text=True, timeout=PATIENCE, check=False)
    assert (ran.returncode, ran.stdout) == (0, "all taken\n"), ran.stderr


def test_a_recording_that_is_too_short_or_of_another_camera_is_told(recording):
    with pytest.raises(LinkError, match=rf"ends after {FRAMES} images; 6 are skipped"):
        taken(scanner(recording, skipped_frames=FRAMES))
    with pytest.raises(LinkError, match=f"serial number {SERIAL}, not 77"):
        taken(scanner(recording, serial="77"))


def test_what_is_no_recording_of_depths_is_told(tmp_path):
    with pytest.raises(LinkError, match=r"there is no recording .*no.db3 \(file\)"):
        taken(scanner(tmp_path / "no.db3"))
    assert not (tmp_path / "no.db3").exists()
    (tmp_path / "text.db3").write_text("no recording")
    with pytest.raises(LinkError, match=r"text.db3: .*file is not a database"):
        taken(scanner(tmp_path / "text.db3"))
    other = record(tmp_path / "infrared.db3", 2, is_depth=False)
    with pytest.raises(LinkError, match=r"infrared.db3: it has no depth images"):
        taken(scanner(other))


def test_a_scale_that_cannot_be_is_noticed(recording):
    cell = read_cell("yumi")
    mount = replace(cell.scanner, near=20.0, far=50.0)
    options = RealsenseOptions(file=str(recording), skipped_frames=0)
    with pytest.raises(LinkError, match=r"frame 1 is 5\d\d mm .* away, .* 20000 mm to 50000 mm"):
        taken(RealsenseScanner(replace(cell, scanner=mount), options))


@pytest.fixture
def plugged(monkeypatch):
    """Plugs in cameras that the library makes up, each with its number.

    Such cameras are not on the library's own list of what is plugged in; all else is its own.
    """
    import pyrealsense2 as rs

    devices = []

    def plug(serial: str) -> Camera:
        camera = Camera(serial=serial)
        devices.append(camera.device)
        return camera

    monkeypatch.setattr(rs, "context", lambda: SimpleNamespace(query_devices=lambda: devices))
    return plug


def test_a_camera_is_found_by_its_number_and_sends_what_comes_after_the_question(plugged):
    cameras = {serial: plugged(serial) for serial in ("A1", "B2")}
    sent = iter(range(1, 100))
    live = made(RealsenseScanner, "", options={"serial": "B2", "skipped_frames": 2})

    def send(done: float, note: Message | str) -> None:
        cameras["A1"].send(99)
        if "waiting" in str(note):
            cameras["B2"].send(next(sent))

    scan = live.scan(ScanRequest(), send, lambda: False)
    right = points(3).reshape(-1, 3)[scan.pixels]
    np.testing.assert_allclose(scan.points, right, rtol=1e-6, atol=1e-7)
    assert scan.source == "B2 frame 3"
    sized = {"columns": 32, "rows": 24, "serial": "A1"}
    with pytest.raises(LinkError, match="A1: it has no depth images of 32 x 24 pixels"):
        taken(made(RealsenseScanner, "", options=sized))
    with pytest.raises(LinkError, match=r"answers \(found: A1, B2\)"):
        taken(made(RealsenseScanner, ""))
    with pytest.raises(LinkError, match=r"no image came within 0\.3 s"):
        taken(made(RealsenseScanner, "", patience=0.3, options={"serial": "A1"}))


def test_without_a_camera_or_the_library_it_is_told(monkeypatch):
    with pytest.raises(LinkError, match=r"scanner 12345: no camera .* answers \(found: -\)"):
        taken(made(RealsenseScanner, "", options={"serial": "12345"}))
    with pytest.raises(LinkError, match=r"the only camera: no camera .* answers \(found: -\)"):
        taken(
            made(RealsenseScanner, "", options={"exposure_us": 8000.0, "columns": 848, "rows": 480})
        )
    monkeypatch.setitem(sys.modules, "pyrealsense2", None)
    with pytest.raises(LinkError, match=r"-m pip install 'workbench\[realsense\]'"):
        taken(made(RealsenseScanner, ""))


def test_a_person_can_end_it(recording):
    over: list[bool] = []
    with pytest.raises(JobCancelled):
        taken(scanner(recording), lambda: over.append(True), cancelled=lambda: bool(over))


@pytest.mark.parametrize(
    ("options", "told"),
    [
        ({"file": "bin.db3"}, "file: an absolute path is expected"),
        ({"file": "/bin.db3", "exposure_us": 100}, "exposure_us: a recording"),
        ({"file": "/bin.db3", "columns": 640, "rows": 480}, "columns: a recording"),
        ({"columns": 640}, "columns: rows are given together with it"),
        ({"rows": 480}, "columns: rows are given together with it"),
        ({"skipped_frames": -1}, "skipped_frames: -1 is not between"),
        ({"exposure": 100}, "exposure is not known here"),
    ],
)
def test_keys_that_do_not_fit_are_refused(options, told):
    with pytest.raises(InputError, match=told):
        options_of(RealsenseOptions, options)
