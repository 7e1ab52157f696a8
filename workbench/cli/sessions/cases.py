"""`workbench session cases`: what a session has kept as cases, and copies of it elsewhere."""

import sys
import time
from pathlib import Path
from typing import Any

from workbench.app.records.case_folder import case_files
from workbench.app.records.cases import LARGEST_CASE, Case, read_case
from workbench.app.records.session_archive import open_journal
from workbench.cli.arguments.session import SessionCases
from workbench.cli.exits import BAD_INPUT, SUCCESS
from workbench.cli.terminal import print_json, print_table
from workbench.formats.files.whole_files import make_folder, read_whole, write_whole
from workbench.model.errors import FileError


def cases(typed: SessionCases) -> int:
    """List them, and copy them where that is wanted."""
    open_journal(typed.session).close()
    if typed.out is not None:
        make_folder(typed.out)
    rows, broken, copied = list[dict[str, Any]](), 0, 0
    for path in case_files(typed.session):
        try:
            rows.append(_row(path, read_case(path)))
            if typed.out is not None and not (typed.out / path.name).exists():
                write_whole(typed.out / path.name, read_whole(path, LARGEST_CASE))
                copied += 1
        except FileError as error:
            broken += 1
            print(f"workbench: {error}", file=sys.stderr)
    if typed.json:
        print_json({"cases": rows})
    else:
        _print(typed, rows)
        if typed.out is not None:
            print(f"{copied} of {len(rows)} cases copied to {typed.out}")
    return BAD_INPUT if broken else SUCCESS


def _row(path: Path, case: Case) -> dict[str, Any]:
    return {
        "case": path.name,
        "at": case.at,
        "by": case.by,
        "comment": case.comment,
        "cell": case.cell.name,
        "found": len(case.search.detections),
        "changed": len(case.changed),
        "there": len(case.truth),
        "is_complete": case.is_complete,
    }


def _print(typed: SessionCases, rows: list[dict[str, Any]]) -> None:
    print_table(
        f"Cases of {typed.session}",
        ("case", "at (UTC)", "who", "found", "changed", "there", "comment"),
        [
            (
                row["case"],
                time.strftime("%Y-%m-%d %H:%M", time.gmtime(row["at"])),
                row["by"],
                str(row["found"]),
                str(row["changed"]),
                f"{row['there']}{'' if row['is_complete'] else ' or more'}",
                row["comment"],
            )
            for row in rows
        ],
    )
