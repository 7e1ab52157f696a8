"""`workbench scanner drift`: whether the scanner hangs where it was calibrated, by sessions."""

import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

import numpy as np

from workbench.app.calibration.drift_words import at_corners, drift_words
from workbench.app.review.scanner_drift import RecordedDrift, recorded_drift, refined_cell
from workbench.cli.arguments import scanner as arguments
from workbench.cli.exits import SUCCESS
from workbench.cli.sessions.statistics import sessions_below
from workbench.cli.terminal import print_json, print_table, progress
from workbench.formats.cells.edits import log_change, save_cell
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.model.cell import Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.perception.calibration.drift import DAY, DriftHistory

TO_MM_AND_DEGREES = np.array([1000.0] * 3 + [180 / np.pi] * 3)
"""Metres and radians in millimetres and degrees."""

AXIS_NAMES = ("x mm", "y mm", "z mm", "about x deg", "about y deg", "about z deg")


def drift(typed: arguments.ScannerDrift) -> int:
    """Look through the sessions, say what they show, and save what is proposed if asked to."""
    cell = read_cell(typed.cell)
    if typed.save and not typed.by.strip():
        raise InputError("--save needs --by NAME: who answers for the scanner's pose")
    folders = typed.sessions or sessions_below(Path("sessions"))
    with progress("drift") as report:
        found = recorded_drift(folders, cell, report)
    if typed.json:
        print_json(_form(cell, found))
    else:
        _print(cell, found)
    if typed.save:
        at, path = time.time(), cell_path(typed.cell)
        save_cell(path, refined_cell(cell, found.drift, at, typed.by))
        says = f"scanner's pose by {found.scans} recorded scans, {found.drift.parts} parts put down"
        log_change(path, read_cell(path), typed.by, at, says)
        if not typed.json:
            print(f"saved into {path}")
    return SUCCESS


def _print(cell: Cell, found: RecordedDrift) -> None:
    for problem in found.problems:
        print(f"left out: {problem}")
    print(f"{found.sessions} sessions, {found.scans} scans looked at since the calibration")
    for course in found.drift.courses:
        rows = [
            (_date(day), *_format(moved))
            for day, moved in zip(course.days.tolist(), course.moved, strict=True)
        ]
        rows.append(("change", *_format(course.change)))
        rows.append(("deviation", *_format(course.deviation)))
        marks = ("told" if is_significant else "" for is_significant in course.is_significant)
        print_table(
            f"Where {course.thing} has the scanner, "
            "from where the cell has it, at the bin's middle",
            ("day", *AXIS_NAMES),
            [*rows, ("", *marks)],
        )
    for sentence in drift_words(cell, found.drift):
        print(f"- {sentence}")


def _form(cell: Cell, found: RecordedDrift) -> dict[str, Any]:
    drift = found.drift
    return {
        "ok": True,
        "sessions": found.sessions,
        "scans": found.scans,
        "left_out": list(found.problems),
        "things": [_course_form(cell, course) for course in drift.courses],
        "drifted": list(drift.drifted),
        "is_bin_off": drift.is_bin_off,
        "open": list(drift.open),
        "parts": drift.parts,
        "moved_mm_deg": None if drift.moved is None else _numbers(drift.moved),
        "covariance": None if drift.covariance is None else drift.covariance.tolist(),
        "says": list(map(str, drift_words(cell, drift))),
    }


def _course_form(cell: Cell, course: DriftHistory) -> dict[str, Any]:
    return {
        "thing": course.thing,
        "days": [_date(day) for day in course.days.tolist()],
        "moved_mm_deg": [_numbers(row) for row in course.moved],
        "change_mm_deg": _numbers(course.change),
        "deviation_mm_deg": _numbers(course.deviation),
        "is_told": course.is_significant.tolist(),
        "at_corners_mm": round(at_corners(cell, course.change) * 1000, 4),
    }


def _date(day: int) -> str:
    return datetime.fromtimestamp(day * DAY, UTC).strftime("%Y-%m-%d")


def _format(motion: Floats) -> tuple[str, ...]:
    return tuple(
        f"{value:.2f}" if np.isfinite(value) else "-" for value in motion * TO_MM_AND_DEGREES
    )


def _numbers(motion: Floats) -> list[float | None]:
    return [
        round(float(value), 5) if np.isfinite(value) else None
        for value in motion * TO_MM_AND_DEGREES
    ]
