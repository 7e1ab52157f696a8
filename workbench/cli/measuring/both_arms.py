"""`workbench bench both-arms`: all joints of two arms planned as one, as a table and JSON."""

from typing import Any

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.bench import BenchBothArms
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.studies.motion.both_arms import BothArms, compare, summary

MOST_PAIRS = 1_000_000


def both_arms(typed: BenchBothArms) -> int:
    """Plan them, and tell what came out by each planner."""
    check_whole("--pairs", typed.pairs, 1, MOST_PAIRS)
    check_number("--seconds", typed.seconds, 0.01, 600)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - typed.pairs)
    both = BothArms(read_cell(typed.cell))
    with progress("both arms") as report:
        make_ready(report, ("planning",))
        attempts = compare(
            both, pairs=typed.pairs, seed=typed.seed, seconds=typed.seconds, report=report
        )
    rows = summary(attempts)
    if typed.json:
        print_json({"cell": both.cell.name, "joints": len(both.columns), "rows": rows})
        return SUCCESS
    print_table(
        f"cell {both.cell.name}, {len(both.columns)} joints as one: processor time",
        ("planner", "ends", "solved", "median ms", "mean ms", "95 % ms", "motion, s"),
        [_words(row) for row in rows],
    )
    return SUCCESS


def _words(row: dict[str, Any]) -> tuple[str, ...]:
    return (
        row["planner"],
        row["ends"],
        f"{row['solved']} of {row['pairs']}",
        *(
            "" if row[key] is None else f"{row[key]:.1f}"
            for key in ("median_ms", "mean_ms", "p95_ms")
        ),
        "" if row["motion"] is None else f"{row['motion']:.2f}",
    )
