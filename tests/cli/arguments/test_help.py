"""The help of every command, word for word: what people read is part of the interface.

`WORKBENCH_GOLDEN=write pytest tests/cli/arguments/test_help.py` writes the files anew.
"""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

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
    ("bench", "short"),
    ("study", "threshold"),
    ("study", "localization"),
    ("study", "emptying"),
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


def help_of(*words: str) -> str:
    plain = {"COLUMNS": "100", "TERM": "dumb", "NO_COLOR": "1"}
    ended = subprocess.run(
        [sys.executable, "-m", "workbench", *words, "--help"],
        env={**os.environ, **plain},
        capture_output=True,
        text=True,
        timeout=600,
        check=True,
    )
    assert ended.stderr == ""
    return "\n".join(line.rstrip() for line in ended.stdout.splitlines()).strip() + "\n"


@pytest.mark.parametrize(
    "words", [(), *((command,) for command in COMMANDS), *NESTED], ids=" ".join
)
def test_help_is_as_agreed(words):
    path = GOLDEN / f"{'-'.join(('workbench', *words))}.txt"
    said = help_of(*words)
    if os.environ.get("WORKBENCH_GOLDEN") == "write":
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(said, encoding="utf-8")
    assert said == path.read_text(encoding="utf-8")


def test_help_lists_every_command():
    listed = re.findall(r"• ([a-z-]+) ", help_of())
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
