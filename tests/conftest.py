"""What holds for all tests."""

import ctypes
import gc
import os
import platform
import shutil
from collections import defaultdict
from collections.abc import Generator, Iterable
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

import workbench  # noqa: F401 - before NumPy is: it says which instructions that takes
from workbench.cli import terminal
from workbench.formats.files.shipped import find

# How long an example takes is a matter of the machine; what is slow shows in the benchmarks.
settings.register_profile("workbench", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("workbench")

# As the command line does: piles fall unseen.
os.environ.setdefault("MUJOCO_GL", "disable")

M_TRIM_THRESHOLD, M_MMAP_MAX = -1, -4
"""Of malloc.h."""

if platform.libc_ver()[0] == "glibc":
    # Large arrays come and go, and each new page of memory is the system's work: two fifths of what
    # tests of scans with millions of points took.  So up to a gigabyte that is free is kept.
    ctypes.CDLL(None).mallopt(M_MMAP_MAX, 0)
    ctypes.CDLL(None).mallopt(M_TRIM_THRESHOLD, 2**30)

# A busy machine would have commands print that they are still at work, among what tests read.
terminal.LINE_EVERY = 3600.0

HERE = Path(__file__).parent


@pytest.fixture
def cell_file(tmp_path: Path) -> Path:
    """A copy of the shipped YuMi's cell file, which a test may write to."""
    return Path(shutil.copytree(find("robots", "yumi"), tmp_path / "yumi")) / "cell.toml"


LONGEST = (
    "packaging",
    "browser/test_page.py",
    "portable",
    "browser/test_watching.py",
    "extras/opcua",
    "browser/test_grasps_tab.py",
    "examples",
    "browser/test_cell_tab.py",
    "test_new_part.py",
    "browser/test_calibration_tab.py",
    "test_new_robot.py",
    "browser/test_control.py",
    "perception/scene/test_seen_obstacles.py",
    "browser",
    "testing",
    "cli/calibrating/test_calibrate.py",
    "gui/drawing/test_watching.py",
    "robots/test_third_party.py",
    "cli/test_line.py",
    "app/core/test_any_sequence.py",
    "planning/picking/test_golden_plans.py",
)
"""Folders and files that take longest: begun first, so that at the end of a run no worker waits for
another one that has just begun with one of them.  Browsers, which wait much and draw with a
priority of their own, take turns with what computes."""

COUNTED = (
    "model/",
    "formats/",
    "planning/",
    "proof/",
    "devices/",
    "journal/",
    "app/",
    "extras/bop/",
    "extras/evidence/",
    "extras/genicam/",
    "extras/klampt/",
    "extras/mcap/",
    "extras/realsense/",
    "extras/reconstruction/",
)
"""Tests whose lines are counted by `--cov`: those of the layers that are counted (pyproject.toml).
The others pass through these layers too, in half the time when nobody counts, and what only they
reach is not tested where it should be."""

TRIED_OFTEN = ("test_any_sequence.py",)
"""Not counted either, like whatever Hypothesis thinks up cases for: the same lines again and again,
which take twice as long when somebody counts."""


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Leave what is imported and collected, a million objects, out of every search for garbage.

    Nothing of it ever is, and searching it took tests a third of their time.
    """
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


def pytest_unconfigure() -> None:
    """Let what is imported go: compiled libraries tell of what is left when a process ends."""
    gc.unfreeze()


@pytest.hookimpl(trylast=True)  # behind Hypothesis, which marks its own
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put what takes longest first, files staying whole, and have only some of it counted."""
    # Once for a file: there are ten times as many tests.
    names = {path: path.relative_to(HERE).as_posix() for path in {item.path for item in items}}
    places = {path: place_in_line(name) for path, name in names.items()}
    items.sort(key=lambda item: places[item.path])
    for item in items:
        is_counted = names[item.path].startswith(COUNTED) and item.path.name not in TRIED_OFTEN
        if not is_counted or item.get_closest_marker("hypothesis") is not None:
            item.add_marker("no_cover")


def place_in_line(name: str) -> int:
    """Where a file of tests comes in a run: its place in `LONGEST`, or behind all of them."""
    within = [k for k, long in enumerate(LONGEST) if f"{name}/".startswith(f"{long}/")]
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
