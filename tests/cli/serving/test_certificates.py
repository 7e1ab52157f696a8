"""`workbench opcua`: certificates, as people type it."""

import json

import pytest

pytest.importorskip("asyncua")


def test_certificates_are_made_trusted_and_listed(say, tmp_path):
    folder = tmp_path / "opcua"
    where = ("--certificates", folder)
    made = say("opcua", "certificate", "--name", "192.168.0.5", *where)
    thumbprint = made.out.strip()
    assert (made.code, len(thumbprint)) == (0, 40)
    trusted = say("opcua", "trust", folder / "server.der", *where)
    assert (trusted.code, trusted.out.endswith("is trusted\n")) == (0, True)
    rows = json.loads(say("opcua", "list", "--json", *where).out)["certificates"]
    assert [row["whose"] for row in rows] == ["server", "trusted"]
    assert {row["thumbprint"] for row in rows} == {thumbprint}
    assert all(row["uri"].startswith("urn:") for row in rows)
    assert thumbprint in say("opcua", "list", *where).out


def test_what_is_wrong_is_said(say, tmp_path):
    (tmp_path / "notes.txt").write_text("no certificate")
    where = ("--certificates", tmp_path)
    assert "is no certificate" in say("opcua", "trust", tmp_path / "notes.txt", *where).problem
    assert "--days" in say("opcua", "certificate", "--days", "0", *where).problem
