"""`workbench study placing`: error budgets of picks, against physics."""

from typing import Any

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyPlacing
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.studies.placing import Case, measure, summary

MOST_GRIPS = 1_000_000


def placing(typed: StudyPlacing) -> int:
    """Carry it out and print what was found."""
    check_whole("--grips", typed.grips, 1, MOST_GRIPS)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1 - MOST_GRIPS)
    check_whole("--workers", typed.workers, 1, 1024)
    check_number("--wider", typed.wider, 0.0, 100.0)
    check_number("--force", typed.force, 0.1, 10_000.0)
    check_number("--acceleration", typed.acceleration, 0.0, 1000.0)
    case = Case(
        typed.cell,
        typed.part,
        typed.seed,
        typed.noise,
        typed.wider,
        typed.force,
        typed.acceleration or None,
    )
    cell = read_cell(typed.cell)
    with progress("placing") as report:
        make_ready(report, ("planning", "seeing"))
        results = measure(case, typed.grips, workers=typed.workers, report=report)
    found = summary(results)
    if typed.json:
        print_json(found)
        return SUCCESS
    whole = found["all"]
    if not results:
        print("no part was gripped: none was found, lay by itself and was fit for a grasp")
        return SUCCESS
    print_table(
        f"{cell.name}: {whole['grips']} grips, the share within the tolerances of the place",
        (
            "grasp",
            "grips",
            "said",
            "closed",
            "measured",
            "apart",
            "slipped",
            "tipped",
            "lost",
            "missed",
        ),
        [_words(name, row) for name, row in (*found["grasps"].items(), ("all", whole))],
    )
    print(
        f"{whole['within_shift']:.1%} of the parts are shifted and "
        f"{whole['within_turn']:.1%} turned no more than is said of {whole['stated']:.0%}"
    )
    return SUCCESS


def _words(name: str, row: dict[str, Any]) -> tuple[str, ...]:
    return (
        name,
        str(row["grips"]),
        f"{row['predicted']:.1%}",
        f"{row['closed']:.1%}",
        f"{row['measured']:.1%}",
        f"{row['difference']:+.3f}",
        *(str(row[key]) for key in ("slipped", "tipped", "lost", "missed")),
    )
