"""`workbench bench page`: how the page holds with many browsers, in a process of its own."""

import asyncio
import json
import secrets
from contextlib import closing
from pathlib import Path
from statistics import median, quantiles
from typing import Any

from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.bench import BenchPage
from workbench.cli.exits import FAILURE, SUCCESS
from workbench.cli.measuring.page.page_process import PROCESS_NAME, serve_page, workplace
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
from workbench.studies.load.crowd import Load, load
from workbench.web.page.connections import MOST_OF_ONE

COMMAND = "WantThreshold"


def page_load(typed: BenchPage) -> int:
    """Load a page and tell how it held; 1 when a value that was typed became no command."""
    check_whole("--browsers", typed.browsers, 1, MOST_OF_ONE)
    check_number("--seconds", typed.seconds, 1, 24 * 3600)
    password = secrets.token_urlsafe(16)
    with progress("page") as report:
        make_ready(report)
    with workplace() as place, serve_page(place, typed.cell, password) as page:
        before = page.memory
        found = asyncio.run(load(page.url, PROCESS_NAME, password, typed.browsers, typed.seconds))
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
