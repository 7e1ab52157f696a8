"""How a controller is configured: which modules are in which task, arms, system outputs.

`controller.toml` beside the modules says so: a table `[tasks.NAME]` with `modules`, and `arm` of
the cell if the task moves one; `[outputs]`, each a list: `Emergency Stop`, or `Task Executing` and
the task; and, where EGM is used, `[devices]` of UDP, each `motion` or `states`, and the arm.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from workbench.formats.files.toml_keys import read_toml
from workbench.formats.rapid.backups.cfg import Configuration
from workbench.formats.rapid.backups.files import read_modules
from workbench.formats.rapid.backups.folders import ControllerTasks, TaskFiles
from workbench.formats.rapid.declaring import Source
from workbench.formats.rapid.problems import BadModule
from workbench.model.errors import FileError

CONTROLLER_FILE = "controller.toml"


@dataclass(frozen=True)
class TaskSetup:
    """A task: the modules in it, and the arm of the cell that it moves."""

    modules: Sequence[Source]
    arm: str = ""


@dataclass(frozen=True)
class Setup:
    """All tasks, and the system outputs: `Emergency Stop`, or `Task Executing` and a task.

    `devices` of EGM: by name `motion` or `states`, and the arm.
    """

    tasks: Mapping[str, TaskSetup]
    outputs: Mapping[str, tuple[str, ...]]
    devices: Mapping[str, tuple[str, ...]] = field(default_factory=dict[str, tuple[str, ...]])

    def controller(self) -> ControllerTasks:
        """The same as a check takes it: each task begins at main."""
        tasks = [TaskFiles(name, list(task.modules), "main") for name, task in self.tasks.items()]
        signals = dict.fromkeys(self.outputs, "signaldo")
        return ControllerTasks(tasks, Configuration(signals))


def _read_module(path: Path) -> Source:
    """The only module of a file, whatever its encoding.

    Raises:
        FileError: there is no such file, or it is too large.
        BadModule: it is no RAPID.
    """
    sources, problems = read_modules(path, path.name)
    if problems:
        raise BadModule(problems)
    return sources[0]


def read_setup(folder: Path) -> Setup:
    """The configuration in a folder, with its modules.

    Raises:
        FileError: a file is missing, or a key is not right.
        BadModule: a module is no RAPID.
    """
    table = read_toml(folder / CONTROLLER_FILE)
    rows, outputs = table.table("tasks"), table.table("outputs")
    sources: dict[str, Source] = {}
    tasks: dict[str, TaskSetup] = {}
    for name in rows.names():
        row = rows.table(name)
        modules: list[Source] = []
        for module in row.texts("modules"):
            if module not in sources:
                sources[module] = _read_module(folder / f"{module}.mod")
            modules.append(sources[module])
        tasks[name] = TaskSetup(modules, row.text("arm", "", empty=True))
        row.finish()
    if not tasks:
        raise FileError(folder / CONTROLLER_FILE, "has no tasks")
    found = {name: outputs.texts(name) for name in outputs.names()}
    devices = table.table("devices") if table.has("devices") else None
    ports = {name: devices.texts(name) for name in devices.names()} if devices else {}
    table.finish()
    return Setup(tasks, found, ports)
