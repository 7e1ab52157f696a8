"""The folders of ROS packages that robot files name, found near the files and without ROS.

Source: https://ros.org/reps/rep-0127.html (`package.xml`)
"""

import os
import re
from collections import defaultdict
from collections.abc import Iterator, Sequence
from pathlib import Path

from workbench.formats.files.whole_files import MB, is_file, is_folder, read_whole
from workbench.model.errors import FileError

MANIFEST = "package.xml"
PACKAGE_NAME = re.compile(rb"<name\b[^>]*>\s*([A-Za-z0-9_.-]+)\s*</name>")

MOST_LEVELS = 3
"""Levels of folders below one above the file, and below one that a person names."""

MOST_FOLDERS = 3000
"""That are looked into in all: above the file may lie a whole disk."""

PASSED_OVER = {"build", "log", "node_modules", "__pycache__", "meshes", "proc", "sys", "dev"}
VARIABLES = ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH")
"""Where a shell that is set up for ROS says where packages are."""


class Packages:
    """The packages around one file.

    A package is a folder of that name, or one whose `package.xml` says it.  It is searched for in
    the folders that a person names; then among the folders above the file, beside and below these,
    and where the variables of ROS say.
    """

    def __init__(self, file: Path, more: Sequence[Path] = ()):
        """The packages around `file`, and first of all those in `more`.

        Raises:
            FileError: one of `more` is no folder.
        """
        for folder in more:
            if not is_folder(folder):
                raise FileError(folder, "is no folder in which packages could be")
        self._more = [folder.resolve() for folder in more]
        self._above = list(file.resolve().parents)
        self._below: dict[Path, dict[str, list[Path]]] = {}
        self._left = MOST_FOLDERS

    def all(self, name: str) -> Iterator[Path]:
        """The folders that may be the package, the likeliest first; some may come twice."""
        for folder in self._more:
            yield from (parent for parent in (folder, *folder.parents) if _is_package(parent, name))
            yield from self._inside(folder, name)
        yield from (folder for folder in self._above if _is_package(folder, name))
        yield from (folder / name for folder in self._above if is_folder(folder / name))
        # Neither the root of the disk nor what lies directly in it is somebody's workspace.
        for folder in self._above[:-2]:
            yield from self._inside(folder, name)
        for variable in VARIABLES:
            for place in filter(None, os.environ.get(variable, "").split(os.pathsep)):
                for folder in (Path(place) / "share" / name, Path(place) / name, Path(place)):
                    if is_folder(folder) and _is_package(folder, name):
                        yield folder

    def find(self, name: str) -> Path | None:
        """The folder of a package, sooner one with a `package.xml`; None where there is none."""
        found = list(dict.fromkeys(self.all(name)))
        return next(
            (folder for folder in found if is_file(folder / MANIFEST)), next(iter(found), None)
        )

    def missing(self, name: str) -> str:
        """The sentence that says where a package was searched for."""
        places = [*self._more, *self._above[:-2]][:4]
        listed = ", ".join(str(place) for place in places) or "no folder"
        return (
            f"package {name!r} was not found: no folder of that name, and no {MANIFEST} that names "
            f"it, in and below {listed}; say where it is with --package-path FOLDER"
        )

    def _inside(self, top: Path, name: str) -> list[Path]:
        """The packages of that name below a folder."""
        if top not in self._below:
            self._below[top] = self._map_names(top)
        return self._below[top].get(name, [])

    def _map_names(self, top: Path) -> dict[str, list[Path]]:
        """The packages below a folder by their names, those of folders and those they give."""
        found: defaultdict[str, list[Path]] = defaultdict(list)
        level = [top]
        for _ in range(MOST_LEVELS):
            level = [inner for folder in level for inner in self._folders(folder)]
            for folder in level:
                if is_file(folder / MANIFEST):
                    for name in {folder.name, _given_name(folder)}:
                        found[name].append(folder)
        return found

    def _folders(self, folder: Path) -> list[Path]:
        """The folders in a folder in which packages may be."""
        if self._left <= 0:
            return []
        try:
            inner = sorted(entry.path for entry in os.scandir(folder) if entry.is_dir())
        except OSError:
            return []
        inner = [path for path in map(Path, inner) if _may_hold(path)]
        self._left -= len(inner)
        return inner


def _may_hold(folder: Path) -> bool:
    return not folder.name.startswith(".") and folder.name not in PASSED_OVER


def _is_package(folder: Path, name: str) -> bool:
    return folder.name == name or _given_name(folder) == name


def _given_name(folder: Path) -> str:
    """The name that the `package.xml` in a folder gives; the folder's where there is none."""
    if not is_file(folder / MANIFEST):
        return folder.name
    try:
        found = PACKAGE_NAME.search(read_whole(folder / MANIFEST, MB))
    except FileError:
        return folder.name
    return found[1].decode() if found else folder.name
