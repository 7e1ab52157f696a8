"""`workbench bench scale`: what grows faster than the library, the bin, the session or the page."""

import asyncio
import math
import secrets
import time
from collections.abc import Callable, Generator, Mapping, Sequence
from contextlib import closing, contextmanager
from dataclasses import replace
from pathlib import Path

from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.readiness import make_ready
from workbench.app.statistics.statistics import Statistics
from workbench.cli.arguments.bench import BenchScale
from workbench.cli.exits import SUCCESS
from workbench.cli.measuring.page.page_process import PROCESS_NAME, serve_page, workplace
from workbench.cli.serving.demo import Cycle
from workbench.cli.serving.simulation import simulated_controller
from workbench.cli.sessions.inspecting import summarize_session
from workbench.cli.terminal import check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.formats.files.shipped import find
from workbench.journal.journal import Journal
from workbench.plugins.extras import from_extra
from workbench.plugins.progress import Report, silent
from workbench.studies.scale.bins import measure_bin
from workbench.studies.scale.browsers import PageProcess, measure_arrival, measure_browsers
from workbench.studies.scale.growth import (
    Costs,
    Growth,
    form,
    growths,
    processor_seconds,
    seconds_and_megabytes,
)
from workbench.studies.scale.library import measure_library, write_library
from workbench.studies.scale.session import MS, SessionWriter, measure_session

CELL = "yumi"
"""The cell of all but the bin."""

LARGE_BIN = "tx2_90", "full_bin.toml"
"""Folder and file of the cell whose bin has room for many parts."""

KILOBYTE = 1000.0

SPEED = 1000.0
"""Of the simulated robot: 1 is real time."""

CYCLES = 2
"""That are recorded; the last is what follows a cycle that has ended, again and again."""


def scale(typed: BenchScale) -> int:
    """Measure each subject at its sizes, and print the costs and how they grow."""
    sizes = {
        "library": ("kinds of parts", typed.kinds, _measure_library),
        "bin": ("parts in the bin", typed.parts, _measure_bin),
        "session": ("entries", typed.entries, _measure_sessions),
        "browsers": ("browsers", typed.browsers, _measure_browsers),
    }
    found: list[Growth] = []
    with progress("scale") as report:
        make_ready(report)
        for of in typed.of:
            subject, counts, measure = sizes[of]
            for count in counts:
                check_whole(f"--{of}", count, 1, 10_000_000)
            found += growths(subject, measure(sorted(set(counts)), report))
    if typed.json:
        print_json({"growth": [form(growth) for growth in found]})
    else:
        for subject in dict.fromkeys(growth.subject for growth in found):
            _print(subject, [growth for growth in found if growth.subject == subject])
    return SUCCESS


def _measure_library(counts: Sequence[int], report: Report) -> Mapping[int, Costs]:
    costs: dict[int, Costs] = {}
    for count in counts:
        report(0.0, f"a library of {count} kinds of parts")
        with workplace() as place:
            cell = write_library(place / "library", CELL, count)
            with _page(place, str(cell)) as (page, password):
                arrival = asyncio.run(measure_arrival(page, PROCESS_NAME, password))
            costs[count] = {**measure_library(cell), **arrival}
    return costs


def _measure_bin(counts: Sequence[int], report: Report) -> Mapping[int, Costs]:
    # The page takes its time to import.
    from workbench.gui.page.recording import scene_html

    cell, costs = read_cell(find("robots", LARGE_BIN[0]) / LARGE_BIN[1]), dict[int, Costs]()
    for count in counts:
        report(0.0, f"a bin with {count} parts")
        measured, state = measure_bin(cell, count)
        # Without the film of the plan, which is as long as the plan.
        state = replace(state, plan=None, proof=None)
        drawn = processor_seconds(lambda state=state: scene_html(state))
        size = len(scene_html(state)) / KILOBYTE
        costs[count] = {**measured, "draw the scene, s": drawn, "the scene, kB": size}
    return costs


def _measure_sessions(counts: Sequence[int], report: Report) -> Mapping[int, Costs]:
    # The page takes its time to import.
    from workbench.gui.statistics.panel import stage_curves
    from workbench.gui.statistics.views import statistics_html

    write_bundle: Callable[..., object] = from_extra("evidence.bundle:write_bundle")

    def others(journal: Journal, counted: Statistics, place: Path) -> Costs:
        seconds, memory = seconds_and_megabytes(
            lambda: write_bundle(journal, place / "evidence.zip", 0.0)
        )
        tab = statistics_html(counted), stage_curves(counted.cycles)
        return {
            "a row of the list, ms": MS
            * processor_seconds(lambda: summarize_session(journal.folder)),
            "export as evidence, s": seconds,
            "export as evidence, MB of memory": memory,
            "tab Statistics, ms": MS
            * processor_seconds(lambda: (statistics_html(counted), stage_curves(counted.cycles))),
            "tab Statistics, kB": sum(map(len, tab)) / KILOBYTE,
        }

    costs: dict[int, Costs] = {}
    with workplace() as place, closing(_record_cycles(place, report)) as recorded:
        writer = SessionWriter(recorded, place / "long")
        for count in counts:
            report(0.0, f"a session of {count} entries")
            costs[count] = measure_session(writer, count, others)
        writer.journal.close()
    return costs


def _record_cycles(place: Path, report: Report) -> Journal:
    """The journal of whole cycles with one pile of the demo."""
    report(0.0, "recording a cycle")
    cell = read_cell(CELL)
    with simulated_controller(CELL, cell.controller, speed=SPEED) as controller:
        cell = replace(cell, controller=controller)
        bench = Bench(cell, new_session(place, cell, time.time()))
        try:
            for number in range(CYCLES):
                Cycle(bench, number + 1, [], silent).run(0)
            folder = bench.folder
        finally:
            bench.close()
    return Journal(folder)


def _measure_browsers(counts: Sequence[int], report: Report) -> Mapping[int, Costs]:
    costs: dict[int, Costs] = {}
    for count in counts:
        report(0.0, f"{count} browsers")
        with workplace() as place, _page(place, CELL) as (page, password):
            costs[count] = asyncio.run(measure_browsers(page, PROCESS_NAME, password, count))
    return costs


@contextmanager
def _page(place: Path, cell: str) -> Generator[tuple[PageProcess, str]]:
    """A page in a process of its own, and the password of its user."""
    password = secrets.token_urlsafe(16)
    with serve_page(place, cell, password) as served:
        yield PageProcess(served.url, served.process, lambda: served.memory), password


def _print(subject: str, found: Sequence[Growth]) -> None:
    sizes = found[0].sizes
    columns = ("step", *(f"{size:,}" for size in sizes), *("exponent" for _ in sizes[1:]))
    rows = [
        (
            growth.step,
            *(f"{cost:,.4g}" for cost in growth.costs),
            *("" if math.isnan(each) else f"{each:.2f}" for each in growth.exponents),
        )
        for growth in found
    ]
    print_table(f"Growth with the number of {subject}", columns, rows)
