"""`workbench study wrong-cad`: searches by CAD files of a wrong size."""

from dataclasses import asdict
from typing import Any

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyWrongCad
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.model.errors import InputError
from workbench.studies.cases import run_cases
from workbench.studies.localization import localized_scene
from workbench.studies.seeing.wrong_cad import wrong_cad_rows, wrong_cad_tasks

MOST_SCANS = 10_000


def study_wrong_cad(typed: StudyWrongCad) -> int:
    """Search by wrong CAD files, and print what is found and reported."""
    check_whole("--scenes", typed.scenes, 1, MOST_SCANS)
    check_whole("--workers", typed.workers, 1, 1024)
    if not typed.parts or not typed.noise or not typed.scales:
        raise InputError("--parts, --noise and --scales need at least one value each")
    for scale in typed.scales:
        check_number("--scales", scale, 0.5, 2.0)
    for offset in typed.offsets_mm:
        check_number("--offsets-mm", offset, -5.0, 5.0)
    tasks = wrong_cad_tasks(
        typed.cell, typed.parts, typed.noise, scales=typed.scales,
        offsets=[offset / 1000 for offset in typed.offsets_mm],
        scenes=typed.scenes, seed=typed.seed,
    )  # fmt: skip
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - len(tasks))
    with progress("wrong CAD files") as report:
        make_ready(report, ("seeing",))
        scenes = run_cases(localized_scene, tasks, workers=typed.workers, report=report)
    rows = wrong_cad_rows(scenes)
    if typed.json:
        print_json({"scenes": [asdict(scene) for scene in scenes], "rows": rows})
        return SUCCESS
    columns = (
        "CAD",
        "noise",
        "missed",
        "right",
        "stated",
        "median mm",
        "error reported",
        "called off",
    )
    print_table(
        f"CAD files of a wrong size, {typed.scenes} piles of each part a row",
        columns,
        [_words(row) for row in rows],
    )
    return SUCCESS


def _words(row: dict[str, Any]) -> tuple[str, ...]:
    error = f"{row['offset'] * 1000:+g} mm" if row["offset"] else f"{row['scale'] - 1:+.0%}"
    distance = row["distance"]
    return (
        error,
        row["build"],
        f"{row['missed']} of {row['clear']}",
        f"{row['right']} of {row['found']}",
        "" if row["stated"] is None else f"{row['stated']:.2f}",
        "" if distance is None else f"{distance['median'] * 1000:.2f}",
        f"{row['reported']} of {row['piles']}",
        str(row["off"]),
    )
