"""`workbench study emptying`: full bins, emptied as far as it goes."""

from dataclasses import replace
from typing import Any

from workbench.app.core.value_checks import MOST_PARTS, SEED_LIMIT
from workbench.app.emptying.summary import summary
from workbench.app.emptying.what_if import rank_changes, tasks_with_changes
from workbench.app.picking.row import check_picks
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments.studies import StudyEmptying
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_number, check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import MOST_PICKS
from workbench.model.derived.by_recipe import as_chosen, check_strategy
from workbench.model.derived.policies import MOST_STIRS
from workbench.model.errors import InputError
from workbench.model.prediction import CHANGE_KINDS, PileTask
from workbench.studies.emptying.pile_results import emptied_all
from workbench.studies.emptying.piles import cell_of, check_task
from workbench.studies.emptying.plot import draw_emptying

ALL = "all"
MOST_PILES = 1_000_000
LONGEST_STEP = 3600.0
"""[s] A scan or an approval takes no longer."""

COMPARED = ("taken_share", "parts_per_hour", "cycles", "scans", "failed_picks", "touches")
"""The report of the same piles, emptied by one plan a look."""

MOST_LISTED = 30
"""Parts that stayed are computed up to here; --json prints all."""


def emptying(typed: StudyEmptying) -> int:
    """Carry it out and print what was found."""
    check_whole("--scenes", typed.scenes, 1, MOST_PILES)
    check_whole("--parts", typed.parts, 1, MOST_PARTS)
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - typed.scenes)
    check_whole("--picks", typed.picks, 1, MOST_PICKS)
    if typed.stirs is not None:
        check_whole("--stirs", typed.stirs, 0, MOST_STIRS)
    check_whole("--workers", typed.workers, 1, 1024)
    check_number("--displaced-mm", typed.displaced_mm, 0.0, 50.0)
    check_number("--scan-seconds", typed.scan_seconds, 0.0, LONGEST_STEP)
    check_number("--approval-seconds", typed.approval_seconds, 0.0, LONGEST_STEP)
    tasks = [
        PileTask(
            typed.cell,
            typed.part,
            typed.parts,
            seed,
            typed.seen,
            typed.settle,
            typed.strategy,
            typed.bound,
            picks=typed.picks,
            recipe=typed.recipe,
            bin=typed.bin,
            stirs=typed.stirs,
            displaced=typed.displaced_mm / 1000,
        )
        for seed in range(typed.seed, typed.seed + typed.scenes)
    ]
    cell = as_chosen(read_cell(typed.cell), typed.recipe, typed.bin)
    check_strategy(cell, typed.strategy)
    check_picks(cell, typed.picks)
    check_task(tasks[0])
    kinds = kinds_of(typed.what_if) if typed.what_if else frozenset[str]()
    if kinds:
        tasks = tasks_with_changes(
            cell_of(typed.cell, typed.part, typed.recipe, typed.bin), tasks, kinds
        )
    if typed.picks > 1:
        tasks += [replace(task, picks=1) for task in tasks if not task.change]
    with progress("emptying") as report:
        make_ready(report, ("planning", "seeing") if typed.seen == "scan" else ("planning",))
        scenes = emptied_all(
            tasks,
            folder=typed.resume,
            workers=typed.workers,
            scheduler=typed.scheduler,
            report=report,
        )
    seconds = {"scan_seconds": typed.scan_seconds, "approval_seconds": typed.approval_seconds}
    plain = [scene for scene in scenes if not scene.task.change]
    found = summary([pile for pile in plain if pile.task.picks == typed.picks], **seconds)
    if typed.picks > 1:
        single = summary([pile for pile in plain if pile.task.picks == 1], **seconds)
        found["one_pick"] = {key: single[key] for key in COMPARED}
    if kinds:
        changed = [scene for scene in scenes if scene.task.picks == typed.picks]
        found["what_if"] = rank_changes(changed, **seconds)
    title = f"{cell.name}: {typed.scenes} piles of {typed.parts}, {found['taken_share']:.0%} taken"
    if typed.plot is not None:
        draw_emptying(typed.plot, found, title)
    if typed.json:
        print_json(found)
        return SUCCESS
    _print(found, title)
    if kinds:
        _print_changes(found)
    return SUCCESS


def kinds_of(text: str) -> frozenset[str]:
    """Kinds of changes from words as they are typed, `all` or some joined by `+`.

    Raises:
        InputError: a word is no kind.
    """
    if text == ALL:
        return frozenset(CHANGE_KINDS)
    kinds = text.split("+")
    for kind in kinds:
        if kind not in CHANGE_KINDS:
            raise InputError(
                f"--what-if: {kind!r:.40} is no kind of change; "
                f"there are {', '.join(CHANGE_KINDS)}, and {ALL}"
            )
    return frozenset(kinds)


def _compare(found: dict[str, Any]) -> str:
    """How fast the same piles are emptied by one plan a look, where that was asked for."""
    single = found.get("one_pick")
    if single is None or single["parts_per_hour"] is None:
        return ""
    return (
        f" with {found['cycles']} approvals and {found['scans']} scans; with one pick a scan "
        f"{single['parts_per_hour']:.0f}, {single['cycles']} and {single['scans']}"
    )


def _print_changes(found: dict[str, Any]) -> None:
    print_table(
        "what if: single changes, the best first",
        ("change", "taken", "before", "parts", "failed", "touches", "motion s"),
        [
            (
                row["change"],
                f"{row['taken_share']:.1%}",
                f"{row['taken_share_before']:.1%}",
                f"{row['parts_gained']:+d}",
                str(row["failed_picks"]),
                str(row["touches"]),
                f"{row['motion_seconds']:.1f}",
            )
            for row in found["what_if"]
        ],
    )


def _print(found: dict[str, Any], title: str) -> None:
    print_table(
        title,
        ("seed", "parts", "taken", "cycles", "failed", "touches", "knocked out", "motion s"),
        [
            (
                *(str(scene[key]) for key in ("seed", "parts", "taken", "cycles")),
                *(str(scene[key]) for key in ("failed_picks", "touches", "knocked_out")),
                f"{scene['motion_seconds']:.1f}",
            )
            for scene in found["scenes"]
        ],
    )
    kinds = ", ".join(f"{count} {kind}" for kind, count in found["failed_by_kind"].items())
    rolled = found["taken_rolled"]
    otherwise = f", {rolled} of them rolled otherwise than found" if rolled else ""
    print(
        f"{found['taken']} of {found['parts']} parts taken, {found['taken_share']:.1%}{otherwise}; "
        f"{found['picks']} picks, {found['failed_picks']} failed ({kinds}), "
        f"{found['touches']} touches, {found['knocked_out']} knocked out of the bin, "
        f"{found['stirs']} times stirred"
    )
    if found["kits"] is not None:
        unmated = found["kits_unmated"]
        jammed = f", {unmated} whose parts do not mate" if unmated else ""
        print(f"{found['kits']} of {found['kits_possible']} kits complete{jammed}")
    if found["warned_picks"]:
        print(
            f"{found['warned_picks']} of the picks, with {found['warned_touches']} of the touches, "
            "go where something that was not found may go on unseen, and their plans say so"
        )
    if found["planning_ms"] is not None:
        stages = ", ".join(f"{k} {ms:.0f}" for k, ms in found["planning_ms_by_stage"].items())
        print(
            f"planning: {found['planning_ms']['median']:.0f} ms median, "
            f"{found['planning_ms']['p95']:.0f} ms at 95 %; in the mean {stages}"
        )
    if found["estimate_share"] is not None and found["bound_share"] is None:
        share = found["estimate_share"]
        print(
            f"taken, or a hand of the tools could hold it as it stays: {share:.1%} (--bound: exact)"
        )
    if found["bound_share"] is not None:
        print(f"by all grasps of the tool, in the library or not: {found['bound_share']:.1%}")
    if found["parts_per_hour"] is not None:
        print(f"{found['parts_per_hour']:.0f} parts an hour{_compare(found)}")
    left = [(scene["seed"], part) for scene in found["scenes"] for part in scene["left"]]
    if not left:
        print("nothing stayed in the bins")
        return
    reasons = ", ".join(f"{count} {kind}" for kind, count in found["left_by_reason"].items())
    print(f"{len(left)} parts stayed: {reasons}")
    for seed, part in left[:MOST_LISTED]:
        fix = part["nearest_fix"] or "no small change of a grasp takes it"
        bound = f"; {part['any_grasp']}" if part["any_grasp"] else ""
        print(f"  seed {seed}, {part['part']}: {part['reason']}; {fix}{bound}")
    if len(left) > MOST_LISTED:
        print(f"  and {len(left) - MOST_LISTED} more: see --json")
