"""Our modules together with a customer's: names that clash, shared data, and what to do."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from workbench.formats.files.whole_files import is_file
from workbench.formats.rapid.backups.folders import (
    ControllerTasks,
    TaskFiles,
    find_declared,
    find_tasks,
)
from workbench.formats.rapid.declaring import Source
from workbench.formats.rapid.problems import Problem
from workbench.formats.rapid.setup import CONTROLLER_FILE, Setup, TaskSetup, read_setup
from workbench.formats.rapid.symbols import Node, parts, words
from workbench.formats.rapid.syntax.tokens import SyntaxTree

ENTRY = "main"


@dataclass
class Merged:
    """What comes of two programs on one controller.

    `clashes` keep it from loading; `steps` are to be done, each a sentence; `shared` are the
    persistents that both declare alike, and so have in common.
    """

    clashes: list[Problem] = field(default_factory=list[Problem])
    steps: list[str] = field(default_factory=list[str])
    shared: list[str] = field(default_factory=list[str])


def merge(paths: Sequence[Path], ours: Path) -> Merged:
    """Compare a customer's program with modules that have a `controller.toml`.

    Args:
        paths: the customer's folders and files.
        ours: folder of the modules that are added.

    Raises:
        FileError: a file is missing.
        BadModule: one of our modules is no RAPID.
    """
    setup, controllers, merged = read_setup(ours), _controllers(paths), Merged()
    theirs = {task.name.lower(): task for controller in controllers for task in controller.tasks}
    signals = {
        name.lower(): kind
        for controller in controllers
        for name, kind in controller.configuration.signals.items()
    }
    for name, task in setup.tasks.items():
        if name.lower() in theirs:
            _in_one_task(name, task, theirs[name.lower()], merged)
        else:
            modules = ", ".join(source.name for source in task.modules)
            merged.steps.append(f"Add the task {name} with the modules {modules}.")
    _persistents(setup, list(theirs.values()), merged)
    _outside(setup, signals, merged)
    return merged


def _controllers(paths: Sequence[Path]) -> list[ControllerTasks]:
    made = [read_setup(path).controller() for path in paths if is_file(path / CONTROLLER_FILE)]
    rest = [path for path in paths if not is_file(path / CONTROLLER_FILE)]
    return made + (find_tasks(rest).controllers if rest else [])


def _in_one_task(name: str, task: TaskSetup, theirs: TaskFiles, merged: Merged) -> None:
    modules = ", ".join(source.name for source in task.modules)
    merged.steps.append(f"Load the modules {modules} into the task {name}.")
    entry = theirs.entry or ENTRY
    taken = {
        declared_name: source
        for source in theirs.sources
        for declared_name in find_declared(source)
    }
    for source in task.modules:
        main = _routine(source, ENTRY)
        if main is not None:
            calls = ", ".join(_calls(main)) or ENTRY
            where = f" of {taken[entry.lower()].path}" if entry.lower() in taken else ""
            if ENTRY in taken:
                merged.steps.append(f"Leave PROC {ENTRY} out of {source.name}.")
            merged.steps.append(f"Call {calls} from PROC {entry}{where} in the task {name}.")
        for clash in sorted(find_declared(source) & set(taken) - {ENTRY}):
            at = source.tree
            what = f"{clash} is declared in {taken[clash].path}, too"
            merged.clashes.append(Problem(source.path, at.line, at.column, what))


def _routine(source: Source, name: str) -> Node | None:
    for node in source.tree.children:
        if type(node) is SyntaxTree and node.data == "proc" and parts(node)[0].lower() == name:
            return node
    return None


def _calls(routine: Node) -> Iterator[str]:
    """The procedures that a routine calls."""
    for node in routine.walk():
        if node.data == "call":
            yield str(node.children[0])


def _persistents(setup: Setup, theirs: Sequence[TaskFiles], merged: Merged) -> None:
    own = {name: rest for task in setup.tasks.values() for name, rest in _pers(task.modules)}
    other = {name: rest for task in theirs for name, rest in _pers(task.sources)}
    for name in sorted(set(own) & set(other)):
        source, node, kind = own[name]
        path, _, their_kind = other[name]
        if kind == their_kind:
            merged.shared.append(f"PERS {kind} {name}, in {source.path} and {path.path}")
        else:
            what = f"PERS {name} is a {kind}, and a {their_kind} in {path.path}"
            merged.clashes.append(Problem(source.path, node.line, node.column, what))


def _pers(sources: Sequence[Source]) -> Iterator[tuple[str, tuple[Source, Node, str]]]:
    """The persistents that all tasks share: name, and where, and of which type and dimensions."""
    for source in sources:
        for node in source.tree.children:
            if type(node) is not SyntaxTree or node.data != "data":
                continue
            if "pers" in words(node) and not words(node) & {"local", "task"}:
                kind, name, dims, _ = parts(node)
                stars = f"{{{','.join('*' * len(dims.children))}}}" if dims is not None else ""
                yield name.lower(), (source, node, f"{kind.lower()}{stars}")


def _outside(setup: Setup, signals: dict[str, str], merged: Merged) -> None:
    """What has to be configured: signals, and devices of EGM."""
    for name, what in setup.outputs.items():
        kind = signals.get(name.lower())
        if kind is None:
            of = " ".join(what)
            merged.steps.append(f"Configure the digital output {name} as system output {of}.")
        elif kind != "signaldo":
            where = "its EIO.cfg"
            merged.clashes.append(Problem(where, 1, 1, f"{name} is a {kind}, not a signaldo"))
    for name, (states, arm) in setup.devices.items():
        merged.steps.append(f"Configure the UDP Unicast Device {name}: {states} of the {arm} arm.")
