"""RAPID modules checked without being run: what is wrong, not known, or not executed here."""

import gc
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from workbench.formats.files.whole_files import is_file
from workbench.formats.rapid.backups.files import ENCODED
from workbench.formats.rapid.backups.folders import ControllerTasks, find_declared, find_tasks
from workbench.formats.rapid.declaring import Source
from workbench.formats.rapid.loading import Loaded
from workbench.formats.rapid.problems import UNKNOWN_NAME, UNREADABLE, BadModule, Problem
from workbench.formats.rapid.setup import CONTROLLER_FILE, read_setup


class Nobody:
    """A host for programs that are never run."""

    def step(self, key: Any) -> None:
        """Never."""

    def hold(self, why: Any) -> None:
        """Never."""

    def exit(self) -> None:
        """Never."""

    def connect(self, place: Any, trap: Any) -> None:
        """Never."""


@dataclass(frozen=True)
class Name:
    """A name that is not known or not executed here, and how often it is used.

    `use` says as what; `first` is where it is used first; `elsewhere` are modules that declare it,
    but not in the task where it is used.
    """

    name: str
    use: str
    uses: int
    first: Problem
    elsewhere: Sequence[str] = ()


@dataclass
class Checked:
    """What was found in all tasks; `tasks` are the paths of the modules in each.

    `spare` are modules of backups that no task loads, and that were not checked for this reason.
    """

    problems: list[Problem] = field(default_factory=list[Problem])
    tasks: list[tuple[str, list[str]]] = field(default_factory=list[tuple[str, list[str]]])
    uses: dict[str, str] = field(default_factory=dict[str, str])
    places: dict[str, list[str]] = field(default_factory=dict[str, list[str]])
    spare: list[str] = field(default_factory=list[str])

    def of(self, kind: str) -> list[Problem]:
        """The problems of one kind."""
        return [problem for problem in self.problems if problem.kind == kind]

    def names(self, kind: str) -> list[Name]:
        """The names of one kind, those that are used most first."""
        found: dict[str, list[Problem]] = {}
        for problem in self.of(kind):
            found.setdefault(problem.name.lower(), []).append(problem)
        names = [
            Name(ones[0].name, self._use(ones[0]), len(ones), ones[0], self.places.get(low, ()))
            for low, ones in found.items()
        ]
        return sorted(names, key=lambda name: (-name.uses, name.name.lower()))

    def _use(self, problem: Problem) -> str:
        return ENCODED if problem.what == ENCODED else self.uses.get(problem.name.lower(), "")


def check(paths: Sequence[Path], signals: Iterable[str] = ()) -> Checked:
    """Everything that is found in modules.

    A folder with a `controller.toml` is checked as it is configured, task by task; a backup as its
    folders and its `SYS.cfg` say; `find_tasks` says what becomes of other files.

    Args:
        paths: folders, or files.
        signals: names of signals, or `NAME:DI` and the like; outputs where nothing else is said.

    Raises:
        FileError: a file is missing, or the configuration is not right.
    """
    # Trees are many small objects that all stay: looking for garbage takes longer than reading.
    is_on = gc.isenabled()
    gc.disable()
    try:
        return _check_all(paths, dict(_signal(signal) for signal in signals))
    finally:
        if is_on:
            gc.enable()


def _check_all(paths: Sequence[Path], made: dict[str, str]) -> Checked:
    checked, rest = Checked(), list[Path]()
    sources: list[Source] = []
    problems: set[Problem] = set()
    for path in paths:
        if not is_file(path / CONTROLLER_FILE):
            rest.append(path)
            continue
        try:
            controller = read_setup(path).controller()
        except BadModule as error:
            problems |= set(error.problems)
            continue
        sources += _check(
            controller, {**controller.configuration.names(), **made}, checked, problems
        )
    if rest:
        found = find_tasks(rest)
        problems |= set(found.problems)
        sources += found.spare
        checked.spare = [spare_source.path for spare_source in found.spare]
        for controller in found.controllers:
            sources += _check(
                controller, {**controller.configuration.names(), **made}, checked, problems
            )
        if not sources:
            # Nothing was read at all: that an encoded module is no mistake helps nobody.
            problems = {_as_unreadable(problem) for problem in problems}
    unknown = {problem.name.lower() for problem in problems if problem.kind == UNKNOWN_NAME}
    for source in sources:
        for name in find_declared(source) & unknown:
            where = checked.places.setdefault(name, [])
            if source.path not in where:
                where.append(source.path)
    checked.problems = sorted(problems)
    return checked


def _as_unreadable(problem: Problem) -> Problem:
    kind = UNREADABLE if problem.kind == UNKNOWN_NAME else problem.kind
    return Problem(problem.module, problem.line, problem.column, problem.what, kind, problem.name)


def _signal(text: str) -> tuple[str, str]:
    name, _, kind = text.partition(":")
    return name, f"signal{kind.lower() or 'do'}"


def _check(
    controller: ControllerTasks, data: dict[str, str], checked: Checked, problems: set[Problem]
) -> list[Source]:
    shared: dict[str, list[Any]] = {}
    host = Nobody()
    sources: list[Source] = []
    for task in controller.tasks:
        loaded = Loaded(
            task.sources,
            host,
            natives={},
            makers={},
            shared=shared,
            signals=data,
            entry=task.entry,
        )
        problems |= set(loaded.problems)
        for name, use in loaded.problems.uses.items():
            if checked.uses.get(name, "data") == "data":
                checked.uses[name] = use
        sources += task.sources
        checked.tasks.append((task.name, [source.path for source in task.sources]))
    return sources
