"""`workbench study localization --cases`: kept cases searched again, as a table or JSON."""

import sys
from dataclasses import asdict
from pathlib import Path
from typing import Any

from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyLocalization
from workbench.cli.exits import BAD_INPUT, NO_PLAN, SUCCESS
from workbench.cli.terminal import print_json, print_table, progress
from workbench.formats.files.whole_files import is_folder
from workbench.model.errors import FileError, InputError
from workbench.studies.case_searches import Held, Tally, held_cases, in_all


def study_cases(typed: StudyLocalization, folder: Path) -> int:
    """Search in all cases of a folder again, and tell which became worse."""
    if typed != StudyLocalization(cases=folder, json=typed.json):
        raise InputError(
            "--cases goes with --json alone: each case has its own cell, parts, scan and seed"
        )
    with progress("cases") as report:
        paths = _cases_in(folder)
        make_ready(report, ("seeing",))
        held = held_cases(paths, report)
    summed = in_all(held)
    for comparison in held:
        if comparison.problem:
            print(f"workbench: {comparison.problem}", file=sys.stderr)
    if typed.json:
        print_json({"cases": [_form(comparison) for comparison in held], "all": summed})
    else:
        _print(held, summed)
    if summed["worse"]:
        return NO_PLAN
    return BAD_INPUT if summed["unusable"] else SUCCESS


def _cases_in(folder: Path) -> list[Path]:
    if not is_folder(folder):
        raise FileError(folder, "is no folder; name one that holds kept cases")
    try:
        found = sorted(path for path in folder.iterdir() if path.suffix.lower() == ".zip")
    except OSError as error:
        raise FileError(folder, error.strerror or "cannot be read") from None
    if not found:
        raise FileError(
            folder, "holds no kept case (.zip); those of a session lie in its folder `cases`"
        )
    return found


def _form(comparison: Held) -> dict[str, Any]:
    counts = {
        side: {
            "right": tally.right,
            "wrong": tally.wrong,
            "missed": tally.missed,
            "unjudged": tally.unjudged,
            "is_right": tally.is_right,
        }
        for side, tally in (("before", comparison.before), ("now", comparison.now))
    }
    return {
        **asdict(comparison),
        **counts,
        "is_worse": comparison.is_worse,
        "is_better": comparison.is_better,
    }


def _print(held: list[Held], summed: dict[str, Any]) -> None:
    rows = [_words(comparison) for comparison in held if not comparison.problem]
    if len(rows) > 1:
        both = [(summed["before"][key], summed["now"][key]) for key in COUNTED]
        rows.append(("all", *(f"{before} / {now}" for before, now in both), "", "", ""))
    print_table(
        "Kept cases, searched again: before / now",
        ("case", "right", "wrong", "missed", "not judged", "s", "", "comment"),
        rows,
    )
    said = f"{summed['cases']} cases with {summed['parts']} parts: "
    said += f"{summed['worse']} worse, {summed['better']} better"
    if summed["unusable"]:
        said += f"; {summed['unusable']} could not be used"
    print(said)


COUNTED = ("right", "wrong", "missed", "unjudged")


def _words(comparison: Held) -> tuple[str, ...]:
    def two(key: str) -> str:
        def of(tally: Tally) -> int:
            return getattr(tally, key)

        return f"{of(comparison.before)} / {of(comparison.now)}"

    change = "worse" if comparison.is_worse else "better" if comparison.is_better else "as before"
    times = f"{comparison.seconds_before:.1f} / {comparison.seconds:.1f}"
    return (
        comparison.name.removesuffix(".zip"),
        *(two(key) for key in COUNTED),
        times,
        change,
        comparison.comment,
    )
