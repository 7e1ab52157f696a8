"""The head of the journal is kept elsewhere at every approval, whatever becomes of the place."""

import json
import os
import threading
from contextlib import closing
from http.server import BaseHTTPRequestHandler, HTTPServer

import pytest
from idle import Idle
from waiting import wait_until

from workbench.app.core.cycle.approval import Approve
from workbench.app.core.cycle.jobs import JobEnded
from workbench.app.core.cycle.parts import UseDetections
from workbench.app.core.cycle.planning import MakePlan
from workbench.app.core.cycle.watching import WatchPlan
from workbench.app.records.sessions import new_session
from workbench.app.runtime.anchors import Anchors, place
from workbench.app.runtime.bench import Bench
from workbench.cli.main import main
from workbench.journal.anchors import anchor_problems, anchors_from
from workbench.model.errors import InputError

AT = 1_700_000_000.0


@pytest.fixture
def bench(tmp_path, cell):
    with closing(Bench(cell, new_session(tmp_path / "there", cell, AT), effects=Idle)) as made:
        yield made


def approve(bench, samples):
    bench.do(UseDetections(samples.detections()), "ada")
    number = bench.do(MakePlan(), "ada").number
    result = samples.planned(bench.state.scene_digest)
    bench.do(JobEnded(number, result), "worker")
    bench.do(WatchPlan(result.plan.digest), "ada")
    return bench.do(Approve(result.plan.digest), "ada").number


def test_each_approval_is_a_line_on_another_disk(bench, samples, tmp_path, capsys):
    file = tmp_path / "anchors"
    with closing(Anchors(bench, {"": place(str(file))}, lambda: AT)):
        numbers = [approve(bench, samples) for _ in range(2)]
    anchors = anchors_from(file.read_text())[0]
    assert [one["number"] for one in anchors] == numbers
    rows = {row.number: row.hash for row in bench.entries()}
    assert [one["hash"] for one in anchors] == [rows[number] for number in numbers]
    session = str(bench.folder)
    assert main(["session", "verify", session, "--anchors", str(file)]) == 0
    file.write_text(file.read_text().replace(anchors[0]["hash"], "0" * 64))
    assert main(["session", "verify", session, "--anchors", str(file)]) == 3
    assert "the journal is not the one kept elsewhere" in capsys.readouterr().out
    file.write_text("no anchors")
    assert main(["session", "verify", session, "--anchors", str(file)]) == 2


class Keeper(HTTPServer):
    """A place that takes what is posted, unless it is broken."""

    def __init__(self):
        super().__init__(("127.0.0.1", 0), Taking)
        self.kept: list[dict] = []
        self.is_broken = True
        self.tries = 0

    @property
    def address(self):
        return f"http://127.0.0.1:{self.server_port}/anchors"


class Taking(BaseHTTPRequestHandler):
    def do_POST(self):
        body = self.rfile.read(int(self.headers["Content-Length"]))
        self.server.tries += 1
        if not self.server.is_broken:
            self.server.kept.append(json.loads(body))
        self.send_response(503 if self.server.is_broken else 204)
        self.end_headers()

    def log_message(self, *arguments):
        pass


@pytest.fixture
def keeper():
    server = Keeper()
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    yield server
    server.shutdown()
    thread.join()
    server.server_close()


def test_an_address_that_was_broken_gets_them_all_and_holds_nobody_up(
    bench, samples, keeper, caplog
):
    anchors = Anchors(bench, {keeper.address: place(keeper.address)}, lambda: AT)
    numbers = [approve(bench, samples)]
    wait_until(lambda: keeper.tries > 0)
    keeper.is_broken = False
    numbers.append(approve(bench, samples))
    anchors.close()
    assert [one["number"] for one in keeper.kept] == numbers
    assert len([one for one in caplog.records if "cannot be kept" in one.message]) == 1


def test_what_is_owed_is_told_at_the_end(bench, samples, keeper):
    anchors = Anchors(bench, {keeper.address: place(keeper.address)}, lambda: AT)
    number = approve(bench, samples)
    wait_until(lambda: keeper.tries > 0)
    keeper.is_broken = False
    anchors.close()
    assert [one["number"] for one in keeper.kept] == [number]


class Nonsense(BaseHTTPRequestHandler):
    def do_POST(self):
        self.wfile.write(b"this is not HTTP\r\n\r\n")

    def log_message(self, *arguments):
        pass


def test_a_place_that_talks_nonsense_keeps_no_other_from_its_anchors(
    bench, samples, keeper, tmp_path
):
    keeper.RequestHandlerClass = Nonsense
    file = tmp_path / "anchors"
    places = {one: place(one) for one in (keeper.address, str(file))}
    with closing(Anchors(bench, places, lambda: AT)):
        number = approve(bench, samples)
    assert [one["number"] for one in anchors_from(file.read_text())[0]] == [number]


def test_a_line_that_was_written_in_part_is_written_again_on_a_line_of_its_own(
    bench, samples, tmp_path, monkeypatch
):
    file, write = tmp_path / "anchors", os.write
    with closing(Anchors(bench, {"": place(str(file))}, lambda: AT)):
        monkeypatch.setattr(os, "write", lambda number, line: write(number, line[:20]))
        numbers = [approve(bench, samples)]
        wait_until(lambda: file.read_bytes())
        monkeypatch.setattr(os, "write", write)
        numbers.append(approve(bench, samples))
    anchors = anchors_from(file.read_text())[0]
    assert [one["number"] for one in anchors] == numbers


def test_a_file_that_ends_within_a_line_is_read_but_for_that_line(bench, samples, tmp_path, capsys):
    file = tmp_path / "anchors"
    file.write_text('{"session": "an')
    with closing(Anchors(bench, {"": place(str(file))}, lambda: AT)):
        approve(bench, samples)
    assert main(["session", "verify", str(bench.folder), "--anchors", str(file)]) == 0
    assert "line 1 of the anchors was not written to its end" in capsys.readouterr().out


def test_anchors_of_another_form_are_told(bench, tmp_path, capsys):
    file = tmp_path / "anchors"
    for bad in ({"number": []}, {"hash": 1}, {"session": None}):
        one = {"session": bench.folder.name, "number": 1, "hash": "0" * 64, **bad}
        file.write_text(json.dumps(one))
        assert main(["session", "verify", str(bench.folder), "--anchors", str(file)]) == 2
        assert "holds no anchors" in capsys.readouterr().err


BAD = ["http://keeper:80o/", "http://keeper:99999/", "http://keeper:0/", "http://[::1/"]


@pytest.mark.parametrize("typed", ["/nowhere/at/all", "", "http://", "a\0b", "x" * 300, *BAD])
def test_a_place_that_is_none_is_told_at_the_start(typed):
    with pytest.raises(InputError, match="--anchor"):
        place(typed)


def test_a_session_without_an_anchor_is_told():
    hashes = {1: "1" * 64}
    assert list(anchor_problems(hashes, "a", [])) == ["no anchor of session a was kept elsewhere"]
    one = {"session": "a", "number": 2, "hash": "2" * 64}
    (problem,) = anchor_problems(hashes, "a", [one, {**one, "session": "b"}])
    assert "is not in the journal" in problem
