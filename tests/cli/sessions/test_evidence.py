"""`workbench evidence`: a key, a signed bundle, and what is refused."""

import json
import shutil
import sqlite3
import subprocess
import sys
import zipfile
from contextlib import closing
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import pytest

from workbench.app.core.session import Started
from workbench.app.provenance.gathering import inventory
from workbench.app.records.approvals import ApprovalRecord
from workbench.app.records.certificates import certificates
from workbench.app.records.record import command_form
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.certificates import read_certificate, versions
from workbench.journal.journal import Journal

EXAMPLE = Path(__file__).resolve().parents[3] / "sessions" / "example"


@pytest.fixture
def example(tmp_path) -> Path:
    return Path(shutil.copytree(EXAMPLE, tmp_path / "here" / "example"))


def test_a_key_is_made_a_session_signed_and_verified_by_the_script_inside(say, example, tmp_path):
    key, out = tmp_path / "our.key", tmp_path / "bundle.zip"
    said = say("evidence", "key", "--out", key).out
    public = said.split()[-1]
    assert key.stat().st_mode & 0o077 == 0
    assert public in say("evidence", example, "--out", out, "--sign", key, "--stamp").out
    with zipfile.ZipFile(out) as archive:
        archive.extract("verify.py", tmp_path)
        assert {"report.html", "report.pdf", "wire.txt"} <= set(archive.namelist())
        assert any(name.startswith("certificates/") for name in archive.namelist())
    assert (tmp_path / "bundle.tsq").stat().st_size < 200
    words = [sys.executable, "-I", "-S", "verify.py", "bundle.zip", "--key", public]
    done = subprocess.run(words, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


def test_an_auditor_gets_the_script_without_a_bundle(say, example, tmp_path):
    out, script = tmp_path / "bundle.zip", tmp_path / "verify.py"
    say("evidence", example, "--out", out)
    said = say("evidence", "script", "--out", script).out
    assert sha256(script.read_bytes()).hexdigest() in said
    with zipfile.ZipFile(out) as archive:
        assert archive.read("verify.py") == script.read_bytes()
    assert say("evidence", "script", "--out", script).code == 2


def test_the_record_of_the_command_line_is_verified_and_is_no_session(say, tmp_path):
    record = tmp_path / "approvals"
    ApprovalRecord(record).show("0" * 64, "Ada", 1e9, {"Plan": "0" * 64})
    assert "unchanged" in say("session", "verify", record).out
    refused = say("evidence", record, "--out", tmp_path / "bundle.zip")
    assert refused.code != 0 and "is no session" in refused.err


def test_a_certificate_in_a_bundle_is_one_that_can_be_checked(say, example, tmp_path):
    say("evidence", example, "--out", tmp_path / "bundle.zip")
    with zipfile.ZipFile(tmp_path / "bundle.zip") as archive:
        (name,) = [name for name in archive.namelist() if name.startswith("certificates/")]
        archive.extract(name, tmp_path)
    with closing(Journal(example)) as journal:
        (session, *_) = journal.entries()
    began_with = json.loads(session.body)["workbench"]
    assert read_certificate(tmp_path / name).made_with == {"workbench": began_with}


def test_a_bundle_and_an_exported_session_hold_the_same_certificate(say, example, tmp_path):
    say("evidence", example, "--out", tmp_path / "bundle.zip")
    say("session", "export", example, "--out", tmp_path / "x.zip", "--no-scene")
    found: list[bytes] = []
    for path in (tmp_path / "bundle.zip", tmp_path / "x.zip"):
        with zipfile.ZipFile(path) as archive:
            (name,) = [name for name in archive.namelist() if name.startswith("certificates/")]
            found.append(archive.read(name))
    assert found[0] == found[1]


def test_a_certificate_says_what_ran_when_the_plan_was_made(example, tmp_path):
    """The example is from before starts were recorded: three are put around its plan."""
    ran = inventory(read_cell("yumi"), {})
    older = replace(ran, workbench="0.0.1")
    without = replace(ran, distributions=tuple(d for d in ran.distributions if d.name != "pin"))
    with closing(Journal(example)) as journal:
        rows = list(journal.entries())

        def started(one):
            start = json.loads(command_form(Started(one)).form)
            body = json.dumps({"command": start, "after": {}}).encode()
            return replace(rows[0], kind="Started", body=body)

        (planned,) = (n for n, row in enumerate(rows) if row.kind == "MakePlan")
        around = [rows[0], started(older), *rows[1:planned], started(without), *rows[planned:]]
        (one,) = certificates([*around, started(older)], journal.read)
    (tmp_path / "one.json").write_bytes(one.certificate)
    made_with = read_certificate(tmp_path / "one.json").made_with
    assert made_with["inventory"] == without.digest
    assert made_with["workbench"] == ran.workbench
    # It may come from elsewhere than a Python distribution.
    assert made_with["pin"] == "unknown"
    assert made_with["coal"] == versions()["coal"]


def test_a_key_is_never_overwritten(say, tmp_path):
    say("evidence", "key", "--out", tmp_path / "our.key")
    before = (tmp_path / "our.key").read_bytes()
    said = say("evidence", "key", "--out", tmp_path / "our.key")
    assert (said.code, "never overwritten" in said.err) == (2, True)
    assert (tmp_path / "our.key").read_bytes() == before


@pytest.mark.parametrize("content", [b"", b"-----BEGIN PRIVATE KEY-----\nx\n", b"\xff" * 20_000])
def test_what_is_no_key_signs_nothing(say, example, tmp_path, content):
    (tmp_path / "key").write_bytes(content)
    said = say("evidence", example, "--out", tmp_path / "out.zip", "--sign", tmp_path / "key")
    assert said.code == 2
    assert not (tmp_path / "out.zip").exists()


def test_of_a_session_that_was_changed_there_is_no_evidence(say, example, tmp_path):
    with closing(sqlite3.connect(example / "journal.sqlite")) as open_, open_:
        open_.execute("DROP TRIGGER entries_remain")
        open_.execute("DELETE FROM entries WHERE number = 9")
    said = say("evidence", example, "--out", tmp_path / "out.zip")
    assert said.code == 1
    assert "of a changed session is no evidence" in said.err
    assert not (tmp_path / "out.zip").exists()


def test_a_bundle_is_not_written_into_the_session(say, example):
    said = say("evidence", example, "--out", example / "out.zip")
    assert (said.code, "lies in the session" in said.err) == (2, True)


@pytest.mark.extensive
@pytest.mark.parametrize("out", [".", "/"])
def test_a_folder_is_no_name_for_a_bundle(say, example, tmp_path, monkeypatch, out):
    monkeypatch.chdir(tmp_path)
    assert say("evidence", example, "--out", out).problem == f"{out}: is not the name of a file"
    exported = say("session", "export", example, "--out", out)
    assert exported.code == 2 and exported.problem.startswith(out)


def test_a_folder_that_is_no_session_is_told(say, tmp_path):
    said = say("evidence", tmp_path)
    assert (said.code, "is not the folder of a session" in said.err) == (2, True)
