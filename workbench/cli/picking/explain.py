"""`workbench explain`: the verdict of every candidate, where they fell, and what would help."""

from collections import Counter
from collections.abc import Sequence

import numpy as np

from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.picking.exactness import with_exactness
from workbench.app.picking.judging import judge
from workbench.app.picking.pallets import boxes_around
from workbench.app.runtime.readiness import make_ready
from workbench.app.standing.seen_again import with_sight
from workbench.cli.arguments import top as arguments
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.picking.planning import around_in, detections_from
from workbench.cli.picking.results import candidate_form, print_candidates
from workbench.cli.terminal import check_whole, print_json, print_table, progress
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan
from workbench.model.candidate import Candidate, Stage
from workbench.model.cell import Cell
from workbench.model.derived.assembling import assembled_kinds, insertion_of, standing_parts
from workbench.model.derived.by_recipe import with_recipe
from workbench.model.errors import InputError
from workbench.model.scan import Detection
from workbench.planning.picking.nearest_fix import Fix, fix_words, nearest_fix
from workbench.planning.picking.whole_bin import Blocker, blockers, common_fixes
from workbench.planning.placing.assembling import base_errors, nest_error
from workbench.planning.placing.budget import Budget, budget_of
from workbench.planning.placing.chance import CONFIDENCE

JUDGED = (Stage.PROPOSE, Stage.GRASP, Stage.APPROACH, Stage.EXTRACT, Stage.PLACE)
"""Stages of a single candidate, in the order of the line."""


def explain(typed: arguments.Explain) -> int:
    """Print the verdicts; the exit code is 0 only when something can be taken."""
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    cell = with_recipe(read_cell(typed.cell), typed.recipe)
    placed = _standing(cell, typed.stands)
    detections = detections_from(cell, typed.poses, typed.part)
    if not detections:
        raise InputError(f"{typed.poses}: holds no poses, so there is nothing to explain")
    with progress("explain") as report:
        make_ready(report, ("planning",))
        scan = None if typed.scan is None else read_scan(typed.scan, cell.scanner)
        boxes = with_sight(cell, scan, boxes_around(cell, placed))
        around = around_in(cell, typed.scan, detections, standing_parts(cell, boxes)).seen
        obstacles = (*around, *boxes)
        candidates = judge(cell, detections, obstacles=obstacles, seed=typed.seed, report=report)
        report(0.9, "looking for the nearest fix")
        fix = nearest_fix(cell, detections, candidates, seed=typed.seed, obstacles=obstacles)
        fixes = common_fixes(
            cell,
            detections,
            candidates,
            seed=typed.seed,
            obstacles=obstacles,
            report=lambda done, note: report(0.9 + 0.1 * done, note),
        )
    candidates = with_exactness(cell, detections, candidates)
    bases = base_errors(cell, placed, boxes)
    sure = [
        (
            candidate,
            budget_of(cell, detections[candidate.detection], candidate, bases),
        )
        for candidate in candidates
        if candidate.verdict.is_ok
    ][:MOST_SURE]
    admitted = sum(candidate.verdict.is_ok for candidate in candidates)
    if typed.json:
        print_json(
            {
                "ok": admitted > 0,
                "candidates": [candidate_form(candidate) for candidate in candidates],
                "funnel": [
                    {"stage": str(stage), "entered": entered, "refused": refused}
                    for stage, entered, refused in funnel(candidates)
                ],
                "blockers": [_blocker_form(blocker) for blocker in blockers(cell, candidates)],
                "fixes": [
                    {"change": str(change), "parts": [number + 1 for number in parts]}
                    for change, parts in fixes
                ],
                "placing": [_sure_form(candidate, budget) for candidate, budget in sure],
                "nearest_fix": None if fix is None else _fix_form(fix),
            }
        )
    else:
        print_candidates(f"{len(candidates)} candidates, {admitted} can be taken", candidates)
        rows = (
            (str(stage.message), str(entered), str(refused), _reasons(candidates, stage))
            for stage, entered, refused in funnel(candidates)
        )
        print_table("where they fell", ("stage", "entered", "refused", "why"), rows)
        for candidate, budget in sure:
            part = f"part-{candidate.detection + 1}"
            print(f"{part} by {candidate.grasp_label} with {candidate.arm}: {budget.words}")
        for blocker in blockers(cell, candidates)[:MOST_BLOCKERS]:
            print(_blocker_words(blocker))
        for change, parts in fixes[:MOST_FIXES]:
            print(f"would take {_parts(parts)} that nothing takes: {change}")
        print(fix_words(fix))
    return SUCCESS if admitted else NO_PLAN


MOST_BLOCKERS, MOST_FIXES = 8, 5
"""Lines that are printed; --json prints all."""

MOST_SURE = 3
"""The best candidates, which state their placing error."""


def _standing(cell: Cell, kinds: Sequence[str]) -> tuple[Detection, ...]:
    """Parts of an assembly as they stand at the first place for each."""
    found: list[Detection] = []
    for kind in kinds:
        places = [place for arm in cell.arms for place in arm.places_for(kind)]
        if kind not in assembled_kinds(cell) or insertion_of(cell, kind) or not places:
            raise InputError(f"--stands {kind}: the recipe puts no {kind} at a place for others")
        place = places[0]
        found.append(Detection(kind, place.T_world_part, placing=nest_error(place)))
    return tuple(found)


def _sure_form(candidate: Candidate, budget: Budget) -> dict[str, object]:
    source, axis = budget.largest
    return {
        "detection": candidate.detection,
        "grasp": candidate.grasp.name,
        "arm": candidate.arm,
        **({"tcp": candidate.tcp} if candidate.tcp else {}),
        "shift_mm": round(budget.shift * 1000, 3),
        "turn_deg": round(float(np.rad2deg(budget.turn)), 3),
        "confidence": CONFIDENCE,
        "most_from": str(source()),
        "axis": str(axis()),
        "chance": budget.chance,
        "chance_as_believed": budget.believed_chance,
        "mates_with": None
        if budget.insertion is None or budget.chance is None
        else budget.insertion.base,
    }


def _parts(numbers: Sequence[int]) -> str:
    """A few parts by name, of many how many they are."""
    if len(numbers) > 4:
        return f"{len(numbers)} parts"
    return ", ".join(f"part-{number + 1}" for number in numbers)


def _blocker_words(blocker: Blocker) -> str:
    reasons = ", ".join(f"{count} {reason.message}" for reason, count in blocker.reasons)
    candidates = "1 candidate" if blocker.candidates == 1 else f"{blocker.candidates} candidates"
    return f"{blocker.label} blocks {candidates} of {_parts(blocker.parts)} ({reasons})"


def _blocker_form(blocker: Blocker) -> dict[str, object]:
    return {
        "blocker": blocker.label,
        "candidates": blocker.candidates,
        "parts": [number + 1 for number in blocker.parts],
        "reasons": {str(reason): count for reason, count in blocker.reasons},
    }


def funnel(candidates: tuple[Candidate, ...]) -> list[tuple[Stage, int, int]]:
    """For each stage how many candidates came to it, and how many it refused."""
    refused = Counter(c.verdict.stage for c in candidates if not c.verdict.is_ok)
    left = len(candidates)
    rows: list[tuple[Stage, int, int]] = []
    for stage in JUDGED:
        rows.append((stage, left, refused[stage]))
        left -= refused[stage]
    return rows


def _reasons(candidates: tuple[Candidate, ...], stage: Stage) -> str:
    counts = Counter(
        str(c.verdict.kind.message)
        for c in candidates
        if c.verdict.stage is stage and not c.verdict.is_ok
    )
    return ", ".join(f"{count} {reason}" for reason, count in counts.most_common())


def _fix_form(fix: Fix) -> dict[str, object]:
    return {
        **candidate_form(fix.candidate),
        "change": str(fix.change),
        "said": fix.change.program_form,
    }
