"""Scans from a page: whole ones only, in time, and a word when not."""

import contextlib
import http.server
import threading
import time

import pytest
from scanner_calls import SCAN, made, taken

from workbench.devices.scanners.http import HttpScanner
from workbench.formats.clouds.scans import write_cloud
from workbench.model.errors import FileError, JobCancelled, LinkError

DRIBBLES = 2400
"""Pieces of an answer that takes two minutes."""


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
    with pytest.raises(LinkError, match="scanner http://127"):
        taken(made(HttpScanner, "http://127.0.0.1:9/scan.ply"))


def test_a_page_that_gives_a_scan_too_slowly_is_not_waited_for(page):
    address, answers = page
    scanner = made(HttpScanner, f"{address}/dribble", patience=0.3)
    with pytest.raises(LinkError, match=r"is too slow: .* within 0\.3 s"):
        taken(scanner)
    assert len(answers["/dribble"]) < 4 * DRIBBLES, "it waited for the end"
    with pytest.raises(JobCancelled):
        taken(scanner, cancelled=lambda: True)


@pytest.mark.parametrize("path", ["nonsense", "scan 1.ply"])
def test_an_answer_or_an_address_that_is_no_http_is_told(page, path):
    with pytest.raises(LinkError, match="scanner http://127"):
        taken(made(HttpScanner, f"{page[0]}/{path}"))
