"""`workbench study absent`: how often a part is reported where none lies."""

from dataclasses import asdict
from typing import Any

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyAbsent
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_whole, print_json, print_table, progress
from workbench.model.errors import InputError
from workbench.studies.cases import run_cases
from workbench.studies.seeing.absent import absent_rows, absent_tasks, search_absent

MOST_SCANS = 100_000


def study_absent(typed: StudyAbsent) -> int:
    """Search where no part lies, and print the reports."""
    check_whole("--scans", typed.scans, 1, MOST_SCANS)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - typed.scans)
    check_whole("--workers", typed.workers, 1, 1024)
    if len(set(typed.parts)) < 2 or not typed.noise:
        raise InputError("--parts needs two parts or more, --noise one build or more")
    tasks = absent_tasks(typed.cell, typed.parts, typed.noise, scans=typed.scans, seed=typed.seed)
    with progress("absent parts") as report:
        make_ready(report, ("seeing",))
        searches = run_cases(search_absent, tasks, workers=typed.workers, report=report)
    rows = absent_rows(searches)
    if typed.json:
        print_json({"searches": [asdict(each) for each in searches], "rows": rows})
        return SUCCESS
    print_table(
        "Reports of parts that do not lie there; false alarms are above 0.5",
        ("there lies", "scans", "reports", "false alarms", "in scans", "processor s", "worst"),
        [_words(row) for row in rows],
    )
    for each in searches:
        if each.false_alarms:
            task, sure = each.task, " ".join(f"{p:.2f}" for p in each.probabilities)
            there = task.lying or task.situation
            print(f"{task.searched} in {there}, {task.build}, seed {task.seed}: {sure}")
    return SUCCESS


def _words(row: dict[str, Any]) -> tuple[str, ...]:
    seconds = row["processor_seconds"]
    return (
        row["situation"],
        *(str(row[key]) for key in ("scans", "reports", "false_alarms", "scans_with_false_alarms")),
        f"{seconds['median']:.2f}",
        f"{seconds['worst']:.2f}",
    )
