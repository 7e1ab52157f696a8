"""What the workbench is made of: its dependencies as installed, their licences, and an SBOM."""

import re
import uuid
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from importlib.metadata import Distribution
from typing import Any

from packaging.markers import Marker
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from workbench import __version__
from workbench.app.provenance.gathering import by_name
from workbench.plugins.extras import not_installed

ROOT = "workbench"

SPDX: Mapping[str, str] = {
    "apache software license": "Apache-2.0",
    "apache 2": "Apache-2.0",
    "apache 2.0": "Apache-2.0",
    "bsd": "BSD-3-Clause",
    "bsd license": "BSD-3-Clause",
    "isc license (iscl)": "ISC",
    "mit license": "MIT",
    "the mit license (mit)": "MIT",
    "mozilla public license 2.0 (mpl 2.0)": "MPL-2.0",
    "python software foundation license": "PSF-2.0",
    "gnu lesser general public license v3 or later (lgplv3+)": "LGPL-3.0-or-later",
}
"""What packages call licences that have an identifier."""

IDENTIFIER = re.compile(r"[A-Za-z0-9.+-]+(?: (?:AND|OR|WITH) [A-Za-z0-9.+-]+)*")


@dataclass(frozen=True, slots=True)
class Component:
    """An installed dependency; `licence` is an SPDX expression, empty where it states none.

    `needs` are the names of those that it depends on, as far as they are installed.
    """

    name: str
    version: str
    licence: str
    needs: tuple[str, ...]


def components(extras: Iterable[str] = ()) -> tuple[Component, ...]:
    """The workbench's dependencies that are installed, with theirs, by name; itself comes first.

    Args:
        extras: of the workbench whose dependencies count, too.
    """
    installed = _distributions_here()
    needs: dict[str, set[str]] = {}
    waiting = [(ROOT, extra) for extra in ("", *extras)]
    seen = set(waiting)
    while waiting:
        name, extra = waiting.pop()
        here = needs.setdefault(name, set())
        for needed, with_extra in _list_needs(installed[name], extra):
            if needed in installed:
                here.add(needed)
                if (needed, with_extra) not in seen:
                    seen.add((needed, with_extra))
                    waiting.append((needed, with_extra))
    others = sorted(set(needs) - {ROOT})
    return tuple(_component(name, installed[name], needs[name]) for name in (ROOT, *others))


def missing(extra: str) -> tuple[str, ...]:
    """What an extra of the workbench asks for and is not installed, as pip takes it."""
    installed = _distributions_here()
    lacking: list[str] = []
    for text in installed[ROOT].requires or []:
        requirement = Requirement(text)
        if requirement.marker is not None and not requirement.marker.evaluate({"extra": extra}):
            continue
        there = installed.get(canonicalize_name(requirement.name))
        if there is None or not requirement.specifier.contains(there.version, prereleases=True):
            lacking.append(f"{requirement.name}{requirement.specifier}")
    return tuple(lacking)


def sbom(found: tuple[Component, ...]) -> dict[str, Any]:
    """A software bill of materials: CycloneDX 1.6, the same for the same components."""
    root, *others = found
    bill = {
        "bomFormat": "CycloneDX",
        "specVersion": "1.6",
        "version": 1,
        "metadata": {"component": {"type": "application", **_entry(root)}},
        "components": [{"type": "library", **_entry(component)} for component in others],
        "dependencies": [
            {"ref": component.name, "dependsOn": sorted(component.needs)} for component in found
        ],
    }
    number = uuid.uuid5(uuid.NAMESPACE_URL, repr(found))
    return {**bill, "serialNumber": f"urn:uuid:{number}"}


def _distributions_here() -> Mapping[str, Distribution]:
    """The installed distributions by name, each once: the one that is imported.

    Raises:
        InputError: the workbench itself is not one of them.
    """
    found = by_name()
    if ROOT not in found:
        raise not_installed()
    return found


def _licence_of(distribution: Distribution) -> str:
    """The licence that a distribution states, as SPDX has it; empty where it says nothing clear."""
    about = distribution.metadata
    kinds = about.get_all("Classifier") or []
    stated = [
        *(about.get_all("License-Expression") or []),
        *(kind.split("::")[-1].strip() for kind in kinds if kind.startswith("License ::")),
        *(text.partition("\n")[0].strip() for text in about.get_all("License") or []),
    ]
    for text in stated:
        known = SPDX.get(text.casefold(), text)
        if IDENTIFIER.fullmatch(known) and known.casefold() not in ("unknown", "license"):
            return known
    return ""


def _list_needs(distribution: Distribution, extra: str) -> Iterable[tuple[str, str]]:
    for text in distribution.requires or []:
        needed = Requirement(text)
        if _holds(needed.marker, extra):
            for with_extra in ("", *needed.extras):
                yield canonicalize_name(needed.name), with_extra


def _holds(marker: Marker | None, extra: str) -> bool:
    return marker is None or marker.evaluate({"extra": extra})


def _component(name: str, distribution: Distribution, needs: Iterable[str]) -> Component:
    version = __version__ if name == ROOT else distribution.version
    return Component(name, version, _licence_of(distribution), tuple(sorted(needs)))


def _entry(component: Component) -> dict[str, Any]:
    entry: dict[str, Any] = {
        "bom-ref": component.name,
        "name": component.name,
        "version": component.version,
        "purl": f"pkg:pypi/{component.name}@{component.version}",
    }
    if component.licence:
        entry["licenses"] = [{"expression": component.licence}]
    return entry
