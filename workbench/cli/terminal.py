"""How commands speak: tables and JSON on standard output, progress on standard error."""

import json
import math
import os
import sys
import threading
import time
from collections.abc import Generator, Iterable
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table

from workbench.model.errors import InputError
from workbench.model.messages.message import Message
from workbench.plugins.progress import Report

LINE_EVERY = 15.0
"""[s] Between two lines about what takes long."""

FILE_COLUMNS = 120
"""Columns of a table that goes into a file or a pipe."""


@contextmanager
def progress(title: str) -> Generator[Report]:
    """A bar for as long as the block runs; a line now and then where errors go to no terminal.

    Such a line repeats the last report every `LINE_EVERY` s, so that a log shows that work goes on.
    """
    console = Console(stderr=True)
    if not console.is_terminal:
        with _lines(title) as said:
            yield said
        return
    columns = (TextColumn("{task.description}"), BarColumn(), TimeElapsedColumn())
    with Progress(*columns, console=console, transient=True) as bars:
        task = bars.add_task(title, total=1.0)

        def report(done: float, note: Message | str) -> None:
            bars.update(task, completed=done, description=f"{title}: {note}" if note else title)

        yield report


@contextmanager
def _lines(title: str) -> Generator[Report]:
    status, ended, began = [(0.0, "")], threading.Event(), time.monotonic()

    def print_progress() -> None:
        while not ended.wait(LINE_EVERY):
            done, note = status[0]
            so_far = f"{done:.0%} after {time.monotonic() - began:.0f} s"
            print(f"{title}: {note or 'at work'} ({so_far})", file=sys.stderr, flush=True)

    def report(done: float, note: Message | str) -> None:
        status[0] = done, str(note)

    teller = threading.Thread(target=print_progress, name="progress", daemon=True)
    teller.start()
    try:
        yield report
    finally:
        ended.set()
        teller.join()


def print_table(title: str, columns: Iterable[str], rows: Iterable[Iterable[str]]) -> None:
    """A table; columns whose name ends in `ms` or `mm` hold numbers and align right."""
    table = Table(title=title, title_justify="left")
    for column in columns:
        table.add_column(column, justify="right" if column.endswith(("ms", "mm")) else "left")
    for row in rows:
        table.add_row(*row)
    console = Console(markup=False, highlight=False)
    if not console.is_terminal:
        console.width = FILE_COLUMNS
    console.print(table)


def print_json(content: dict[str, Any]) -> None:
    """One JSON object on one line; messages in it as their English text."""
    print(json.dumps(content, allow_nan=False, default=_english), flush=True)


def _english(value: object) -> str:
    if isinstance(value, Message):
        return str(value)
    raise TypeError(f"{type(value).__name__} is nothing that JSON holds")


def check_whole(option: str, value: int, low: int, high: int) -> None:
    """Refuse a number that a command cannot work with.

    Raises:
        InputError: names the option and its range.
    """
    if not low <= value <= high:
        raise InputError(f"{option} must be a whole number from {low} to {high}, not {value}")


def check_number(option: str, value: float, low: float, high: float) -> None:
    """Refuse a number that is not finite or out of range.

    Raises:
        InputError: names the option and its range.
    """
    if not (math.isfinite(value) and low <= value <= high):
        raise InputError(f"{option} must lie between {low:g} and {high:g}, not {value}")


def split_option(option: str, typed: str, sign: str) -> tuple[str, str]:
    """The name and the value in one word.

    Raises:
        InputError: one of them is missing.
    """
    name, found, value = typed.partition(sign)
    if not name or not found:
        raise InputError(f"{option} {typed!r}: NAME{sign}VALUE is expected")
    return name, value


def milliseconds(seconds: float) -> float:
    """A time in milliseconds as people read it, to a tenth."""
    return round(seconds * 1000, 1)


def seconds_since_start() -> float:
    """How long this process has existed, the start of the interpreter included (Linux)."""
    # Field 22 of proc_pid_stat(5), counted after the name in parentheses, which may hold spaces.
    fields = Path("/proc/self/stat").read_text().rpartition(")")[2].split()
    started = int(fields[19]) / os.sysconf("SC_CLK_TCK")
    return time.clock_gettime(time.CLOCK_BOOTTIME) - started
