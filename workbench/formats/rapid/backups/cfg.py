"""Configuration of a controller: signals, mechanical units, tasks and their modules.

Files of `SYSPAR` in a backup: `EIO.cfg`, `MOC.cfg`, `SYS.cfg`.  Each has sections, `NAME:`, of
instances, `-Name "x" -Key value`; a backslash at the end of a line continues it.
"""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from workbench.formats.files.whole_files import read_whole
from workbench.formats.rapid.backups.files import lines_of

LARGEST_FILE = 16 << 20
"""[bytes]"""

SECTION = re.compile(r"([A-Z]\w*):\s*")
PAIR = re.compile(r'-([A-Za-z]\w*)(?:\s+("[^"]*"|-?[\d.][^\s]*|[^\s"-][^\s]*))?')

SIGNALS = {
    "DI": "signaldi", "DO": "signaldo", "AI": "signalai", "AO": "signalao", "GI": "signalgi",
    "GO": "signalgo",
}  # fmt: skip


@dataclass
class Configuration:
    """What a configuration says that programs name.

    `signals` are the types of signals by their names; `modules` are files, by their path behind
    `HOME:` in small letters, and the tasks that load them, none for all; `entries` are where tasks
    begin.
    """

    signals: dict[str, str] = field(default_factory=dict[str, str])
    units: list[str] = field(default_factory=list[str])
    tasks: list[str] = field(default_factory=list[str])
    entries: dict[str, str] = field(default_factory=dict[str, str])
    modules: dict[str, set[str]] = field(default_factory=dict[str, set[str]])

    def names(self) -> dict[str, str]:
        """Types of all data that it brings into programs, by their names."""
        units = dict.fromkeys(self.units, "mecunit")
        return {**units, **{f"{task}Id": "taskid" for task in self.tasks}, **self.signals}

    def with_(self, other: "Configuration") -> "Configuration":
        """Both of two."""
        return Configuration(
            {**self.signals, **other.signals},
            [*self.units, *other.units],
            [*self.tasks, *(task for task in other.tasks if task not in self.tasks)],
            {**self.entries, **other.entries},
            {**self.modules, **other.modules},
        )


def read_configuration(paths: Sequence[Path]) -> Configuration:
    """What files of a configuration say together.

    Raises:
        FileError: a file is missing.
    """
    found = Configuration()
    for path in paths:
        for section, instance in instances(lines_of(read_whole(path, LARGEST_FILE))):
            _take(found, section, instance)
    return found


def _take(found: Configuration, section: str, instance: dict[str, str]) -> None:
    name = instance.get("name", "")
    if section == "EIO_SIGNAL" and name:
        kind = instance.get("signaltype", instance.get("type", "")).upper()
        found.signals[name] = SIGNALS.get(kind, "")
    elif section == "MECHANICAL_UNIT" and name:
        found.units.append(name)
    elif section == "CAB_TASKS" and name:
        found.tasks.append(name)
        found.entries[name] = instance.get("entry", "") or "main"
    elif section == "CAB_TASK_MODULES" and instance.get("file"):
        file = instance["file"].replace("\\", "/").partition(":")[2].strip("/").lower()
        tasks = {instance["task"]} if instance.get("task") else set[str]()
        if "alltask" in instance or "shared" in instance:
            tasks = set()
        known = found.modules.setdefault(file, set(tasks))
        known |= tasks


def instances(text: str) -> Iterator[tuple[str, dict[str, str]]]:
    """Each instance of a configuration with its section; keys in small letters."""
    section = ""
    for line in re.sub(r"\\[ \t]*\n", " ", text).split("\n"):
        line = line.strip()
        named = SECTION.fullmatch(line)
        if named is not None:
            section = named[1].upper()
        elif line.startswith("-"):
            pairs = PAIR.findall(line)
            yield section, {key.lower(): value.strip('"') for key, value in pairs}
