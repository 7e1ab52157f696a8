"""`workbench bench` and `workbench study`: measurements, as tables, JSON and plots."""

from collections import Counter
from dataclasses import asdict, replace
from typing import Any

import numpy as np

from workbench.app.core.value_checks import MOST_PARTS, SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.bench import BenchPick, BenchPlanners
from workbench.cli.arguments.studies import StudyLocalization, StudyThreshold
from workbench.cli.exits import SUCCESS
from workbench.cli.measuring.case_study import study_cases
from workbench.cli.measuring.precision_columns import BOP_COLUMNS, bop_words
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.formats.cells.predictions import predictions_path, write_predictions
from workbench.formats.cells.reading import read_cell
from workbench.model.errors import InputError
from workbench.plugins.extras import from_extra
from workbench.plugins.planner import planner_named
from workbench.studies import localization, pairs, planners, plots, threshold
from workbench.studies.cases import run_cases
from workbench.studies.picking import picks

HIGHEST_COUNT = 1_000_000


def bench_planners(typed: BenchPlanners) -> int:
    """Compare the planners."""
    check_whole("--targets", typed.targets, 1, HIGHEST_COUNT)
    check_number("--seconds", typed.seconds, 0.01, 600)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    if not typed.iterations or not typed.planners:
        raise InputError("--iterations and --planners need at least one value each")
    for allowed in typed.iterations:
        check_whole("--iterations", allowed, 1, HIGHEST_COUNT)
    for name in typed.planners:
        planner_named(name)
    cell = read_cell(typed.cell)
    if typed.start == "zero":
        arm = cell.arms[0]
        cell = replace(cell, arms=(replace(arm, home=np.zeros(len(arm.home))), *cell.arms[1:]))
    by_klampt: list[planners.Attempt] = []
    with progress("planners") as report:
        make_ready(report, ("planning",))
        report(0.0, "judging the targets")
        course = planners.Course(cell, typed.targets, typed.seed)
        if not course.goals:
            raise InputError(f"cell {cell.name}: none of {typed.targets} targets can be taken up")
        attempts = planners.compare(course, typed.planners, typed.iterations, report)
        if typed.against is not None:
            solve = from_extra("klampt.planning:attempts_by_klampt", "--against klampt needs")
            by_klampt = solve(course, seconds=typed.seconds, report=report)
    outcomes = Counter(target.outcome for target in course.targets)
    ours, theirs = planners.summary(attempts), planners.summary(by_klampt)
    if typed.plot is not None:
        plots.draw_planners(typed.plot, ours, theirs)
    ratio = _ratio(ours, theirs)
    if typed.json:
        form = {"targets": dict(outcomes), "planners": ours, "klampt": theirs, "ratio": ratio}
        print_json(form)
        return SUCCESS
    counted = ", ".join(f"{count} {outcome}" for outcome, count in sorted(outcomes.items()))
    print(f"cell {cell.name}, start {typed.start}, {typed.targets} targets: {counted}")
    columns = ("planner", "allowed", "used", "success", "search ms", "mean ms")
    print_table(
        "From start to target, over the clear targets, by the iterations allowed",
        (*columns, "median ms", "95 % ms", "tool way mm"),
        [_planner_words(row) for row in [*ours, *theirs]],
    )
    if ratio is not None:
        print(f"rrtconnect is {ratio:.1f} times as fast in the mean as Klamp't's SBL")
    return SUCCESS


def _ratio(ours: list[dict[str, Any]], theirs: list[dict[str, Any]]) -> float | None:
    """How many times as long Klamp't's SBL takes as our default with the most iterations."""
    mine = [row for row in ours if row["planner"] in ("rrtconnect", "birrt")]
    sbl = [row for row in theirs if row["planner"].endswith("sbl")]
    if not mine or not sbl:
        return None
    return sbl[0]["mean"] / max(mine, key=lambda row: row["allowed"])["mean"]


def _planner_words(row: dict[str, Any]) -> tuple[str, ...]:
    return (
        row["planner"],
        "" if row["allowed"] is None else str(row["allowed"]),
        "" if row["iterations_mean"] is None else f"{row['iterations_mean']:.1f}",
        f"{row['success']:.1%}",
        *(_ms(row[key]) for key in ("search_mean", "mean", "median", "p95")),
        "" if row["tool_way_mean"] is None else f"{row['tool_way_mean'] * 1000:.0f}",
    )


def bench_pick(typed: BenchPick) -> int:
    """Time the stages of planning."""
    check_whole("--scenes", typed.scenes, 1, HIGHEST_COUNT)
    check_whole("--parts", typed.parts, 1, MOST_PARTS)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - typed.scenes)
    with progress("picks") as report:
        make_ready(report, ("planning",))
        measured = picks.measure(
            typed.cell,
            scenes=typed.scenes,
            parts=typed.parts,
            seed=typed.seed,
            strategy=typed.strategy,
            planner=typed.planner,
            report=report,
        )
    if typed.json:
        print_json(measured)
        return SUCCESS
    print_table(
        "Planning: the stages, and all of them by what came out",
        ("stage", "median ms", "90 % ms", "largest ms", "count"),
        [
            (
                row["stage"],
                *(_ms(row[key]) for key in ("median", "p90", "largest")),
                str(row["count"]),
            )
            for row in picks.rows(measured)
        ],
    )
    fates = ", ".join(f"{count} {fate}" for fate, count in measured["parts"].items())
    print(f"of {typed.scenes * typed.parts} parts, by the grasp that got furthest: {fates}")
    if measured["cycle_seconds"]:
        print(f"predicted cycle: {np.median(measured['cycle_seconds']):.1f} s median")
    return SUCCESS


def study_localization(typed: StudyLocalization) -> int:
    """Find parts whose poses are known, and compare."""
    if typed.cases is not None:
        return study_cases(typed, typed.cases)
    check_whole("--scenes", typed.scenes, 1, HIGHEST_COUNT)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - typed.scenes)
    if not typed.parts or not typed.counts or not typed.noise:
        raise InputError("--parts, --counts and --noise need at least one value each")
    for count in typed.counts:
        check_whole("--counts", count, 0, MOST_PARTS)
    check_number("--raised", typed.raised, -100.0, 100.0)
    check_number("--tilted", typed.tilted, -45.0, 45.0)
    check_number("--cad-scale", typed.cad_scale, 0.5, 2.0)
    tilted = float(np.deg2rad(typed.tilted))
    models = "" if typed.models is None else str(typed.models)
    off = (typed.raised / 1000, tilted, typed.search, typed.cad_scale, models)
    tasks = [
        localization.Task(typed.cell, part, build, count, seed, *off)
        for part in typed.parts
        for build in typed.noise
        for count in typed.counts
        for seed in range(typed.seed, typed.seed + typed.scenes)
    ]
    with progress("localization") as report:
        make_ready(report, ("seeing",))
        scenes = run_cases(localization.localized_scene, tasks, report=report)
    rows = localization.summary(scenes)
    sure = localization.how_sure(scenes)
    if typed.plot is not None:
        plots.draw_localization(typed.plot, rows, sure)
    if typed.json:
        form = {"scenes": [asdict(scene) for scene in scenes], "rows": rows, "sureness": sure}
        print_json(form)
        return SUCCESS
    columns = ("part", "noise", "count", "best two", "precision", "recall", "no roll")
    print_table(
        f"Localization, {typed.scenes} piles a row; median / worst",
        (*columns, "mm", "degrees", "ms"),
        [_localization_words(row) for row in rows],
    )
    columns = ("part", "noise", "count", *BOP_COLUMNS, "CAD said off", "scanned over CAD")
    print_table(
        "Average precision as BOP 2024 has it; size of the CAD files",
        columns,
        [_bop_words(row) for row in rows],
    )
    if sure["calibration_error"] is not None:
        count = sum(probability_bin["count"] for probability_bin in sure["bins"])
        print(
            f"chances stated and shares right are {sure['calibration_error']:.3f} apart ({count} "
            "detections)"
        )
    if sure["within"] is not None:
        print(
            f"{sure['within']:.1%} of {sure['errors']} errors of right ones lie within the 99 % "
            "ellipsoids of their covariances"
        )
    return SUCCESS


def _bop_words(row: dict[str, Any]) -> tuple[str, ...]:
    size = row["size"]
    return (
        row["part"],
        row["build"],
        str(row["count"]),
        *bop_words(row["bop"]),
        f"{size['said']} of {row['scenes']}",
        "" if size["median"] is None else f"{size['median']:.4f}",
    )


def _localization_words(row: dict[str, Any]) -> tuple[str, ...]:
    def two(key: str, factor: float, digits: int) -> str:
        if row[key] is None:
            return ""
        return " / ".join(f"{row[key][k] * factor:.{digits}f}" for k in ("median", "worst"))

    return (
        row["part"],
        row["build"],
        str(row["count"]),
        *("" if row[k] is None else f"{row[k]:.1%}" for k in ("best_right", "precision", "recall")),
        str(row["roll_unknown"]),
        two("distance", 1e3, 2),
        two("turn", float(np.rad2deg(1.0)), 2),
        two("seconds", 1e3, 0),
    )


def study_threshold(typed: StudyThreshold) -> int:
    """Plan piles of two parts both ways, and compare."""
    check_whole("--cycles", typed.cycles, 1, HIGHEST_COUNT)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - typed.cycles)
    check_whole("--workers", typed.workers, 1, 1024)
    for value in typed.thresholds:
        check_number("--thresholds", value, 0.0, 10.0)
    cell = read_cell(typed.cell)
    if len(cell.arms) < 2:
        raise InputError(f"cell {typed.cell} has one arm; the threshold is about two")
    with progress("threshold") as report:
        make_ready(report, ("planning",))
        cases = run_cases(
            threshold.planned_case,
            [(typed.cell, seed) for seed in range(typed.seed, typed.seed + typed.cycles)],
            workers=typed.workers,
            scheduler=typed.scheduler,
            report=report,
        )
    rows = threshold.summary(cases, typed.thresholds)
    taken = pairs.count_pairs([case.taken for case in cases])
    if typed.plot is not None:
        plots.draw_threshold(typed.plot, cases, rows)
    if typed.keep:
        kept = threshold.predictions(cell, rows)
        write_predictions(predictions_path(typed.cell), kept)
    if typed.json:
        forms = [asdict(case) for case in cases]
        print_json({"cases": forms, "pairs": taken, "thresholds": rows})
        return SUCCESS
    reachable = sum(case.is_reachable for case in cases)
    print(f"{len(cases)} piles; in {reachable} each arm can take a part of its own")
    print_table("What auto takes of each pair", ("", "pairs", "why"), _pairs_words(taken))
    columns = ("threshold mm", "both allowed", "success", "mean ms", "median ms", "95 % ms")
    print_table(
        "At that distance or more the quicker of coordinated and alternated, below it alternated",
        (*columns, "one by one", "mean ms", "median ms", "cycle s", "of bound", "parts an hour"),
        [_threshold_words(row) for row in rows],
    )
    return SUCCESS


def _pairs_words(taken: dict[str, Any]) -> list[tuple[str, ...]]:
    def why(reasons: dict[str, int]) -> str:
        return "; ".join(f"{count} {reason}" for reason, count in reasons.items())

    return [
        ("both by one plan of two arms", str(taken["two_arms"]), ""),
        ("one by the first plan", str(taken["one_arm"]), why(taken["why_one_arm"])),
        ("none", str(taken["none"]), why(taken["why_none"])),
        ("both, a second plan counted", str(taken["whole"]), why(taken["why_not_whole"])),
    ]


def _threshold_words(row: dict[str, Any]) -> tuple[str, ...]:
    allowed, alternated = row["allowed_planning"], row["alternated_planning"]
    return (
        f"{row['threshold'] * 1000:.0f}",
        _percent(row["allowed_share"]),
        _percent(row["allowed_success"]),
        *(
            ("", "", "")
            if allowed is None
            else (_ms(allowed[k]) for k in ("mean", "median", "p95"))
        ),
        _percent(row["alternated_success"]),
        *(("", "") if alternated is None else (_ms(alternated[k]) for k in ("mean", "median"))),
        "" if row["cycle_mean"] is None else f"{row['cycle_mean']:.1f}",
        "" if row["of_bound"] is None else f"{row['of_bound']:.2f}",
        "" if row["parts_per_hour"] is None else f"{row['parts_per_hour']:.0f}",
    )


def _percent(share: float | None) -> str:
    return "" if share is None else f"{share:.0%}"


def _ms(seconds: float) -> str:
    return f"{seconds * 1000:.1f}"
