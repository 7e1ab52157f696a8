"""What holds for all tests."""

from collections import defaultdict
from collections.abc import Iterable

import pytest
from hypothesis import HealthCheck, settings

import workbench  # noqa: F401 - before NumPy is: it says which instructions that takes

# How long an example takes is a matter of the machine; what is slow shows in the benchmarks.
settings.register_profile("workbench", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("workbench")


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
