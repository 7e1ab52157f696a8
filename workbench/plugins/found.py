"""The entry points that installed packages declare, including the workbench itself.

A name of the workbench has precedence, so no other package can replace a built-in plug-in.
`plugins` reports what cannot be loaded; only the use of a broken plug-in fails.
"""

import logging
import threading
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cache
from importlib.metadata import EntryPoint, PackageNotFoundError, distribution, entry_points
from typing import Any, Literal, get_args

from workbench.model.errors import InputError
from workbench.plugins.extras import not_installed

log = logging.getLogger(__name__)

OURS = "workbench"

BROKEN = (Exception, SystemExit)
"""What the import of a foreign module may raise, except Ctrl-C."""

SLOW = 10.0
"""[s] The log names a module with a longer import, since the command waits for it."""

SLOW_WORDS = "%s: importing %s takes more than %.0f s"

Group = Literal[
    "workbench.scanners",
    "workbench.robot_links",
    "workbench.planners",
    "workbench.localizers",
    "workbench.tools",
    "workbench.tabs",
]
GROUPS: tuple[Group, ...] = get_args(Group)

WHAT: dict[Group, str] = {
    "workbench.scanners": "scanner",
    "workbench.robot_links": "robot link",
    "workbench.planners": "planner",
    "workbench.localizers": "localizer",
    "workbench.tools": "tool",
    "workbench.tabs": "tab",
}
"""The kind of plug-in of each group, for people."""


@dataclass(frozen=True, slots=True)
class Plugin:
    """A declared name, its distribution, and the problem, if it cannot be used."""

    group: Group
    name: str
    target: str
    package: str
    version: str
    problem: str = ""


USUAL = "default"
"""Our entry point with this name is the default for cell files; a cell file cannot name it."""


def names(group: Group) -> tuple[str, ...]:
    """All names of a group: those of the workbench, then the others, each in alphabetical order."""
    ours = (name for name in sorted(_own()[group]) if name != USUAL)
    return tuple(dict.fromkeys((*ours, *sorted(_foreign()[group]))))


def load(group: Group, name: str) -> Any:
    """The object that a name stands for.

    Raises:
        InputError: no package declares the name, several do, or the object cannot be loaded.
    """
    own = _own()[group].get(name)
    found = [own] if own is not None else _foreign()[group].get(name, [])
    what = WHAT[group]
    if not found:
        raise InputError(f"there is no {what} {name!r}; known: {', '.join(names(group))}")
    if len(found) > 1:
        both = " and ".join(sorted(package for _, package, _ in found))
        raise InputError(f"the {what} {name!r} is declared by {both}; remove one of them")
    entry, package, _ = found[0]
    try:
        return _load(entry)
    except BROKEN as error:
        raise InputError(f"the {what} {name!r} of {package} {_why(error)}") from error


def plugins() -> Iterator[Plugin]:
    """All declared plug-ins, each with its problem, if it has one."""
    for group in GROUPS:
        own, foreign = _own()[group], _foreign()[group]
        for entry, package, version in own.values():
            if entry.name == USUAL:
                continue
            yield _try(group, entry, package, version, "")
        for name, found in foreign.items():
            for entry, package, version in found:
                problem = ""
                if name in own:
                    problem = "the workbench has one of that name, which is used"
                elif len(found) > 1:
                    problem = "several packages declare that name, so none of them is used"
                yield _try(group, entry, package, version, problem)


_Found = tuple[EntryPoint, str, str]
"""An entry point with the name and the version of its distribution."""


def _try(group: Group, entry: EntryPoint, package: str, version: str, problem: str) -> Plugin:
    if not problem:
        try:
            _load(entry)
        except BROKEN as error:
            problem = _why(error)
    return Plugin(group, entry.name, entry.value, package, version, problem)


def _why(error: BaseException) -> str:
    return f"cannot be loaded: {type(error).__name__}: {error}"


@cache
def _load(entry: EntryPoint) -> Any:
    slow = threading.Timer(SLOW, log.warning, (SLOW_WORDS, entry.name, entry.module, SLOW))
    slow.daemon = True
    slow.start()
    try:
        return entry.load()
    finally:
        slow.cancel()


@cache
def _own() -> dict[Group, dict[str, _Found]]:
    """The entry points of the workbench, without a search of all packages, which takes long."""
    try:
        package = distribution(OURS)
    except PackageNotFoundError:
        raise not_installed() from None
    version = package.version
    return {
        group: {
            entry.name: (entry, OURS, version)
            for entry in package.entry_points
            if entry.group == group
        }
        for group in GROUPS
    }


@cache
def _foreign() -> dict[Group, dict[str, list[_Found]]]:
    found: dict[Group, dict[str, list[_Found]]] = {group: {} for group in GROUPS}
    declared = entry_points()
    for group in GROUPS:
        for entry in declared.select(group=group):
            name, version = _name_and_version(entry.dist)
            if name != OURS:
                found[group].setdefault(entry.name, []).append((entry, name, version))
    return found


@cache
def _name_and_version(package: Any) -> tuple[str, str]:
    """Name and version of a distribution, which reads its whole metadata for each access."""
    return str(package.name).lower().replace("_", "-"), package.version
