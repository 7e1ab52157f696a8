"""RAPID modules checked without being run: syntax, names, types, bounds, what is never reached."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

from workbench.formats.files.whole_files import is_file
from workbench.formats.rapid.loading import Loaded, Source
from workbench.formats.rapid.problems import BadModule, Problem
from workbench.formats.rapid.setup import FILE, read_module, read_setup


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


def check_modules(paths: Sequence[Path], signals: Sequence[str] = ()) -> list[Problem]:
    """What is wrong with modules, by module, line and column.

    A folder with a `controller.toml` is checked as it is configured, task by task; files alone are
    one task.  Names that are neither declared nor executed here are problems, too.

    Args:
        paths: a folder, or files.
        signals: names of outputs that are configured.

    Raises:
        FileError: a file is missing, or the configuration is not right.
    """
    found: set[Problem] = set()
    sources: list[Source] = []
    for path in paths:
        try:
            if is_file(path / FILE):
                setup = read_setup(path)
                shared: dict[str, list[Any]] = {}
                for task in setup.tasks.values():
                    found |= set(_problems(task.modules, [*signals, *setup.outputs], shared))
            else:
                sources.append(read_module(path))
        except BadModule as error:
            found |= set(error.problems)
    if sources:
        found |= set(_problems(sources, signals, {}))
    return sorted(found)


def _problems(
    sources: Sequence[Source], signals: Sequence[str], shared: dict[str, list[Any]]
) -> list[Problem]:
    makers: dict[str, Callable[[str], Any]] = {}
    host = Nobody()
    return Loaded(sources, host, natives={}, makers=makers, shared=shared, signals=signals).problems
