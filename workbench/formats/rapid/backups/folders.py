"""Which modules are loaded into one task, from where their files lie."""

import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from workbench.formats.files.whole_files import read_whole
from workbench.formats.rapid.backups.cfg import Configuration, read_configuration
from workbench.formats.rapid.backups.files import SUFFIXES, lines_of, read_modules
from workbench.formats.rapid.declaring import Source
from workbench.formats.rapid.problems import REMARK, BadModule, Problem
from workbench.formats.rapid.symbols import parts, words
from workbench.formats.rapid.syntax.tokens import SyntaxTree
from workbench.model.errors import FileError

TASK = re.compile(r"TASK\d+", re.IGNORECASE)
PLACES = frozenset({"progmod", "sysmod"})
FOLDERS = frozenset({"rapid", "home", "syspar", "backinfo"})
"""Of a backup; in HOME is what somebody has put on the controller's disk."""

LISTED = re.compile(r"<Module>\s*([^<]*?)\s*</Module>", re.IGNORECASE)
BACKED_UP = re.compile(r">>(TASK\d+):\s*\((\w*),.*\)\s*\n((?:.*@.*\n)*)")
MOST_NAMED = 4
"""Largest number of names shared by modules of a task that are reported one by one."""


@dataclass
class TaskFiles:
    """What is loaded into one task, and where it begins, if that is known."""

    name: str
    sources: list[Source]
    entry: str = ""


@dataclass
class ControllerTasks:
    """Tasks that share persistents and a configuration."""

    tasks: list[TaskFiles]
    configuration: Configuration = field(default_factory=Configuration)


@dataclass
class FolderContents:
    """Everything in some folders and files; `spare` are modules that no task loads."""

    controllers: list[ControllerTasks] = field(default_factory=list[ControllerTasks])
    spare: list[Source] = field(default_factory=list[Source])
    problems: list[Problem] = field(default_factory=list[Problem])


def find_tasks(paths: Sequence[Path]) -> FolderContents:
    """Read folders and files, and find out what belongs together.

    A folder `TASK1` with `PROGMOD` and `SYSMOD`, as in a backup, is a task; `SYS.cfg` adds to it.
    Files elsewhere are one task, or, where several have a `main`, one for each of these with all
    that have none.

    Raises:
        FileError: a file is missing, or there is no module.
    """
    found = FolderContents()
    files = [file for path in paths for file in _files(path)]
    shown = {file: _label(file, paths) for file in files}
    read = {file: _read(file, shown[file]) for file in files if _is_module(file)}
    configurations = [file for file in files if file.suffix.lower() == ".cfg"]
    roots = sorted({root for file in read if (root := _root(file)) is not None})
    for root in roots:
        mine = {file: content for file, content in read.items() if _home(file, roots) == root}
        inside = [file for file in configurations if _home(file, roots) == root]
        inside = inside or _beside(root)
        found.controllers.append(_backup(root, mine, read_configuration(inside), found))
    loose = {file: content.sources for file, content in read.items() if _home(file, roots) is None}
    found.problems += [p for file in loose for p in read[file].problems]
    lists = [file for file in files if file.suffix.lower() == ".pgf"]
    _missing(lists, shown, found)
    outside = [file for file in configurations if _home(file, roots) is None]
    if not read:
        raise FileError(
            paths[0], f"has no modules: files that end with {', '.join(sorted(SUFFIXES))}"
        )
    if any(loose.values()):
        one_task = not any(path.is_dir() for path in paths)
        found.controllers += _loose(loose, outside, found, one_task)
    return found


def _files(path: Path) -> Iterator[Path]:
    if not path.is_dir():
        yield path
        return
    wanted = {*SUFFIXES, ".cfg", ".pgf"}
    for file in sorted(path.rglob("*")):
        hidden = any(part.startswith(".") for part in file.relative_to(path).parts)
        if file.suffix.lower() in wanted and file.is_file() and not hidden:
            yield file


def _is_module(file: Path) -> bool:
    return file.suffix.lower() not in (".cfg", ".pgf")


def _label(file: Path, paths: Sequence[Path]) -> str:
    for path in paths:
        if path.is_dir() and file.is_relative_to(path):
            return file.relative_to(path).as_posix()
    same = sum(other_path.name == file.name for other_path in paths)
    return file.name if same < 2 else file.as_posix()


@dataclass
class FileContents:
    """What a file has: its modules, and what is wrong in them."""

    sources: list[Source]
    problems: list[Problem]


def _read(file: Path, shown: str) -> FileContents:
    try:
        return FileContents(*read_modules(file, shown))
    except BadModule as error:
        return FileContents([], error.problems)


# -- backups


def _task_folder(file: Path) -> Path | None:
    """The folder of the task that a file of a backup belongs to."""
    folder = file.parent
    if folder.name.lower() in PLACES:
        return folder.parent
    return folder if TASK.fullmatch(folder.name) else None


def _root(file: Path) -> Path | None:
    task = _task_folder(file)
    if task is None:
        return None
    return next(
        (path.parent for path in (task, task.parent) if path.name.lower() == "rapid"), task.parent
    )


def _home(file: Path, roots: Sequence[Path]) -> Path | None:
    """The backup that a file belongs to: one of its folders, not whatever lies next to them."""
    for root in sorted(roots, key=lambda path: -len(path.parts)):
        if file.is_relative_to(root):
            top = file.relative_to(root).parts[0].lower()
            return root if top in FOLDERS or _task_folder(file) is not None else None
    return None


def _beside(root: Path) -> list[Path]:
    """The configuration of a backup of which only the programs were named."""
    folders = [path for path in root.iterdir() if path.is_dir() and path.name.lower() == "syspar"]
    return sorted(
        file for folder in folders for file in folder.iterdir() if file.suffix.lower() == ".cfg"
    )


def _backup(
    root: Path, read: dict[Path, FileContents], configuration: Configuration, found: FolderContents
) -> ControllerTasks:
    by_task: dict[Path, list[Source]] = {}
    others: dict[Path, FileContents] = {}
    for file, content in read.items():
        task = _task_folder(file)
        if task is not None:
            by_task.setdefault(task, []).extend(content.sources)
            found.problems += content.problems
        else:
            others[file] = content
    names = _names(root)
    tasks: list[TaskFiles] = []
    used: set[Path] = set()
    for folder, sources in sorted(by_task.items()):
        name, loaded = names.get(folder.name.upper(), (folder.name, None))
        if loaded:
            spare = [source for source in sources if Path(source.path).name.lower() not in loaded]
            found.spare += spare
            found.problems += [
                _remark(source, "the backup does not list it as loaded") for source in spare
            ]
            sources = [source for source in sources if source not in spare]
        for file in _list_loaded(configuration, name, others):
            known = {source.name.lower() for source in sources}
            new = [source for source in others[file].sources if source.name.lower() not in known]
            sources += new
            used |= {file} if new or not others[file].sources else set()
        entry = configuration.entries.get(name, "")
        tasks += [TaskFiles(name, ones, entry) for ones in _together(sources, found)]
    # Nobody loads the others: what is wrong in them is no mistake of a program.
    found.problems += [problem for file in used for problem in others[file].problems]
    found.spare += [
        source for file, it in others.items() if file not in used for source in it.sources
    ]
    configuration.tasks += [task.name for task in tasks if task.name not in configuration.tasks]
    return ControllerTasks(tasks, configuration)


def _list_loaded(mine: Configuration, task: str, files: Iterable[Path]) -> list[Path]:
    """Which files a configuration loads into a task."""
    found: list[Path] = []
    for wanted in (name for name, tasks in mine.modules.items() if not tasks or task in tasks):
        whole = [file for file in files if file.as_posix().lower().endswith(f"/{wanted}")]
        named = [file for file in files if file.name.lower() == wanted.rpartition("/")[2]]
        found += (whole or named)[:1]
    return found


def _together(sources: Sequence[Source], found: FolderContents) -> list[list[Source]]:
    """Modules that can share a task; a module that repeats many names is reported and set apart."""
    tasks: list[list[Source]] = [[]]
    for source in sources:
        mine = find_declared(source)
        for other in tasks[0]:
            both = sorted(mine & find_declared(other))
            if len(both) > MOST_NAMED:
                some = ", ".join(both[:3])
                what = f"{len(both)} names are declared in {other.path}, too ({some}, ...)"
                at = source.tree
                found.problems.append(Problem(source.path, at.line, at.column, what))
                tasks.append([source])
                break
        else:
            tasks[0].append(source)
    return tasks


def _names(root: Path) -> dict[str, tuple[str, set[str] | None]]:
    """Name of each task and files of the modules in it, by its folder, as the backup says."""
    names: dict[str, tuple[str, set[str] | None]] = {}
    for file in root.glob("*/backinfo.txt"):
        for folder, name, lines in BACKED_UP.findall(lines_of(read_whole(file, 1 << 20))):
            files = (
                re.split(r"[/\\]", line.split("@")[0].strip())[-1] for line in lines.split("\n")
            )
            names[folder] = (
                name or folder,
                {listed_file.lower() for listed_file in files if listed_file},
            )
    return names


# -- files that are no backup


def _loose(
    read: dict[Path, list[Source]],
    configurations: Sequence[Path],
    found: FolderContents,
    one_task: bool,
) -> list[ControllerTasks]:
    controllers: list[ControllerTasks] = []
    left = dict(read)
    all_of_them = read_configuration(configurations)
    for file in configurations:
        mine = read_configuration([file])
        tasks = [
            TaskFiles(
                name, [source for path in loaded for source in read[path]], mine.entries[name]
            )
            for name in mine.tasks
            if (loaded := _list_loaded(mine, name, read))
        ]
        if tasks:
            controllers.append(ControllerTasks(tasks, mine.with_(all_of_them)))
            for loaded_file in [
                loaded_file for name in mine.tasks for loaded_file in _list_loaded(mine, name, read)
            ]:
                left.pop(loaded_file, None)
    folders: dict[Path, list[Source]] = {}
    for file, sources in left.items():
        folders.setdefault(file.parent, []).extend(sources)
    if len(folders) == 1 and one_task and sum(map(_has_main, *folders.values())) < 2:
        (sources,) = folders.values()
        tasks = [TaskFiles("", sources, "main")]
    else:
        tasks = [task for task in _programs(folders, found) if task.sources]
    for task in tasks:
        controllers.append(ControllerTasks([task], all_of_them))
    return controllers


def _programs(folders: dict[Path, list[Source]], found: FolderContents) -> list[TaskFiles]:
    """Tasks of folders: each `main` with what its folder has, and with folders that have none."""
    tasks: list[TaskFiles] = []
    without = [sources for sources in folders.values() if not any(map(_has_main, sources))]
    for folder, sources in folders.items():
        mains = [source for source in sources if _has_main(source)]
        rest = [source for source in sources if source not in mains]
        mine = [TaskFiles(folder.name, [main]) for main in mains]
        for task in mine:
            _add(task, rest)
        left = [source for source in rest if not any(source in task.sources for task in mine)]
        while left and mains:
            extra = TaskFiles(folder.name, [])
            _add(extra, left)
            left = [source for source in left if source not in extra.sources]
            mine.append(extra)
        tasks += mine
    if not tasks:
        tasks = [TaskFiles("", [])]
    for sources in without:
        for task in tasks:
            _add(task, sources)
        left = [source for source in sources if not any(source in task.sources for task in tasks)]
        while left:
            extra = TaskFiles("", [])
            _add(extra, left)
            what = "other modules declare the same names: it is checked as another task"
            found.problems += [_remark(source, what) for source in extra.sources]
            left = [source for source in left if source not in extra.sources]
            tasks.append(extra)
    return tasks


def _remark(source: Source, what: str) -> Problem:
    return Problem(source.path, source.tree.line, source.tree.column, what, REMARK)


def _add(task: TaskFiles, sources: Sequence[Source]) -> None:
    names = {name for source in task.sources for name in find_declared(source)}
    for source in sources:
        mine = find_declared(source)
        if not mine & names:
            task.sources.append(source)
            names |= mine


def find_declared(source: Source) -> set[str]:
    """Names that a module declares for all others, in small letters, and its own."""
    names = {f"module {source.name.lower()}"}
    for node in source.tree.children:
        if type(node) is SyntaxTree and node.data != "place" and "local" not in words(node):
            names.add(str(parts(node)[1 if node.data in ("data", "func", "alias") else 0]).lower())
    return names


def _has_main(source: Source) -> bool:
    nodes = (
        child
        for child in source.tree.children
        if type(child) is SyntaxTree and child.data == "proc"
    )
    return any("local" not in words(node) and parts(node)[0].lower() == "main" for node in nodes)


def _missing(lists: Sequence[Path], shown: dict[Path, str], found: FolderContents) -> None:
    """Modules that a program's list names and its folder lacks."""
    for file in lists:
        there = {path.name.lower() for path in file.parent.iterdir()}
        for number, line in enumerate(lines_of(read_whole(file, 1 << 20)).split("\n"), start=1):
            for name in LISTED.findall(line):
                if re.split(r"[/\\]", name)[-1].lower() not in there:
                    what = f"{name} is not beside it"
                    found.problems.append(Problem(shown[file], number, 1, what))
