"""Scans from a folder and from a page: complete ones only, in time, and a word when not."""

import contextlib
import functools
import http.server
import threading
import time
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from waiting import PATIENCE

from workbench.devices.scanners import FolderScanner, HttpScanner
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import write_cloud
from workbench.model.cell import ScannerMount
from workbench.model.errors import FileError, JobCancelled, LinkError
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Scan
from workbench.plugins.options import NoOptions
from workbench.plugins.scanner import ScanRequest

T = pose_from_rpy((0.4, 0.0, 0.9), (np.pi, 0, 0))
DRIBBLES = 2400
"""Pieces of an answer that takes two minutes."""

SCAN = Scan(np.random.default_rng(0).uniform(0.1, 0.5, (500, 3)), T, "made")


def made(kind, address, patience=PATIENCE, unit="m"):
    mount = ScannerMount(T, address=str(address), patience=patience, unit=unit)
    return kind(replace(read_cell("yumi"), scanner=mount), NoOptions())


def taken(scanner, *then: Callable[[], object], cancelled=lambda: False) -> Scan:
    """A scan, and what happens while it is awaited: one thing at each report."""
    left = list(then)

    def report(done: float, note: str) -> None:
        if left:
            left.pop(0)()

    return scanner.scan(ScanRequest(), report, cancelled)


def test_the_next_file_is_the_scan(tmp_path):
    write_cloud(tmp_path / "old.ply", SCAN)
    newer = Scan(SCAN.points + 0.01, T, "newer")
    scanner = made(FolderScanner, tmp_path)
    assert taken(scanner, lambda: write_cloud(tmp_path / "new.ply", newer)).digest == newer.digest


def test_a_file_is_read_when_it_is_complete(tmp_path):
    write_cloud(tmp_path / "whole.bin", SCAN)
    content = (tmp_path / "whole.bin").read_bytes()

    def more(start: int) -> None:
        with (tmp_path / "scan.ply").open("ab") as file:
            file.write(content[start : start + 2000])

    pieces = [functools.partial(more, start) for start in range(0, len(content), 2000)]
    assert len(pieces) > 5
    assert taken(made(FolderScanner, tmp_path), *pieces).digest == SCAN.digest


def test_a_file_that_was_being_written_when_the_scan_was_asked_for_is_not_taken(tmp_path):
    write_cloud(tmp_path / "whole.bin", SCAN)
    content = (tmp_path / "whole.bin").read_bytes()
    (tmp_path / "scan.ply").write_bytes(content[:2000])
    newer = Scan(SCAN.points + 0.01, T, "newer")

    def rest() -> None:
        with (tmp_path / "scan.ply").open("ab") as file:
            file.write(content[2000:])

    # Each report is a tenth of a second after the one before, at least.
    then = [rest, *[lambda: None] * 10, lambda: write_cloud(tmp_path / "scan.ply", newer)]
    assert taken(made(FolderScanner, tmp_path), *then).digest == newer.digest


def test_a_file_that_is_renamed_into_place_counts(tmp_path):
    write_cloud(tmp_path / "scan.part", SCAN)
    scanner = made(FolderScanner, tmp_path)
    found = taken(scanner, lambda: (tmp_path / "scan.part").rename(tmp_path / "scan.ply"))
    assert found.digest == SCAN.digest


def test_millimetres_are_millimetres(tmp_path):
    in_mm = Scan(SCAN.points * 1000, T, "mm")
    scanner = made(FolderScanner, tmp_path, unit="mm")
    found = taken(scanner, lambda: write_cloud(tmp_path / "scan.ply", in_mm))
    np.testing.assert_allclose(found.points, SCAN.points, rtol=1e-12)


def test_no_file_no_folder_and_a_broken_file_are_told(tmp_path):
    write_cloud(tmp_path / "old.ply", SCAN)
    with pytest.raises(LinkError, match=r"no new PLY or PCD file came .* within 0.4 s"):
        taken(made(FolderScanner, tmp_path, patience=0.4))
    with pytest.raises(LinkError, match="there is no folder"):
        taken(made(FolderScanner, tmp_path / "nowhere"))
    scanner = made(FolderScanner, tmp_path)
    with pytest.raises(FileError, match="neither a PLY nor a PCD"):
        taken(scanner, lambda: (tmp_path / "scan.pcd").write_bytes(b"not a cloud"))


def test_a_folder_that_goes_while_a_scan_is_awaited_is_told(tmp_path):
    folder = tmp_path / "scans"
    folder.mkdir()
    with pytest.raises(LinkError, match="scans: No such file"):
        taken(made(FolderScanner, folder), folder.rmdir)


def test_waiting_can_be_cancelled(tmp_path):
    over = threading.Event()
    with pytest.raises(JobCancelled):
        taken(made(FolderScanner, tmp_path), over.set, cancelled=over.is_set)


@pytest.fixture
def page(tmp_path):
    """A page on this machine that gives what it was given."""
    answers = {"/scan.ply": b"", "/dribble": b""}

    class Page(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            if self.path == "/dribble":
                self.send_response(200)
                self.end_headers()
                with contextlib.suppress(OSError):
                    for _ in range(DRIBBLES):
                        self.wfile.write(b"ply\n")
                        answers["/dribble"] += b"ply\n"
                        time.sleep(0.05)
                return
            if self.path == "/nonsense":
                self.wfile.write(b"no HTTP at all\r\n\r\n")
                return
            if self.path not in answers:
                self.send_error(404)
                return
            self.send_response(200)
            self.end_headers()
            self.wfile.write(answers[self.path])

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Page)
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield f"http://127.0.0.1:{server.server_address[1]}", answers
    server.shutdown()
    thread.join()
    server.server_close()


def test_a_page_gives_a_scan(page, tmp_path):
    address, answers = page
    write_cloud(tmp_path / "scan.ply", SCAN)
    answers["/scan.ply"] = (tmp_path / "scan.ply").read_bytes()
    assert taken(made(HttpScanner, f"{address}/scan.ply")).digest == SCAN.digest


def test_a_page_that_has_none_is_told(page):
    address, answers = page
    with pytest.raises(LinkError, match="404"):
        taken(made(HttpScanner, f"{address}/other.ply"))
    answers["/scan.ply"] = b"ply\nformat"
    with pytest.raises(FileError):
        taken(made(HttpScanner, f"{address}/scan.ply"))
    with pytest.raises(LinkError, match="scanner: http://127"):
        taken(made(HttpScanner, "http://127.0.0.1:9/scan.ply"))


def test_a_page_that_gives_a_scan_too_slowly_is_not_waited_for(page):
    address, answers = page
    scanner = made(HttpScanner, f"{address}/dribble", patience=0.3)
    with pytest.raises(LinkError, match="is too slow"):
        taken(scanner)
    assert len(answers["/dribble"]) < 4 * DRIBBLES, "it waited for the end"
    with pytest.raises(JobCancelled):
        taken(scanner, cancelled=lambda: True)


@pytest.mark.parametrize("path", ["nonsense", "scan 1.ply"])
def test_an_answer_or_an_address_that_is_no_http_is_told(page, path):
    with pytest.raises(LinkError, match="scanner: http://127"):
        taken(made(HttpScanner, f"{page[0]}/{path}"))


def test_the_scan_stands_where_the_scanner_does(tmp_path):
    scanner = made(FolderScanner, tmp_path)
    found = taken(scanner, lambda: write_cloud(tmp_path / "scan.ply", SCAN))
    assert isinstance(found.T_world_scanner, pin.SE3)
    assert found.T_world_scanner.isApprox(T)
