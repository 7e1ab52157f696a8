"""`workbench bench stalls`: what holds up the process with the page and the robot link."""

import asyncio
import json
import secrets
import shutil
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.bench import BenchStalls
from workbench.cli.exits import SUCCESS
from workbench.cli.measuring.page.page_process import PROCESS_NAME, Served, serve_page, workplace
from workbench.cli.terminal import check_whole, milliseconds, print_json, print_table, progress
from workbench.formats.cells.reading import cell_path, part_folders, read_cell
from workbench.model.cell import Cell
from workbench.plugins.progress import Report
from workbench.studies.stalls.actions import SETTLES, Files, doings, files_for
from workbench.studies.stalls.visit import visit

STALLS_FILE = "stalls.jsonl"


@dataclass(frozen=True, slots=True)
class StallRow:
    """What one doing came to: the stalls, the slowest answer [s], memory afterwards [MB]."""

    doing: str
    stalls: list[dict[str, Any]]
    slowest: float
    memory: float


def stalls(typed: BenchStalls) -> int:
    """Do everything once, and tell each stall with the line that held the others up."""
    check_whole("--triangles", typed.triangles, 1000, 1_000_000)
    check_whole("--points", typed.points, 1000, 10_000_000)
    cell, password = read_cell(typed.cell), secrets.token_urlsafe(16)
    with progress("stalls") as report, workplace() as place:
        make_ready(report)
        own = _own_cell(cell_path(typed.cell), cell, place)
        report(0.0, "large files")
        files = files_for(cell, typed.triangles, typed.points)
        with serve_page(place, str(own), password, "--stalls", STALLS_FILE) as page:
            rows = asyncio.run(_measure(page, password, files, report))
    form = [_form(row) for row in rows]
    if typed.json:
        print_json({"doings": form})
    else:
        _print(form)
    return SUCCESS


def _own_cell(path: Path, cell: Cell, place: Path) -> Path:
    """A copy of cell and parts that may be written to; the path of the cell's file."""
    for name, folder in part_folders(path, [part.name for part in cell.parts]).items():
        shutil.copytree(folder, place / "parts" / name)
    robot = place / "robots" / path.parent.name
    shutil.copytree(path.parent, robot)
    return robot / path.name


async def _measure(page: Served, password: str, files: Files, report: Report) -> list[StallRow]:
    rows: list[StallRow] = []
    figures = page.folder / STALLS_FILE
    async with visit(page.url, PROCESS_NAME, password, page.token) as visitor:
        todo = doings(files)
        for number, (name, does) in enumerate(todo.items()):
            report(number / len(todo), name)
            before = len(_lines(figures))
            visitor.slowest = 0.0
            await does(visitor)
            await asyncio.sleep(SETTLES)
            found = [json.loads(line) for line in _lines(figures)[before:]]
            rows.append(StallRow(name, found, visitor.slowest, page.memory))
    return rows


def _lines(file: Path) -> list[str]:
    return file.read_text(encoding="utf-8").splitlines() if file.is_file() else []


def _form(row: StallRow) -> dict[str, Any]:
    return {
        "doing": row.doing,
        "slowest_answer_ms": milliseconds(row.slowest),
        "memory_MB": round(row.memory),
        "stalls": [
            {
                "kind": stall["kind"],
                "ms": milliseconds(stall["seconds"]),
                "by_the_clock_ms": milliseconds(stall["lasted"]),
                "thread": stall["thread"],
                "where": stall["where"],
            }
            for stall in sorted(row.stalls, key=lambda stall: -stall["seconds"])
        ],
    }


def _print(form: list[dict[str, Any]]) -> None:
    rows = [
        (
            row["doing"],
            str(len(row["stalls"])),
            f"{row['stalls'][0]['ms']:,}" if row["stalls"] else "",
            f"{row['slowest_answer_ms']:,}",
            f"{row['memory_MB']:,}",
        )
        for row in form
    ]
    head = ("doing", "stalls", "longest, ms of processor time", "slowest answer, ms", "memory, MB")
    print_table("What held the page's process up for 50 ms or longer", head, rows)
    for row in form:
        for stall in row["stalls"]:
            print(
                f"{row['doing']}: {stall['kind']}, {stall['ms']:,} ms, {stall['thread']}: "
                + " < ".join(stall["where"][:6])
            )
