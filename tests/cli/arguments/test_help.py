"""The help of every command, word for word: what people read is part of the interface.

`WORKBENCH_GOLDEN=write pytest tests/cli/arguments/test_help.py` writes the files anew.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

from workbench.cli.main import main

GOLDEN = Path(__file__).resolve().parents[2] / "golden" / "help"

COMMANDS = (
    "serve",
    "demo",
    "plugins",
    "scan",
    "localize",
    "calibrate",
    "scanner",
    "plan",
    "explain",
    "prove",
    "verify",
    "send",
    "controller",
    "rapid",
    "export-world",
    "bench",
    "study",
    "cell",
    "part",
    "grasps",
    "import",
    "session",
    "user",
    "statistics",
    "evidence",
    "backup",
    "restore",
    "compile",
    "doctor",
)

NESTED = (
    ("bench", "planners"),
    ("bench", "motion"),
    ("bench", "pick"),
    ("bench", "soak"),
    ("bench", "page"),
    ("bench", "scale"),
    ("bench", "short"),
    ("study", "threshold"),
    ("study", "localization"),
    ("study", "emptying"),
    ("study", "placing"),
    ("study", "grips"),
    ("study", "bop"),
    ("cell", "new"),
    ("cell", "check"),
    ("cell", "show"),
    ("cell", "schema"),
    ("part", "import"),
    ("part", "check"),
    ("part", "list"),
    ("session", "list"),
    ("session", "show"),
    ("session", "verify"),
    ("session", "replay"),
    ("session", "open"),
    ("session", "export"),
    ("session", "import"),
    ("session", "cases"),
    ("session", "prune"),
    ("user", "add"),
    ("user", "list"),
    ("user", "disable"),
    ("user", "enable"),
    ("user", "password"),
    ("user", "role"),
    ("user", "remove"),
    ("user", "token"),
    ("user", "unlock"),
    ("opcua",),
    ("opcua", "certificate"),
    ("opcua", "trust"),
    ("opcua", "list"),
)


PLAIN = {"COLUMNS": "100", "TERM": "dumb", "NO_COLOR": "1"}


def tidied(said: str) -> str:
    return "\n".join(line.rstrip() for line in said.splitlines()).strip() + "\n"


def help_of(*words: str) -> str:
    """As a shell shows it: a process for each takes four times as long."""
    ended = subprocess.run(
        [sys.executable, "-m", "workbench", *words, "--help"],
        env={**os.environ, **PLAIN},
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    assert ended.stderr == ""
    return tidied(ended.stdout)


@pytest.fixture
def told(monkeypatch, capfd):
    """The help of a command that is called."""
    for name, value in PLAIN.items():
        monkeypatch.setenv(name, value)

    def tell(*words: str) -> str:
        with pytest.raises(SystemExit) as ended:
            main([*words, "--help"])
        said = capfd.readouterr()
        assert (ended.value.code, said.err) == (0, "")
        return tidied(said.out)

    return tell


@pytest.mark.parametrize(
    "words", [(), *((command,) for command in COMMANDS), *NESTED], ids=" ".join
)
def test_help_is_as_agreed(words, told):
    path = GOLDEN / f"{'-'.join(('workbench', *words))}.txt"
    said = told(*words)
    if os.environ.get("WORKBENCH_GOLDEN") == "write":
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(said, encoding="utf-8")
    assert said == path.read_text(encoding="utf-8")


@pytest.mark.parametrize("words", [(), ("plan",), ("cell", "new")], ids=" ".join)
def test_a_shell_is_told_the_same(words, told):
    assert help_of(*words) == told(*words)


def test_help_lists_every_command(told):
    listed = re.findall(r"• ([a-z-]+) ", told())
    assert set(COMMANDS) <= set(listed)


def test_help_loads_nothing_heavy():
    code = (
        "import sys; from workbench.cli.main import main\n"
        "try: main(['--help'])\n"
        "except SystemExit: pass\n"
        "print(sorted({'open3d', 'pinocchio', 'viser', 'mujoco', 'numba'} & set(sys.modules)))"
    )
    ended = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=600, check=True
    )
    assert ended.stdout.splitlines()[-1] == "[]"
