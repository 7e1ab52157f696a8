"""requirements.lock: every dependency of the core, pinned as in constraints.txt, with digests."""

import re
import tomllib
from pathlib import Path

from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

ROOT = Path(__file__).resolve().parents[2]
ENTRY = re.compile(
    r"^([\w.-]+)==(\S+)[^\n]*\\\n((?:    --hash=sha256:[0-9a-f]{64}(?: \\)?\n)+)", re.M
)
PIN = re.compile(r"^([\w.-]+)==(\S+)$", re.M)


def locked() -> dict[str, str]:
    """Version by name; what has no digest is not among them."""
    text = (ROOT / "requirements.lock").read_text()
    return {canonicalize_name(name): version for name, version, _ in ENTRY.findall(text)}


def test_every_line_belongs_to_an_entry_with_digests():
    text = (ROOT / "requirements.lock").read_text()
    assert not re.sub(r"^#.*\n", "", ENTRY.sub("", text), flags=re.M).strip()


def test_it_pins_every_dependency_of_the_core():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    found = locked()
    for requirement in map(Requirement, project["dependencies"]):
        version = found[canonicalize_name(requirement.name)]
        assert requirement.specifier.contains(version), requirement


def test_it_pins_what_the_tests_ran_with():
    pinned = PIN.findall((ROOT / "constraints.txt").read_text())
    tested = {canonicalize_name(name): version for name, version in pinned}
    found = locked()
    assert {name: tested.get(name, found[name]) for name in found} == found
    # Only what belongs to other systems, or to pip's own tools, was not installed for the tests.
    assert set(found) - set(tested) <= {"setuptools", "open3d", "colorama", "tzdata", "pywin32"}
