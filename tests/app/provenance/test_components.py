"""What the workbench is made of is listed whole, and every licence is one that was looked at."""

import json
import re
import runpy
import tomllib
from pathlib import Path

import pytest

from workbench.app.provenance.components import Component, components, missing, sbom
from workbench.cli.main import main

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def found():
    return components(("opcua",))


@pytest.fixture(scope="module")
def licences():
    return runpy.run_path(str(ROOT / "setup" / "licences.py"))


def test_dependencies_of_dependencies_are_listed_once(found):
    names = [one.name for one in found]
    assert names[0] == "workbench"
    assert names[1:] == sorted(set(names[1:]))
    assert {"numpy", "viser", "llvmlite", "libpinocchio"} <= set(names)
    known = set(names)
    assert all(set(one.needs) <= known for one in found)


def test_extras_count_when_they_are_asked_for(found):
    assert "asyncua" in {one.name for one in found}
    assert "asyncua" not in {one.name for one in components()}


def test_what_is_not_installed_is_missing():
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert len(asked["dependencies"]) > 20
    assert missing("") == ()


def test_a_bill_of_materials_names_each_with_version_licence_and_what_it_needs(found):
    bill = sbom(found)
    assert (bill["bomFormat"], bill["specVersion"]) == ("CycloneDX", "1.6")
    assert len(bill["components"]) == len(found) - 1
    numpy = next(one for one in bill["components"] if one["name"] == "numpy")
    assert numpy["purl"] == f"pkg:pypi/numpy@{numpy['version']}"
    assert "BSD-3-Clause" in numpy["licenses"][0]["expression"]
    references = [one["bom-ref"] for one in bill["components"]] + ["workbench"]
    assert sorted(one["ref"] for one in bill["dependencies"]) == sorted(references)
    assert re.fullmatch(r"urn:uuid:[0-9a-f-]{36}", bill["serialNumber"])
    assert sbom(found) == bill


def test_every_extra_is_looked_at(licences):
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    assert set(licences["EXTRAS"]) == set(asked["optional-dependencies"]) - {"test", "docs", "lint"}


def test_every_licence_is_on_the_list(licences, capsys):
    assert licences["main"]() == 0, capsys.readouterr().out


@pytest.mark.parametrize(
    ("name", "licence", "is_allowed"),
    [
        ("a", "MIT", True),
        ("a", "MIT AND Zlib", True),
        ("a", "GPL-3.0-only OR MIT", True),
        ("a", "GPL-3.0-only", False),
        ("a", "MIT AND GPL-3.0-only", False),
        ("a", "LGPL-3.0-or-later", False),
        ("asyncua", "LGPL-3.0-or-later", True),
        ("asyncua", "AGPL-3.0-only", False),
        ("a", "Qhull", False),
        ("cmeel-qhull", "", True),
        ("a", "", False),
    ],
)
def test_what_is_not_on_the_list_is_told(licences, name, licence, is_allowed):
    known = tomllib.loads((ROOT / "setup" / "licences.toml").read_text())
    said = licences["problems"]((Component(name, "1", licence, ()),), known)
    assert (said == []) == is_allowed


def test_the_doctor_says_what_is_here_and_writes_the_bill(tmp_path, capsys):
    assert main(["doctor", "--json", "--sbom", str(tmp_path / "sbom.json")]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["ok"] and said["missing"] == []
    asked = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    ours = {"test", "docs", "lint"}
    assert set(said["extras"]) == set(asked["optional-dependencies"]) - ours
    bill = json.loads((tmp_path / "sbom.json").read_text())
    assert bill["metadata"]["component"]["name"] == "workbench"


def test_the_doctor_names_the_command_that_installs_what_is_missing(monkeypatch, capsys):
    monkeypatch.setenv("COLUMNS", "200")
    lacking = {"": ("numpy>=2.0",), "opcua": ("asyncua>=1.1",)}
    monkeypatch.setattr("workbench.cli.doctor.missing", lambda extra: lacking.get(extra, ()))
    assert main(["doctor"]) == 3
    said = capsys.readouterr().out
    assert "missing: numpy>=2.0" in said
    assert "-m pip install 'workbench[opcua]'" in said
