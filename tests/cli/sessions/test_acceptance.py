"""`workbench acceptance`: the exit code says whether the targets are met."""

import json
import shutil
from pathlib import Path

import pytest

from workbench.journal.journal import DATABASE

EXAMPLE = Path(__file__).resolve().parents[3] / "sessions" / "example"


def test_the_example_is_judged_and_its_record_written(say, tmp_path):
    out = tmp_path / "record.html"
    met = json.loads(
        say("acceptance", EXAMPLE, "--picks", 1, "--share", 0.1, "--out", out, "--json").out
    )
    assert met["ok"] and "Signatures" in out.read_text()
    pdf = tmp_path / "record.pdf"
    said = say("acceptance", EXAMPLE, "--out", pdf)
    assert said.code == 1 and "Not all targets are met" in said.out
    assert pdf.read_bytes().startswith(b"%PDF")


@pytest.mark.parametrize(
    "words",
    [
        ("--share", "98"),
        ("--picks", "0"),
        ("--seconds", "nan"),
        ("--out", "no/such/folder/record.html"),
    ],
)
def test_what_cannot_be_is_one_sentence(say, words):
    said = say("acceptance", EXAMPLE, *words)
    assert said.code == 2 and said.err.count("\n") == 1


def test_a_changed_session_is_refused(say, tmp_path):
    copy = shutil.copytree(EXAMPLE, tmp_path / "changed")
    content = bytearray((copy / DATABASE).read_bytes())
    place = content.find(b'"actor"')
    content[place + 12] ^= 1
    (copy / DATABASE).write_bytes(content)
    said = say("acceptance", copy)
    assert said.code == 1 and "changed" in said.err
