"""`workbench bench short`: the short form of every benchmark, beside the figures of last time."""

import json
import platform
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from statistics import median
from typing import Any

from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.bench import BenchShort
from workbench.cli.exits import FAILURE, SUCCESS
from workbench.cli.terminal import print_json, print_table, progress
from workbench.formats.files.json_keys import json_text, parse_object
from workbench.formats.files.toml_keys import LARGEST_FILE
from workbench.formats.files.whole_files import read_whole, write_whole
from workbench.model.errors import FileError

Figures = Mapping[str, float]
"""By name, which ends in its unit."""

LONGEST_BENCHMARK = 1800.0
"""[s] For one of them."""


@dataclass(frozen=True, slots=True)
class Short:
    """A benchmark in its short form, and the figures that are taken of what it says."""

    words: tuple[str, ...]
    figures: Callable[[Any], Figures]


def _of_pick(said: Any) -> Figures:
    return {f"{stage}, median ms": median(s) * 1000 for stage, s in said["seconds"].items() if s}


def _of_planners(said: Any) -> Figures:
    figures: dict[str, float] = {}
    for row in said["planners"]:
        name = f"{row['planner']} with {row['allowed']}"
        figures[f"{name}, success %"] = row["success"] * 100
        figures[f"{name}, mean ms"] = row["mean"] * 1000
    return figures


def _of_threshold(said: Any) -> Figures:
    figures: dict[str, float] = {}
    for row in said["thresholds"]:
        for kind in ("allowed", "coordinated", "alternated"):
            if row[f"{kind}_planning"] is not None:
                name = f"{kind} at {row['threshold'] * 1000:.0f} mm"
                figures[f"{name}, success %"] = row[f"{kind}_success"] * 100
                figures[f"{name}, median ms"] = row[f"{kind}_planning"]["median"] * 1000
    return figures


def _of_localization(said: Any) -> Figures:
    figures: dict[str, float] = {}
    for row in said["rows"]:
        name = f"{row['count']} of {row['part']}, {row['build']}"
        for key in ("precision", "recall"):
            if row[key] is not None:
                figures[f"{name}, {key} %"] = row[key] * 100
    return figures


def _of_page(said: Any) -> Figures:
    return {"typed to command, p95 ms": said["to_command_p95_ms"], "lost values": said["lost"]}


SHORT: Mapping[str, Short] = {
    "pick": Short(("bench", "pick", "--scenes", "20"), _of_pick),
    "planners": Short(("bench", "planners", "--targets", "60"), _of_planners),
    "threshold": Short(("study", "threshold", "--cycles", "20"), _of_threshold),
    "localization": Short(("study", "localization", "--scenes", "2"), _of_localization),
    "page": Short(("bench", "page", "--browsers", "4", "--seconds", "20"), _of_page),
}


def short(typed: BenchShort) -> int:
    """Run them one after the other; only an error fails, since times differ between machines."""
    before = _read_last(typed.against)
    now: dict[str, dict[str, float]] = {}
    failed: list[str] = []
    with progress("bench") as report:
        make_ready(report)
        for number, (name, benchmark) in enumerate(SHORT.items()):
            report(number / len(SHORT), name)
            said, problem = _run(benchmark.words)
            if problem:
                failed.append(f"{name}: {problem}")
            else:
                now[name] = {k: round(float(v), 2) for k, v in benchmark.figures(said).items()}
    result = {"machine": _machine(), "figures": now}
    if typed.keep and not failed:
        write_whole(typed.against, json_text(typed.against, result))
    if typed.json:
        print_json({"ok": not failed, "failed": failed, "before": dict(before), **result})
    else:
        _print(before, now, failed)
    return FAILURE if failed else SUCCESS


def _read_last(path: Path) -> Mapping[str, Any]:
    """The figures of last time; none when there is no file.

    Raises:
        FileError: it is a file of something else.
    """
    if not path.is_file():
        return {"figures": {}, "machine": ""}
    kept = parse_object(path, read_whole(path, LARGEST_FILE))
    figures: Any = kept.get("figures")
    if not isinstance(figures, dict) or "machine" not in kept:
        raise FileError(path, "holds no figures of the short benchmarks")
    return kept


def _run(words: tuple[str, ...]) -> tuple[Any, str]:
    """What a command says, or why it says nothing."""
    command = [sys.executable, "-m", "workbench", *words, "--json"]
    try:
        ended = subprocess.run(command, capture_output=True, text=True, timeout=LONGEST_BENCHMARK)
        if ended.returncode != 0:
            return None, f"ended with {ended.returncode}: {ended.stderr.strip()[-200:]}"
        return json.loads(ended.stdout), ""
    except subprocess.TimeoutExpired:
        return None, f"took longer than {LONGEST_BENCHMARK:.0f} s"
    except json.JSONDecodeError as error:
        return None, f"said no JSON: {error}"


def _machine() -> str:
    return f"{platform.machine()}, {platform.system()}, Python {platform.python_version()}"


def _print(
    before: Mapping[str, Any], now: Mapping[str, Mapping[str, float]], failed: list[str]
) -> None:
    rows: list[tuple[str, str, str, str]] = []
    for name, figures in now.items():
        known = before["figures"].get(name, {})
        for figure, value in figures.items():
            old = known.get(figure)
            was = "" if old is None else f"{old:,.1f}"
            change = "" if not old else f"{100 * (value / old - 1):+.0f} %"
            rows.append((f"{name}: {figure}", was, f"{value:,.1f}", change))
    title = f"Short forms; committed figures are of {before['machine'] or 'no machine yet'}"
    print_table(title, ("figure", "committed", "now", "change"), rows)
    for problem in failed:
        print(f"failed: {problem}")
