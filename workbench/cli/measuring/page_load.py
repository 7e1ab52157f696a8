"""`workbench bench page`: how the page holds with many browsers, in a process of its own."""

import asyncio
import json
import re
import secrets
import subprocess
import sys
import tempfile
from collections.abc import Generator
from contextlib import closing, contextmanager
from dataclasses import dataclass
from pathlib import Path
from statistics import median, quantiles
from typing import Any

from workbench.app.core.people import Role
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.nested import BenchPage
from workbench.cli.exits import FAILURE, SUCCESS
from workbench.cli.terminal import (
    check_number,
    check_whole,
    milliseconds,
    print_json,
    print_table,
    progress,
)
from workbench.gui.scene.slider_drag import REST
from workbench.journal.journal import Journal
from workbench.model.errors import LinkError
from workbench.studies.load.crowd import Load, load
from workbench.web.access.store import Store
from workbench.web.access.users import Users
from workbench.web.page.connections import MOST_OF_ONE

NAME = "bench"
COMMAND = "WantThreshold"
END_SECONDS = 30.0


@dataclass(frozen=True, slots=True)
class Served:
    """A page that is served by another process."""

    url: str
    process: int
    folder: Path

    @property
    def memory(self) -> float:
        """Of that process [MB], as the system counts it (proc_pid_status(5), VmRSS)."""
        status = Path(f"/proc/{self.process}/status").read_text()
        found = re.search(r"VmRSS:\s+(\d+) kB", status)
        return int(found[1]) / 1024 if found else 0.0


def page_load(typed: BenchPage) -> int:
    """Load a page and tell how it held; 1 when a value that was typed became no command."""
    check_whole("--browsers", typed.browsers, 1, MOST_OF_ONE)
    check_number("--seconds", typed.seconds, 1, 24 * 3600)
    password = secrets.token_urlsafe(16)
    with progress("page") as report:
        make_ready(report)
    with _served(typed.cell, password) as page:
        before = page.memory
        found = asyncio.run(load(page.url, NAME, password, typed.browsers, typed.seconds))
        after, folder = page.memory, page.folder
        delays = _delays(folder, found)
    lost = len(found.pressed) - len(delays)
    result = _form(found, delays, before, after, lost)
    if typed.json:
        print_json(result)
    else:
        rows = [(key.replace("_", " "), f"{value:,}") for key, value in result.items()]
        title = f"cell {typed.cell}, {typed.browsers} browsers, a plan scrubbed at 30 Hz"
        print_table(title, ("what", "value"), rows)
    return SUCCESS if lost == 0 and len(delays) > 1 else FAILURE


def _form(
    found: Load, delays: list[float], before: float, after: float, lost: int
) -> dict[str, Any]:
    spread = quantiles(delays, n=20) if len(delays) > 1 else [0.0]
    rates = sorted(frames / found.seconds for frames in found.frames)
    return {
        "seconds": round(found.seconds, 1),
        "typed": len(found.pressed),
        "lost": lost,
        "to_command_median_ms": milliseconds(median(delays)) if delays else 0.0,
        "to_command_p95_ms": milliseconds(spread[-1]),
        "frames_each_second_slowest": round(rates[0], 1),
        "frames_each_second_median": round(median(rates), 1),
        "kilobytes_each_second": round(median(found.size) / found.seconds / 1000, 1),
        "memory_before_MB": round(before, 1),
        "memory_after_MB": round(after, 1),
    }


def _delays(folder: Path, found: Load) -> list[float]:
    """From typing to the command that came of it [s]; both clocks are this machine's.

    Not counted is for how long the page waits whether it was the end of a drag.
    """
    (session,) = [path.parent for path in folder.glob("sessions/*/journal.sqlite")]
    with closing(Journal(session)) as journal:
        times = [
            float(json.loads(entry.body)["at"])
            for entry in journal.entries()
            if entry.kind == COMMAND
        ]
    return [at - pressed - REST for pressed, at in zip(found.pressed, times, strict=False)]


@contextmanager
def _served(cell: str, password: str) -> Generator[Served]:
    """`workbench serve` in a folder of its own, with one user."""
    named = Path(cell).resolve() if len(Path(cell).parts) > 1 else cell
    with tempfile.TemporaryDirectory(prefix="workbench-load-") as name:
        folder = Path(name)
        with closing(Store(folder / "users.sqlite")) as store:
            Users(store).add(NAME, Role.ENGINEER, password)
        words = ["serve", "--cell", str(named), "--port", "0", "--users", "users.sqlite"]
        process = subprocess.Popen(
            [sys.executable, "-m", "workbench", *words],
            cwd=folder,
            stdout=subprocess.PIPE,
            text=True,
        )
        try:
            line = process.stdout.readline() if process.stdout is not None else ""
            found = re.search(r"http://\S+", line)
            if found is None:
                raise LinkError(f"the page was not served: {line.strip() or 'it said nothing'}")
            yield Served(found[0], process.pid, folder)
        finally:
            process.terminate()
            try:
                process.communicate(timeout=END_SECONDS)
            except subprocess.TimeoutExpired:
                process.kill()
                process.communicate()
