"""`workbench bench motion`: motion problems from files, as tables and JSON."""

from typing import Any

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.bench import BenchMotion
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.formats.robots.motion_problems import read_motion_problems
from workbench.model.cell import Policy
from workbench.plugins.extras import from_extra
from workbench.plugins.planner import planner_named
from workbench.studies.motion.problems import cases_of
from workbench.studies.motion.solving import (
    KLAMPT,
    OMPL,
    compare,
    figures,
    summary,
)

MOST_ITERATIONS = 1_000_000
WIDEST_MARGIN = 0.5
"""[m] A larger margin leaves no way anywhere."""

OTHERS = {"ompl": OMPL, "klampt": KLAMPT}


def motion(typed: BenchMotion) -> int:
    """Plan them, and tell what came out, set by set."""
    check_whole("--iterations", typed.iterations, 1, MOST_ITERATIONS)
    check_number("--margin", typed.margin, 0.0, WIDEST_MARGIN)
    check_number("--seconds", typed.seconds, 0.01, 3600)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    planner_named(typed.planner)
    sets = read_motion_problems(typed.folder, typed.robot)
    policy = Policy(
        margin=typed.margin,
        near_margin=0.0,
        self_margin=0.0,
        planner=typed.planner,
        iterations=typed.iterations,
    )
    with progress("motion") as report:
        make_ready(report, ("planning",))
        report(0.0, "making the problems ready")
        cases = cases_of(sets, policy)
        attempts = compare(
            cases,
            with_ompl=typed.against == "ompl",
            seed=typed.seed,
            seconds=typed.seconds,
            report=report,
        )
        if typed.against == "klampt":
            solve = from_extra("klampt.planning:solve_by_klampt", "--against klampt needs")
            attempts += solve(cases, seconds=typed.seconds, report=report)
    other = None if typed.against is None else OTHERS[typed.against]
    planners = [typed.planner] if other is None else [typed.planner, other]
    rows = {name: summary(cases, attempts, name) for name in planners}
    whole = {name: figures(cases, [a for a in attempts if a.planner == name]) for name in planners}
    if typed.json:
        form: dict[str, Any] = {
            "planner": typed.planner,
            "sets": rows[typed.planner],
            "all": whole[typed.planner],
        }
        if other is not None:
            form["against"] = {"planner": other, "sets": rows[other], "all": whole[other]}
        print_json(form)
        return SUCCESS
    for case in cases:
        if case.invalid:
            print(f"{case.name} {case.problem}: invalid, {case.invalid}")
    for name in planners:
        print_table(
            f"{name}: processor time, and by the clock",
            ("set", "solved", "invalid", "median ms", "mean ms", "95 % ms", "clock, median ms",
             "path, rad"),
            [_words(row) for row in [*rows[name], {"set": "all"} | whole[name]]],
        )  # fmt: skip
    return SUCCESS


def _words(row: dict[str, Any]) -> tuple[str, ...]:
    times = ("median_ms", "mean_ms", "p95_ms", "wall_median_ms")
    return (
        row["set"],
        f"{row['solved']} of {row['problems'] - row['invalid']}",
        str(row["invalid"]),
        *(_number(row[key], 1) for key in times),
        _number(row["way"], 2),
    )


def _number(value: float | None, decimals: int) -> str:
    return "" if value is None else f"{value:.{decimals}f}"
