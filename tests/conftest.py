"""What holds for all tests."""

from collections import defaultdict
from collections.abc import Iterable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import workbench  # noqa: F401 - before NumPy is: it says which instructions that takes

# How long an example takes is a matter of the machine; what is slow shows in the benchmarks.
settings.register_profile("workbench", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("workbench")


HERE = Path(__file__).parent

LONGEST = (
    "packaging",
    "browser",
    "portable",
    "web/opcua",
    "examples",
    "test_new_part.py",
    "test_new_robot.py",
    "cli/authoring/test_calibrate.py",
    "testing",
    "perception/scene/test_seen_obstacles.py",
    "gui/drawing/test_watching.py",
    "cli/test_line.py",
    "app/core/test_any_sequence.py",
    "planning/picking/test_golden_plans.py",
)
"""Folders and files that take more than a minute in all: begun first, so that at the end of a run
no worker waits for another one that has just begun with one of them."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put what takes longest first; the rest stays in its order, and files stay whole."""
    items.sort(key=lambda item: place_in_line(item.path))


def place_in_line(path: Path) -> int:
    """Where a file of tests comes in a run: its place in `LONGEST`, or behind all of them."""
    within = [k for k, long in enumerate(LONGEST) if path.is_relative_to(HERE / long)]
    return within[0] if within else len(LONGEST)


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """List every skip by its reason; what workers of xdist report comes in here as well."""
    lines = skips(terminalreporter.stats.get("skipped", []))
    if lines:
        terminalreporter.section("skipped, and why")
    for line in lines:
        terminalreporter.write_line(line)


def skips(reports: Iterable[pytest.TestReport | pytest.CollectReport]) -> list[str]:
    """For each reason a line with the number of tests, then these tests."""
    by_reason: dict[str, list[str]] = defaultdict(list)
    for report in reports:
        told = report.longrepr
        reason = str(told[2]) if isinstance(told, tuple) else str(told or "no reason was given")
        by_reason[reason.removeprefix("Skipped: ")].append(report.nodeid)
    lines: list[str] = []
    for reason, tests in sorted(by_reason.items()):
        lines.append(f"{len(tests)}: {reason}")
        lines += [f"    {test}" for test in sorted(tests)]
    return lines
