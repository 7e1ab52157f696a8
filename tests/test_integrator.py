"""The page for integrators: its scanner is run, its files are read."""

import re
import socket
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from workbench.app.runtime.work import JOBS
from workbench.devices.scanners import SCANNERS
from workbench.formats.cells.calibrations import read_scanned_poses
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import SCAN_SOURCES
from workbench.model.errors import JobCancelled, LinkError

PAGE = (Path(__file__).resolve().parents[1] / "docs" / "integrator.md").read_text(encoding="utf-8")


@pytest.fixture
def acme(monkeypatch):
    """The class on the page, registered as the page says."""
    (code,) = re.findall(r"```python\n(.*?)```", PAGE, re.DOTALL)
    names: dict = {}
    exec(compile(code, "docs/integrator.md", "exec"), names)
    monkeypatch.setitem(SCANNERS, "acme", names["AcmeScanner"])


@pytest.fixture
def device():
    """A scanner that sends what it is told to, once."""
    server = socket.create_server(("127.0.0.1", 0))
    server.settimeout(120)
    content: list[bytes] = []

    def serve() -> None:
        link, _ = server.accept()
        with link:
            for chunk in content:
                link.sendall(chunk)

    thread = threading.Thread(target=serve)
    thread.start()
    yield f"127.0.0.1:{server.getsockname()[1]}", content
    thread.join()
    server.close()


def cell_with(address):
    cell = read_cell("yumi")
    mount = replace(cell.scanner, source="acme", address=address, patience=5.0)
    return replace(cell, scanner=mount)


def take(cell, cancelled=lambda: False):
    return JOBS["scan"](cell, {"seed": 0, "parts": 2}, lambda done, note: None, cancelled)


def test_the_scanner_on_the_page_takes_scans(acme, device):
    address, content = device
    points = np.random.default_rng(0).uniform(100, 900, (5000, 3)).astype("<f4")
    points[7] = 0
    points[8] = np.nan
    data = points.tobytes()
    content += [data[:1001], data[1001:]]
    scan = take(cell_with(address))
    assert len(scan.points) == 4998 and scan.source == "acme"
    assert np.allclose(scan.points[:7], points[:7] / 1000)


def test_a_scanner_that_sends_nothing_is_told(acme, device):
    address, _ = device
    with pytest.raises(LinkError, match="measured nothing"):
        take(cell_with(address))


def test_waiting_for_it_can_be_cancelled(acme, device):
    address, content = device
    content.append(b"0" * 1200)
    with pytest.raises(JobCancelled):
        take(cell_with(address), cancelled=lambda: True)


def test_every_source_of_a_cell_file_has_its_class():
    assert set(SCANNERS) | {"simulated"} == set(SCAN_SOURCES)
    for name in SCAN_SOURCES:
        assert f"| `{name}` |" in PAGE


def test_the_files_on_the_page_are_read(tmp_path):
    detections, calibration = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    (tmp_path / "calibration.toml").write_text(calibration)
    (tmp_path / "pose_1.ply").write_bytes(b"ply")
    found = read_scanned_poses(tmp_path, read_cell("yumi"))
    assert (found.arm, found.unit, len(found.poses)) == ("right", "mm", 1)
    assert "[detections]" in detections
    shipped = Path(read_cell.__code__.co_filename).parents[3] / "robots" / "yumi"
    (tmp_path / "yumi").symlink_to(shipped)
    text = (shipped / "cell.toml").read_text().replace('"yumi.', '"yumi/yumi.')
    text = text.replace('"meshes/', '"yumi/meshes/')
    (tmp_path / "cell.toml").write_text(f"{text}\n{detections}")
    folder = read_cell(tmp_path / "cell.toml").poses_folder
    assert (folder.path, folder.part) == (str(tmp_path / "poses"), "keyed_cylinder")
