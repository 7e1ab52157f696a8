"""Compares the licences of all dependencies, extras included, with the list beside it."""

import sys
import tomllib
from pathlib import Path

from workbench.app.provenance.components import Component, components

LIST = Path(__file__).with_name("licences.toml")
EXTRAS = ("bench", "cluster", "egm", "evidence", "mcap", "modbus", "opcua", "realsense", "ur-rtde")


def problems(found: tuple[Component, ...], known: dict) -> list[str]:
    """What of these has a licence that is not on the list, a sentence each."""
    said = []
    for one in found:
        licence = one.licence or known["stated"].get(one.name, "")
        if known["extras"].get(one.name) == licence != "":
            continue
        if one.name in known["only"].get(licence, ()):
            continue
        if not licence:
            said.append(f"{one.name} {one.version} states no licence; look it up: {LIST.name}")
        elif not _is_allowed(licence, set(known["allowed"])):
            said.append(f"{one.name} {one.version} has the licence {licence}, not on the list")
    return said


def _is_allowed(licence: str, allowed: set[str]) -> bool:
    choices = (choice.split(" AND ") for choice in licence.split(" OR "))
    return any(all(one in allowed for one in choice) for choice in choices)


def main() -> int:
    """Say what is wrong."""
    known = tomllib.loads(LIST.read_text(encoding="utf-8"))
    found = components(EXTRAS)
    said = problems(found, known)
    print("\n".join(said) or f"{len(found)} licences, all on the list")
    return 1 if said else 0


if __name__ == "__main__":
    sys.exit(main())
