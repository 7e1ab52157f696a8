"""Where the meshes are that a robot file names."""

from collections.abc import Iterator
from pathlib import Path, PurePosixPath
from urllib.parse import unquote

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import is_file
from workbench.formats.files.xml_elements import Element
from workbench.formats.robots.packages import Packages
from workbench.model.errors import FileError

OF_PACKAGES = ("package://", "model://")
LEVELS = 3
"""Folders above a file in which a name without a package is searched for, too."""


class MissingMesh(FileError):
    """A robot file names a mesh that is not there."""


def mesh_file(element: Element, name: str, packages: Packages) -> Path:
    """The file that an element names, next to the robot file or in a package.

    A name whose letters are large where the file's are small, or the other way, is found as well.

    Raises:
        MissingMesh: there is none; it says where it was searched for.
    """
    plain = name.replace("\\", "/").strip()
    scheme = next(
        (package_scheme for package_scheme in OF_PACKAGES if plain.startswith(package_scheme)), None
    )
    if scheme is None:
        return _beside(element, name, plain.removeprefix("file://"), packages)
    package, _, rest = plain.removeprefix(scheme).partition("/")
    folders = list(dict.fromkeys(packages.all(package)))
    beside = element.path.parent.resolve()
    for folder in (*folders, beside):
        found = _in(folder, rest)
        if found is not None:
            return found
    if not folders:
        raise _missing(element, name, packages.missing(package))
    raise _missing(element, name, f"there is no such file in {folders[0]}")


def _beside(element: Element, name: str, plain: str, packages: Packages) -> Path:
    folder = element.path.parent.resolve()
    for above in (folder, *list(folder.parents)[:LEVELS]):
        found = _in(above, plain)
        if found is not None:
            return found
    if plain.startswith("/"):
        # A URDF that was expanded on another machine: the package is one of the folders it names.
        parts = PurePosixPath(plain).parts[1:]
        for k in reversed(range(len(parts) - 1)):
            for folder in dict.fromkeys(packages.all(parts[k])):
                found = _in(folder, "/".join(parts[k + 1 :]))
                if found is not None:
                    return found
    raise _missing(element, name, "there is no such file beside the URDF")


def _missing(element: Element, name: str, problem: str) -> MissingMesh:
    place = f"{element.place}{element.line}"
    return MissingMesh(element.path, f"{place}: filename={quote(name)}: {problem}")


def _in(folder: Path, name: str) -> Path | None:
    """The file of that name in a folder, `%20` being a space, letters of either size."""
    for spelling in dict.fromkeys((name, unquote(name))):
        if is_file(folder / spelling):
            return (folder / spelling).resolve()
    parts = PurePosixPath(name).parts
    if not parts or name.startswith("/") or ".." in parts:
        return None
    return next(_alike(folder, parts), None)


def _alike(folder: Path, parts: tuple[str, ...]) -> Iterator[Path]:
    """Files below a folder whose parts differ in the size of letters at most."""
    try:
        there = sorted(path for path in folder.iterdir() if path.name.lower() == parts[0].lower())
    except OSError:
        return
    for path in there:
        if len(parts) > 1:
            yield from _alike(path, parts[1:])
        elif is_file(path):
            yield path.resolve()
