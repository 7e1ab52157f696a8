"""Xacro files expanded to plain URDF, without ROS.

Source: https://github.com/ros/xacro
"""

import contextlib
import io
import re
import sys
import tempfile
from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any
from xml.parsers.expat import ExpatError

import xacro

from workbench.formats.files.toml_keys import quote
from workbench.formats.files.whole_files import is_file, is_folder, read_whole
from workbench.formats.files.xml_elements import LARGEST_FILE
from workbench.formats.robots.packages import MANIFEST, Packages
from workbench.formats.robots.xacro_lines import (
    line_of_call,
    line_of_error,
    line_of_name,
    marking_meshes,
)
from workbench.model.errors import FileError

COMMENT = re.compile(rb"<!--.*?-->", re.DOTALL)
NEEDS_XACRO = re.compile(rb"<xacro:|\$\{|\$\((?:find|arg|env|optenv|dirname|eval|cwd)\b")
"""Of whichever namespace: makers write at least three, and xacro looks at the prefix alone."""

LINK = re.compile(rb"<link[\s/>]")
MACRO = re.compile(rb"<xacro:macro\b[^>]*?\bname=[\"']([^\"']+)")
ARGUMENT = re.compile(rb"<xacro:arg\b[^>]*?\bname=[\"']([^\"']+)[^>]*>")
DEFAULT = re.compile(rb"\bdefault=[\"']([^\"']*)")
WITHOUT_PREFIX = re.compile(rb"<(include|macro|property)\s")

FINDER = "ament_index_python"
"""The package of ROS that xacro asks where others are."""

INCLUDED = (".xacro", ".urdf", ".xml")
"""Files that a robot may do without: they are empty where their package is missing."""

MOST_MISSING = 50
"""Such files of one robot."""

MOST_SAID = 200
"""Letters of what xacro says."""

MOST_LISTED = 12
MOST_FILES = 400


@dataclass(frozen=True, slots=True)
class Expanded:
    """A URDF as `content`, and `notes`: sentences about what a person may not expect."""

    content: bytes
    notes: tuple[str, ...] = ()


def is_xacro(path: Path) -> bool:
    """Whether a file has to be expanded before it is a URDF.

    Raises:
        FileError: it cannot be read.
    """
    return bool(NEEDS_XACRO.search(COMMENT.sub(b"", read_whole(path, LARGEST_FILE))))


def expand_xacro(
    path: Path, arguments: Mapping[str, str], packages: Packages | None = None
) -> Expanded:
    """The URDF that a xacro file stands for.

    Files that it includes from a package that is missing are left out if it does without them.

    Args:
        path: of the file.
        arguments: for its `xacro:arg` elements.
        packages: where `$(find ...)` looks; around the file when None.

    Raises:
        FileError: xacro cannot make sense of it, a package or an argument is missing, or the file
            holds no link.
    """
    with tempfile.TemporaryDirectory(prefix="workbench-") as nowhere:
        finder = _Finder(packages or Packages(path), Path(nowhere))
        given = _Arguments(arguments)
        for _ in range(MOST_MISSING):
            try:
                content = _process(path, given, finder)
                break
            except Exception as error:  # it evaluates expressions, which raise whatever they like
                if not (finder.does_without(error) or given.takes_default(path, error)):
                    raise FileError(path, _problem(path, error, finder, given)) from None
        else:
            raise FileError(path, f"cannot be expanded by xacro: {finder.missing}")
        # A mesh of a missing package is searched once more, by the name of the package.
        for found in (f"file://{nowhere}/", f"{nowhere}/"):
            content = content.replace(found.encode(), b"package://")
    if not LINK.search(content):
        raise FileError(path, f"has no links{_why_no_links(path, content)}")
    unused = (name for name in arguments if name not in given.used)
    notes = [f"xacro argument {quote(name)} is not one that this file asks for" for name in unused]
    without = (f"what it adds is left out: {sentence}" for sentence in finder.missing)
    return Expanded(content, (*without, *notes))


class _Arguments(dict[str, str]):
    """The arguments of a xacro file; it knows which were asked for."""

    def __init__(self, given: Mapping[str, str]):
        super().__init__(given)
        self.used: set[str] = set()

    def __getitem__(self, name: str) -> str:
        self.used.add(name)
        return super().__getitem__(name)

    def __contains__(self, name: object) -> bool:
        self.used.add(str(name))
        return super().__contains__(name)

    def takes_default(self, path: Path, error: BaseException) -> bool:
        """Give an argument the default that the file has for it below where it asks for it."""
        name = _argument_of(error)
        if name is None or dict.__contains__(self, name):
            return False
        default = _defaults(path).get(name)
        if default is None or "$" in default:
            return False
        self[name] = default
        return True


class _Finder:
    """Finds packages for xacro; instead of a missing one it names an empty folder."""

    def __init__(self, packages: Packages, nowhere: Path):
        self._packages = packages
        self._nowhere = nowhere
        self._missing: list[str] = []

    @property
    def missing(self) -> tuple[str, ...]:
        """A sentence for each package that was not found."""
        return tuple(map(self._packages.missing, self._missing))

    def __call__(self, name: str) -> str:
        folder = self._packages.find(name)
        if folder is None and name not in self._missing:
            self._missing.append(name)
        return str(folder or self._nowhere / name)

    def does_without(self, error: BaseException) -> bool:
        """Put an empty file where the include failed, if it is of a missing package."""
        file = next(_files_of(error), None)
        if file is None or not file.is_relative_to(self._nowhere) or file.suffix not in INCLUDED:
            return False
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("<robot/>")
        return True


@contextlib.contextmanager
def _asking(finder: _Finder) -> Generator[None]:
    """Let xacro ask `finder` where packages are, whether or not ROS is there."""
    before = {name: sys.modules.get(name) for name in (FINDER, f"{FINDER}.packages")}
    stand_in = ModuleType(f"{FINDER}.packages")
    vars(stand_in)["get_package_share_directory"] = finder
    sys.modules.update({FINDER: ModuleType(FINDER), f"{FINDER}.packages": stand_in})
    try:
        yield
    finally:
        for name, module in before.items():
            if module is None:
                del sys.modules[name]
            else:
                sys.modules[name] = module


def _process(path: Path, arguments: "_Arguments", finder: _Finder) -> bytes:
    said = io.StringIO()  # its warnings are for those who write such files
    with (
        _asking(finder),
        marking_meshes(path),
        contextlib.redirect_stderr(said),
        contextlib.redirect_stdout(said),
    ):
        # It puts the defaults of the file among the arguments.
        again = _Arguments(arguments)
        again.used = arguments.used
        document: Any = xacro.process_file(str(path), mappings=again)
    return document.toxml(encoding="utf-8")


def _causes(error: BaseException | None) -> Iterator[BaseException]:
    """An error and those that it wraps."""
    while error is not None:
        yield error
        error = getattr(error, "exc", None)


def _files_of(error: BaseException) -> Iterator[Path]:
    """The files that could not be read."""
    for cause in _causes(error):
        if isinstance(cause, OSError) and isinstance(cause.filename, str):
            yield Path(cause.filename)


def _argument_of(error: BaseException) -> str | None:
    """The argument that was asked for and is not there."""
    found = (cause for cause in _causes(error) if type(cause).__name__ == "ArgException")
    return next(map(str, found), None)


def _problem(path: Path, error: BaseException, finder: _Finder, given: "_Arguments") -> str:
    """What is wrong, and what to do about it, as one sentence."""
    stack: list[Any] = getattr(xacro, "filestack", None) or [None]
    inner = Path(stack[-1]) if stack[-1] else path
    where = "" if inner.resolve() == path.resolve() else f", in {inner}"
    missing = next(_files_of(error), None)
    line = "" if missing is None else line_of_name(inner, missing)
    if finder.missing:
        return f"cannot be expanded by xacro{where}{line}: {'; '.join(finder.missing)}"
    if any(isinstance(cause, RecursionError) for cause in _causes(error)):
        return f"cannot be expanded by xacro{_circle(path, [Path(file) for file in stack])}"
    for cause in _causes(error):
        mark: Any = getattr(cause, "problem_mark", None)  # of PyYAML, which xacro reads with
        if mark is not None:
            what = f"{mark.name}, line {mark.line + 1}: is not valid YAML: {vars(cause)['problem']}"
            return f"cannot be expanded by xacro{where}: {what}"
    if isinstance(error, ExpatError):
        return f"cannot be expanded by xacro{where}: is not valid XML: {error}"
    name = _argument_of(error)
    if name is not None:
        return f"needs the xacro argument {quote(name)}: give it as --xacro {name}:=VALUE"
    if missing is not None:
        return (
            f"cannot be expanded by xacro{where}{line}: "
            f"there is no file {_lacking(path, missing, given)}"
        )
    said = " ".join(str(error).split())[:MOST_SAID] or type(error).__name__
    said = "".join(letter if letter.isprintable() else "?" for letter in said)
    return (
        f"cannot be expanded by xacro{where}{line_of_error(inner, error, _causes(error))}: {said}"
    )


def _circle(path: Path, stack: list[Path]) -> str:
    """Where files include each other without end, or else a macro calls itself."""
    files = [file.resolve() for file in stack]
    back = next((k for k, file in enumerate(files) if file in files[:k]), None)
    inner = stack[-1 if back is None else back - 1]
    where = "" if inner.resolve() == path.resolve() else f", in {inner}"
    if back is not None:
        listed = ", ".join(dict.fromkeys(file.name for file in files[:back]))
        line = line_of_name(inner, files[back])
        return f"{where}{line}: an include leads back to itself ({listed})"
    macros: list[Any] = getattr(xacro, "macrostack", None) or []
    if not macros:
        return f"{where}: an expression leads back to itself"
    name = macros[-1].body.getAttribute("name")
    return f"{where}{line_of_call(inner, name)}: macro {quote(name)} calls itself"


def _lacking(path: Path, missing: Path, given: "_Arguments") -> str:
    """A file that is not there, what there is instead, and which argument leads to it."""
    said = str(missing)
    above = next((parent for parent in missing.parents if is_folder(parent)), None)
    if above is not None:
        there = sorted(
            neighbour.name for neighbour in above.iterdir() if not neighbour.name.startswith(".")
        )
        listed = ", ".join(there[:MOST_LISTED]) + (", ..." if len(there) > MOST_LISTED else "")
        said += f" (in {above.name} there is {listed or 'nothing'})"
    arguments = _defaults(path) | given
    in_path = [name for name, value in arguments.items() if value in missing.parts]
    if above is not None:
        gap = missing.relative_to(above).parts[0]
        if any(
            neighbour.name.endswith(gap) and neighbour.name != gap for neighbour in above.iterdir()
        ):
            # Something belongs before it, which an argument that is empty should have been.
            in_path = [name for name, value in arguments.items() if not value] or in_path
    if in_path:
        name = in_path[0]
        value = "VALUE"
        if arguments[name] == missing.name:
            value = str(next(_of_that_name(path, missing.name), value))
        return f"{said}; its argument {name} is {quote(arguments[name])}: --xacro {name}:={value}"
    return said


def _of_that_name(path: Path, name: str) -> Iterator[Path]:
    """The files of that name in the package in which a file lies."""
    package = next((above for above in path.resolve().parents if is_file(above / MANIFEST)), None)
    if package is not None:
        yield from sorted(package.rglob(name))


def _defaults(path: Path) -> dict[str, str]:
    """The arguments of a file that need not be given, by name, with what they are then."""
    found: dict[str, str] = {}
    for tag in ARGUMENT.finditer(read_whole(path, LARGEST_FILE)):
        default = DEFAULT.search(tag[0])
        if default is not None:
            found[tag[1].decode()] = default[1].decode()
    return found


def _why_no_links(path: Path, content: bytes) -> str:
    """What speaks for another file, or for another way to expand this one."""
    if WITHOUT_PREFIX.search(content):
        return ": its <include>, <macro> or <property> lack the prefix xacro:"
    macros = [name.decode() for name in MACRO.findall(read_whole(path, LARGEST_FILE))]
    if not macros:
        return ""
    files = sorted(path.resolve().parent.parent.rglob("*.xacro"))[:MOST_FILES]
    calls = [
        file.name
        for file in files
        if file.name != path.name and path.name.encode() in read_whole(file, LARGEST_FILE)
    ]
    instead = f"; take one that includes it: {', '.join(calls[:MOST_LISTED])}" if calls else ""
    return f": it only defines {', '.join(map(quote, macros[:3]))} for other files{instead}"
