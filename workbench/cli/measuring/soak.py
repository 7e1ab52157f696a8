"""`workbench bench soak`: very many cycles of the demo in a row; none may be lost, nothing grow."""

import contextlib
import json
import time
from collections import Counter
from dataclasses import dataclass, replace
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

from workbench.app.core.cycle.outcomes import AcknowledgeFault
from workbench.app.core.cycle.scanning import TakeScan
from workbench.app.core.cycle.sending import LinkEnded, SendPlan
from workbench.app.core.drop_back import ConfirmHandsEmpty
from workbench.app.core.hands import arms_that_may_hold
from workbench.app.core.state import Phase
from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.records.sessions import new_session
from workbench.app.runtime.bench import Bench
from workbench.app.runtime.effect_runner import EffectRunner
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.bench import BenchSoak
from workbench.cli.exits import FAILURE, SUCCESS
from workbench.cli.measuring.footprint import MEGABYTE, Footprint, footprint
from workbench.cli.measuring.result_cache import Recalled
from workbench.cli.serving.demo import ACTOR, Cycle, NoPlan, StageRow
from workbench.cli.serving.simulation import simulated_controller
from workbench.cli.terminal import (
    check_number,
    check_whole,
    milliseconds,
    print_json,
    print_table,
    progress,
)
from workbench.formats.cells.reading import read_cell
from workbench.journal.journal import Journal
from workbench.model.errors import WorkbenchError
from workbench.plugins.progress import silent

SETTLED = 0.2
"""Share of the cycles after which memory is expected to grow no more."""

CYCLES_A_ROW = 1000
"""Cycles between two rows of what was taken of the machine."""


@dataclass(frozen=True, slots=True)
class Sample:
    """One cycle: what became of it, how long it took [s], and what was taken afterwards."""

    end: str
    seconds: float
    after: Footprint


def soak(typed: BenchSoak) -> int:
    """Run the cycles; succeeds when none was lost and the journal is whole.

    Ctrl-C ends them early and prints the results until then.
    """
    check_whole("--cycles", typed.cycles, 1, 1_000_000)
    check_whole("--piles", typed.piles, 1, 10_000)
    check_number("--speed", typed.speed, 0.01, 1000)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - typed.piles)
    cell, goes_on = read_cell(typed.cell), typed.ahead
    if goes_on:
        cell = replace(cell, scanner=replace(cell.scanner, while_moving=True))
    samples: list[Sample] = []
    lost: list[str] = []
    with simulated_controller(
        typed.cell, cell.controller, speed=typed.speed, rapid=typed.rapid
    ) as controller:
        cell = replace(cell, controller=controller)
        with progress("soak") as report:
            make_ready(report)
        journal = new_session(typed.sessions, cell, time.time())
        bench = Bench(cell, journal, effects=Recalled if typed.recall else EffectRunner)
        try:
            with progress("soak") as report:
                for number in range(typed.cycles):
                    began = time.perf_counter()
                    seed, then = (typed.seed + k % typed.piles for k in (number, number + 1))
                    beside = then if goes_on and number + 1 < typed.cycles else None
                    end = _cycle(bench, number, seed, lost, beside)
                    seconds = time.perf_counter() - began
                    samples.append(Sample(end, seconds, footprint(journal.folder)))
                    report((number + 1) / typed.cycles, f"cycle {number + 1}, {end}")
        except KeyboardInterrupt:
            # What has been so far is worth telling, provided that something has.
            if not samples:
                raise
        finally:
            bench.close()
    form = _summary(samples, lost, journal.folder)
    if typed.json:
        print_json(form)
    else:
        _print(form)
    return SUCCESS if not lost and not form["problems"] else FAILURE


def _cycle(bench: Bench, number: int, seed: int, lost: list[str], then: int | None) -> str:
    """Run one cycle and tell in a word what became of it; why it was lost is added to `lost`.

    `then` is the seed of the pile that is continued beside it, None where nothing is.
    """
    rows: list[StageRow] = []
    try:
        Cycle(bench, number + 1, rows, silent).run(seed, then)
    except NoPlan:
        return "no plan"
    except WorkbenchError as error:
        lost.append(f"cycle {number + 1}, seed {seed}: {error}")
        if bench.state.phase is Phase.FAULT:
            bench.do(AcknowledgeFault(), ACTOR)
        if arms_that_may_hold(bench.state):
            bench.do(ConfirmHandsEmpty(), ACTOR)
        return "lost"
    return "done"


def _summary(samples: list[Sample], lost: list[str], folder: Path) -> dict[str, Any]:
    settled = samples[int(len(samples) * SETTLED) :]
    with contextlib.closing(Journal(folder)) as journal:
        entries, problems = journal.count, journal.verify()
        stood = _waiting_times(journal)
    seconds = sorted(sample.seconds for sample in samples)
    return {
        "cycles": len(samples),
        "ends": dict(Counter(sample.end for sample in samples)),
        "lost": lost,
        "median_ms": milliseconds(median(seconds)),
        "p95_ms": milliseconds(seconds[int(0.95 * (len(seconds) - 1))]),
        "stood_ms": milliseconds(median(stood)) if stood else None,
        "memory_mb": {
            name: {
                "first": _megabytes(settled[0], name),
                "last": _megabytes(samples[-1], name),
                "most": max(_megabytes(sample, name) for sample in samples),
                "growth_per_1000_cycles": _growth(settled, name),
            }
            for name in ("own", "others")
        },
        "every_1000_cycles": [_row(number, samples) for number in _row_ends(len(samples))],
        "entries": entries,
        "session": str(folder),
        "session_mb": _size(folder),
        "problems": list(problems),
    }


def _waiting_times(journal: Journal) -> list[float]:
    """How long the robot stood before each plan that went out straight after another one [s]."""
    ended, scans, found = 0.0, 0, list[float]()
    for row in journal.entries():
        if row.kind == TakeScan.__name__:
            scans += 1
        elif row.kind == LinkEnded.__name__:
            ended, scans = json.loads(row.body)["at"], 0
        elif row.kind == SendPlan.__name__ and ended and scans <= 1:
            # With more scans between, there was a pile without a plan.
            found.append(json.loads(row.body)["at"] - ended)
    return found


def _megabytes(sample: Sample, name: str) -> float:
    return round(getattr(sample.after, name) / MEGABYTE, 1)


def _row_ends(cycles: int) -> list[int]:
    """After how many cycles there is a row; the last one also where it is no round number."""
    return sorted({min(10, cycles), *range(CYCLES_A_ROW, cycles + 1, CYCLES_A_ROW), cycles})


def _row(cycles: int, samples: list[Sample]) -> dict[str, Any]:
    """What was taken after this many cycles, and the median of those since the row before."""
    after = samples[cycles - 1].after
    since = samples[(cycles - 1) // CYCLES_A_ROW * CYCLES_A_ROW : cycles]
    return {
        "cycles": cycles,
        "median_ms": milliseconds(median(sample.seconds for sample in since)),
        "own_mb": _megabytes(samples[cycles - 1], "own"),
        "others_mb": _megabytes(samples[cycles - 1], "others"),
        "files": after.files,
        "threads": after.threads,
        "journal_mb": _megabytes(samples[cycles - 1], "journal"),
    }


def _growth(samples: list[Sample], name: str) -> float | None:
    """Slope of a straight line through the memory of the cycles, in MB for 1,000 cycles."""
    if len(samples) < 2:
        return None
    memory = [getattr(sample.after, name) / MEGABYTE for sample in samples]
    return round(float(np.polyfit(np.arange(len(memory)), memory, 1)[0]) * 1000, 2)


def _size(folder: Path) -> float:
    content = sum(file.stat().st_size for file in folder.rglob("*") if file.is_file())
    return round(content / MEGABYTE, 1)


def _print(form: dict[str, Any]) -> None:
    ends = ", ".join(f"{count} {end}" for end, count in sorted(form["ends"].items()))
    print(f"{form['cycles']} cycles: {ends}")
    for line in form["lost"]:
        print(f"lost: {line}")
    print(f"a cycle: median {form['median_ms']:,} ms, 95 % within {form['p95_ms']:,} ms")
    if form["stood_ms"] is not None:
        print(f"the robot stood between two plans: median {form['stood_ms']:,} ms")
    print_table(
        "Resident memory, MB",
        ("of", f"after {SETTLED:.0%} of the cycles", "at the end", "most", "growth, 1,000 cycles"),
        [
            (who, *(str(form["memory_mb"][name][key]) for key in
                    ("first", "last", "most", "growth_per_1000_cycles")))
            for name, who in (("own", "this process"), ("others", "worker and controller"))
        ],
    )  # fmt: skip
    rows = form["every_1000_cycles"]
    print_table(
        "What was taken",
        ("cycles", "median ms", "own MB", "others MB", "files", "threads", "journal MB"),
        [tuple(f"{value:,}" for value in row.values()) for row in rows],
    )
    whole = "; ".join(form["problems"]) or "the journal is whole"
    print(
        f"session: {form['session']}, {form['entries']:,} entries, {form['session_mb']} MB; {whole}"
    )
