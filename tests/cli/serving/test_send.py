"""A plan sent by a command: what is read first, whose word it is, and words that do not count."""

import contextlib
import io
import json
import socket
import sqlite3
import threading
import time
from contextlib import closing
from math import floor

import numpy as np
import pytest

import workbench.cli.serving.send as send_command
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.plan_files import read_plan, write_plan

NO_ROBOT = ("--host", "127.0.0.1", "--port", 9, "--approve-as", "Ada")


class Terminal(io.StringIO):
    """Where a person types."""

    def isatty(self):
        return True


@pytest.fixture
def record(tmp_path):
    return tmp_path / "record"


@pytest.fixture
def words(record):
    return (*NO_ROBOT, "--record", record)


def kinds(record):
    with closing(sqlite3.connect(record / "journal.sqlite")) as connection:
        return [kind for (kind,) in connection.execute("SELECT kind FROM entries ORDER BY number")]


@pytest.fixture
def digest(line):
    return read_plan(line.plan)[0].digest


def test_what_is_approved_is_printed_before(line, say, words, digest, record):
    said = say("send", line.plan, *words, "--scan", line.scan)
    assert said.code == 2
    assert "this is no terminal" in said.problem
    plan, _ = read_plan(line.plan)
    proof = prove(read_cell("yumi"), plan)
    for fact in (
        digest,
        f"at least {floor(proof.clearance * 1e4) / 10:.1f} mm, arm {proof.nearest.arm}",
        " and ".join(proof.nearest.pair),
        f"{plan.cycle_seconds:.1f} s",
        str(plan.strategy),
        *(f"part-{one.detection + 1} (keyed_cylinder), grasp {one.grasp}" for one in plan.arms),
        f"compared with {line.scan}",
        "127.0.0.1 port 9, abb-socket",
        "reports no joints: see for yourself",
        "nobody has watched this plan",
    ):
        assert fact in said.out
    assert kinds(record) == ["Shown"]


@pytest.mark.parametrize("given", ["", "0" * 64, "f" * 12, "{short}", "{digest}0", " "])
def test_another_digest_approves_nothing(line, say, words, digest, record, given):
    given = given.format(short=digest[:11], digest=digest)
    said = say("send", line.plan, *words, "--digest", given)
    assert said.code == 2
    assert "nothing was approved and nothing sent" in said.problem
    assert not record.exists()


def test_a_digest_that_nobody_was_shown_approves_nothing(line, say, words, digest, record):
    said = say("send", line.plan, *words, "--digest", digest)
    assert said.code == 2
    assert "was not shown to Ada" in said.problem
    assert kinds(record) == []


def test_the_digest_of_a_plan_does_not_approve_the_plan_as_it_was_edited(
    line, say, words, digest, record, tmp_path
):
    assert say("send", line.plan, *words).code == 2
    content = json.loads(line.plan.read_text())
    content["note"] = "quite harmless"
    edited = tmp_path / "edited.json"
    edited.write_text(json.dumps(content))
    said = say("send", edited, *words, "--digest", digest)
    assert said.code == 2 and "was changed" in said.problem
    plan, _ = read_plan(edited)
    write_plan(edited, plan, prove(read_cell("yumi"), plan))
    said = say("send", edited, *words, "--digest", digest)
    assert said.code == 2 and "is not the digest of this plan" in said.problem
    said = say("send", edited, *words, "--digest", plan.digest)
    assert said.code == 2 and "was not shown" in said.problem
    assert kinds(record) == ["Shown"]


def test_a_word_lapses(line, say, words, digest, record, monkeypatch):
    assert say("send", line.plan, *words).code == 2
    later = time.time() + 60 * read_cell("yumi").policy.approval_minutes + 1
    monkeypatch.setattr(send_command.time, "time", lambda: later)
    said = say("send", line.plan, *words, "--digest", digest)
    assert said.code == 2 and "read again" in said.problem


def test_what_was_shown_for_one_controller_does_not_count_for_another(line, say, words, digest):
    assert say("send", line.plan, *words).code == 2
    said = say("send", line.plan, *words, "--port", 10, "--digest", digest)
    assert said.code == 2 and "otherwise now (controller)" in said.problem


def test_at_a_terminal_the_digest_is_typed_and_a_plan_goes_out_once(
    line, say, robot, digest, record, monkeypatch
):
    address = ("--host", "127.0.0.1", "--port", robot.port, "--state-port", robot.state_port)
    words = (*address, "--approve-as", "Ada", "--record", record)
    monkeypatch.setattr("sys.stdin", Terminal("yes\n"))
    said = say("send", line.plan, *words)
    assert said.code == 2 and "'yes' is not the digest" in said.err
    assert "stands where the plan starts" in said.out
    monkeypatch.setattr("sys.stdin", Terminal(f"{digest[:12]}\n"))
    said = say("send", line.plan, *words)
    assert said.code == 0, said.err
    assert "approved by Ada, who has not seen it played" in said.out
    arrived = len(robot.arrived)
    for given in ((), ("--digest", digest)):
        said = say("send", line.plan, *words, *given)
        assert said.code == 2 and "before and has gone out" in said.err
    assert len(robot.arrived) == arrived
    assert kinds(record) == ["Shown", "Shown", "Approval", "Ended"]


def test_a_robot_that_stands_elsewhere_is_sent_nothing(line, say, digest, words, record):
    """A controller that reports joints 3 degrees off, on a port of its own."""
    cell = read_cell("yumi")
    joints = {arm.name: (arm.home + np.deg2rad(3.0)).tolist() for arm in cell.arms}
    report = {"joints": joints, "openings": {"right": 0.0, "left": 0.0}, "moving": ""}
    line_of = json.dumps(report | {"received": 0, "placed": 0, "fault": ""}).encode() + b"\n"
    with socket.create_server(("127.0.0.1", 0)) as server, Reporter(server, line_of):
        port = server.getsockname()[1]
        said = say("send", line.plan, *words, "--state-port", port, "--digest", digest)
        assert said.code == 2 and "the robot has moved" in said.problem
        said = say("send", line.plan, *words, "--state-port", port)
        assert said.code == 2 and "the robot has moved" in said.problem
    assert not record.exists() or kinds(record) == []


class Reporter:
    """Answers everybody with one report."""

    def __init__(self, server, line_of):
        self._server, self._line = server, line_of
        self._thread = threading.Thread(target=self._run)

    def __enter__(self):
        self._thread.start()

    def __exit__(self, *_):
        self._server.shutdown(socket.SHUT_RDWR)
        self._thread.join()

    def _run(self):
        while True:
            try:
                link, _ = self._server.accept()
            except OSError:
                return
            with link:
                link.sendall(self._line)
                link.settimeout(5)
                with contextlib.suppress(OSError):
                    link.recv(1)
