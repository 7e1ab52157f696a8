"""`workbench study grips`: which grips hold a part's weight, against physics."""

from typing import Any

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyGrips
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.studies.grips.holding import Case, measure, summary

MOST_GRIPS = 1_000_000


def grips(typed: StudyGrips) -> int:
    """Carry it out and print what was found."""
    check_whole("--grips", typed.grips, 1, MOST_GRIPS)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1 - MOST_GRIPS)
    check_whole("--workers", typed.workers, 1, 1024)
    check_number("--force", typed.force, 0.1, 10_000.0)
    check_number("--acceleration", typed.acceleration, 0.0, 1000.0)
    case = Case(typed.cell, typed.part, typed.seed, typed.force, typed.acceleration)
    with progress("grips") as report:
        make_ready(report, ("planning",))
        results = measure(case, typed.grips, workers=typed.workers, report=report)
    found = summary(results)
    if typed.json:
        print_json(found)
        return SUCCESS
    if not results:
        print("no part was gripped: the hand takes none of them")
        return SUCCESS
    rows = {**found["parts"], "all": found["all"], "all, 0.5 to 2 times held": found["near"]}
    print_table(
        f"{typed.cell}: what is said to hold and what MuJoCo holds",
        ("part", "grips", "stayed", "agree", "said to hold", "and did not", "not said, but did"),
        [_words(name, row) for name, row in rows.items()],
    )
    left_out = typed.grips - len(results)
    print(f"{left_out} of {typed.grips} left out: the hand does not hold the part as meant")
    return SUCCESS


def _words(name: str, row: dict[str, Any]) -> tuple[str, ...]:
    return (
        name,
        str(row["grips"]),
        str(row["stayed"]),
        "" if row["agreement"] is None else f"{row['agreement']:.1%}",
        *(str(row[key]) for key in ("said_to_hold", "false_holds", "false_slips")),
    )
