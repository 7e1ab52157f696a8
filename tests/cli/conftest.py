"""Files as the commands leave them, made once, and a controller in a process of its own."""

import json
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from waiting import PATIENCE

from workbench.cli.main import main
from workbench.formats.plans.plan_files import read_plan


@dataclass(frozen=True)
class Line:
    """The files from scan to plan."""

    scan: Path
    truth: Path
    poses: Path
    plan: Path


@dataclass(frozen=True)
class Robot:
    """A simulated controller that is running, and what has arrived at it."""

    port: int
    state_port: int
    record: Path

    @property
    def arrived(self) -> list[dict]:
        return [json.loads(line) for line in self.record.read_text().splitlines()]


@dataclass(frozen=True)
class Said:
    """What a command came to."""

    code: int
    out: str
    err: str

    @property
    def problem(self) -> str:
        """The one line on standard error, which is no traceback."""
        lines = self.err.splitlines()
        assert len(lines) == 1, self.err
        assert lines[0].startswith("workbench: ")
        return lines[0].removeprefix("workbench: ")


@pytest.fixture
def say(capfd: pytest.CaptureFixture[str]) -> Callable[..., Said]:
    """Give a command, as if typed."""

    def typed(*words: object) -> Said:
        capfd.readouterr()
        code = main([str(word) for word in words])
        return Said(code, *capfd.readouterr())

    return typed


@pytest.fixture(scope="session")
def line(tmp_path_factory: pytest.TempPathFactory) -> Line:
    folder = tmp_path_factory.mktemp("line")
    files = Line(*(folder / name for name in ("scan.ply", "truth.json", "poses.json", "plan.json")))
    truth = ["--truth", str(files.truth)]
    assert main(["scan", "yumi", "--out", str(files.scan), "--seed", "1", *truth]) == 0
    assert main(["localize", "yumi", "--scan", str(files.scan), "--out", str(files.poses)]) == 0
    assert main(["plan", "yumi", "--poses", str(files.poses), "--out", str(files.plan)]) == 0
    return files


@pytest.fixture
def robot(tmp_path: Path) -> Iterator[Robot]:
    record = tmp_path / "arrived.jsonl"
    options = ["--port", "0", "--state-port", "0", "--speed", "50", "--until-eof", "--json"]
    process = subprocess.Popen(
        [sys.executable, "-m", "workbench", "controller", *options, "--record", str(record)],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        stderr=subprocess.DEVNULL,
        text=True,
    )
    ports = json.loads(process.stdout.readline())
    yield Robot(ports["port"], ports["state_port"], record)
    process.stdin.close()
    assert process.wait(timeout=PATIENCE) == 0
    process.stdout.close()


@pytest.fixture
def send(say: Callable[..., Said], tmp_path: Path) -> Callable[..., Said]:
    """Send a plan as a script does: read it first, then give its digest."""

    def typed(plan: Path, *words: object) -> Said:
        words = (plan, *words, "--approve-as", "Ada", "--record", tmp_path / "approvals")
        assert say("send", *words).code == 2, "nobody has approved yet"
        return say("send", *words, "--digest", read_plan(plan)[0].digest[:12])

    return typed
