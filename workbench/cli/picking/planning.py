"""`workbench plan`: a proven plan in a file, or why there is none."""

import time
from pathlib import Path

import numpy as np

from workbench.app.core.value_checks import (
    LARGEST_MARGIN,
    MOST_ITERATIONS,
    SEED_LIMIT,
    check_configuration,
)
from workbench.app.empty_hand.drop_back import plan_drop_back
from workbench.app.empty_hand.stirring import plan_stir
from workbench.app.empty_hand.tool_change import plan_tool_change
from workbench.app.empty_hand.view_plan import plan_view
from workbench.app.picking.row import check_picks, plan_row
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.exits import NO_PLAN, SUCCESS
from workbench.cli.picking.results import (
    candidate_form,
    plan_form,
    plan_words,
    print_candidates,
    proof_form,
    proof_words,
    reasons_words,
    stages_words,
)
from workbench.cli.terminal import (
    check_number,
    check_whole,
    milliseconds,
    print_json,
    progress,
    seconds_since_start,
)
from workbench.formats.cells.reading import read_cell
from workbench.formats.clouds.scans import read_scan
from workbench.formats.plans.plan_files import write_plan
from workbench.formats.plans.pose_files import read_poses
from workbench.model.cell import MOST_PICKS, Arm, Cell, PlanOverrides
from workbench.model.derived.by_recipe import as_chosen, check_strategy, strategy_of, wanted_parts
from workbench.model.derived.by_view import by_each_view
from workbench.model.derived.controller_axes import from_shown
from workbench.model.derived.row_parts import parts_taken
from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Floats
from workbench.model.plan import Plan, PlanResult
from workbench.model.recipes.recipe import NO_RECIPE
from workbench.model.robot import HOME
from workbench.model.scan import Detection, Scene, Unexplained
from workbench.model.tools.held_body import HeldAmount, recipe_problem
from workbench.model.tools.slots import arm_with_slot
from workbench.plugins.planner import planner_named
from workbench.plugins.robot_link import spoken_to_by


def plan(typed: arguments.PlanArguments) -> int:
    """Plan for poses, a view, another tool, a drop back; write it only when its proof holds."""
    check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
    if typed.drop_back is not None:
        return _plan_drop_back(typed, typed.drop_back)
    if typed.tool is not None:
        return _plan_tool_change(typed, typed.tool)
    if typed.poses is None and typed.view is None:
        raise InputError("--poses, --view, --tool or --drop-back is expected")
    return _plan_view(typed) if typed.poses is None else _plan_picks(typed, typed.poses)


def _plan_view(typed: arguments.PlanArguments) -> int:
    """Plan the path to the view by the cell's policy."""
    cell = _chosen(typed)
    if typed.protocol is not None:
        cell = spoken_to_by(cell, typed.protocol)
    with progress("plan") as report:
        make_ready(report, ("planning",))
        ready, began = seconds_since_start(), time.perf_counter()
        result = plan_view(
            cell, view=typed.view or "", start=typed.start, seed=typed.seed, report=report
        )
        planning = time.perf_counter() - began
    return _finish(typed, result, ready, planning)


def _plan_tool_change(typed: arguments.PlanArguments, tool: str) -> int:
    """Plan how an arm puts down its tool and takes another one."""
    cell = _chosen(typed)
    if typed.protocol is not None:
        cell = spoken_to_by(cell, typed.protocol)
    arm = typed.strategy or arm_with_slot(cell, tool)
    with progress("plan") as report:
        make_ready(report, ("planning",))
        ready, began = seconds_since_start(), time.perf_counter()
        result = plan_tool_change(cell, arm, tool, seed=typed.seed, report=report)
        planning = time.perf_counter() - began
    return _finish(typed, result, ready, planning)


def _plan_drop_back(typed: arguments.PlanArguments, amount: str) -> int:
    """Plan how an arm drops back what it holds."""
    cell = _chosen(typed)
    if problem := recipe_problem(read_cell(typed.cell), cell):
        raise InputError(problem)
    if typed.protocol is not None:
        cell = spoken_to_by(cell, typed.protocol)
    arm = cell.arm(typed.strategy) if typed.strategy else cell.arms[0]
    q = arm.home if typed.joints is None else _joints_of(cell, arm, typed.joints)
    with progress("plan") as report:
        make_ready(report, ("planning",))
        ready, began = seconds_since_start(), time.perf_counter()
        held = HeldAmount(amount)
        result = plan_drop_back(cell, arm.name, q, held, seed=typed.seed, report=report)
        planning = time.perf_counter() - began
    return _finish(typed, result, ready, planning)


def _joints_of(cell: Cell, arm: Arm, typed: str) -> Floats:
    """Where an arm stands (n,) [rad, m], from axes [deg, mm] as its controller shows them."""
    words = typed.split(",")
    try:
        axes = np.array([float(word) for word in words])
    except ValueError:
        axes = np.empty(0)
    if len(axes) != len(arm.joints) or not np.isfinite(axes).all():
        raise InputError(f"--joints: {len(arm.joints)} numbers with commas are expected")
    q = from_shown(cell, arm, axes)
    check_configuration(cell, arm.name, q)
    return q


def _chosen(typed: arguments.PlanArguments) -> Cell:
    """The cell by the recipe, bin and view that are asked for."""
    view = "" if typed.view in (None, HOME) else typed.view
    return as_chosen(read_cell(typed.cell), typed.recipe, typed.bin, view)


def _plan_picks(typed: arguments.PlanArguments, poses: Path) -> int:
    """Plan for the poses in a file."""
    if typed.threshold is not None:
        check_number("--threshold", typed.threshold, 0.0, 1.0)
    if typed.iterations is not None:
        check_whole("--iterations", typed.iterations, 1, MOST_ITERATIONS)
    cell = _chosen(typed)
    if typed.protocol is not None:
        cell = spoken_to_by(cell, typed.protocol)
    strategy = typed.strategy or strategy_of(cell)
    check_strategy(cell, strategy)
    picks = cell.policy.picks if typed.picks is None else typed.picks
    check_whole("--picks", picks, 1, MOST_PICKS)
    check_picks(cell, picks)
    if typed.margin is not None:
        check_number("--margin", typed.margin, cell.policy.margin, LARGEST_MARGIN)
    if typed.metric is not None:
        check_number("--metric", typed.metric, 0.05, 1.0)
    if typed.planner is not None:
        planner_named(typed.planner)
    overrides = PlanOverrides(
        typed.planner, typed.iterations, typed.order, typed.margin, typed.metric
    )
    detections = detections_from(cell, poses, typed.part)
    if typed.stir:
        return _plan_stir(typed, cell, detections)
    with progress("plan") as report:
        make_ready(report, ("planning",))
        around = around_in(cell, typed.scan, detections)
        ready, began = seconds_since_start(), time.perf_counter()
        result = plan_row(
            cell,
            detections,
            digest_of(detections),
            picks=picks,
            strategy=strategy,
            threshold=typed.threshold,
            overrides=overrides,
            obstacles=around.seen,
            unseen=around.unseen,
            wanted=wanted_parts(cell),
            seed=typed.seed,
            report=report,
        )
        planning = time.perf_counter() - began
    return _finish(typed, result, ready, planning)


def _plan_stir(
    typed: arguments.PlanArguments, cell: Cell, detections: tuple[Detection, ...]
) -> int:
    """Plan how an arm stirs the parts at these poses."""
    with progress("plan") as report:
        make_ready(report, ("planning",))
        around = around_in(cell, typed.scan, detections)
        ready, began = seconds_since_start(), time.perf_counter()
        scene = Scene(digest_of(detections), detections, around.seen)
        result = plan_stir(cell, scene, seed=typed.seed, report=report)
        planning = time.perf_counter() - began
    return _finish(typed, result, ready, planning)


def _finish(
    typed: arguments.PlanArguments, result: PlanResult, ready: float, planning: float
) -> int:
    """Write what is proven, and print what came of it."""
    if result.is_proven and result.plan is not None:
        write_plan(typed.out, result.plan, result.proof)
        for number, proven_plan in enumerate(result.row, 2):
            write_plan(_file_of(typed.out, number), proven_plan.plan, proven_plan.proof)
    if typed.json:
        _print_form(typed.out, result, ready, planning)
    else:
        _print_words(typed.out, result, ready, planning)
    return SUCCESS if result.is_proven else NO_PLAN


def _file_of(out: Path, number: int) -> Path:
    """The file of a plan of a row: `plan.json`, `plan-2.json`, ..."""
    return out.with_name(f"{out.stem}-{number}{out.suffix}")


def cell_of(plan: Plan, name: str | None) -> Cell:
    """The cell that a plan was made for, found by the name in it unless another one is given.

    Where one of its recipes, bins and views makes the cell that the plan names by its digest, that
    is it.

    Raises:
        InputError: there is no such cell.
    """
    try:
        cell = read_cell(plan.cell if name is None else name)
        numbers = (NO_RECIPE, *(recipe.number for recipe in cell.recipes))
        by_bin = (as_chosen(cell, n, box.name) for n in numbers for box in cell.bins)
        by_view = (chosen for known in by_bin for chosen in by_each_view(known))
        return next((chosen for chosen in by_view if chosen.digest == plan.cell_digest), cell)
    except InputError as error:
        if name is not None:
            raise
        raise InputError(f"the cell of the plan: {error}; name its file with --cell") from error


def detections_from(cell: Cell, poses: Path, part: str | None) -> tuple[Detection, ...]:
    """The poses in a file, of parts that the cell knows.

    Args:
        cell: with its parts.
        poses: our JSON or a HALCON tuple file.
        part: what the poses of a HALCON file are of; None when the cell has a single part.

    Raises:
        InputError: the file cannot be read, or it is not known of what its poses are.
    """
    if part is None and len(cell.parts) == 1:
        part = cell.parts[0].name
    detections = read_poses(poses, part or "")
    if any(not detection.part for detection in detections):
        known = ", ".join(known_part.name for known_part in cell.parts)
        raise InputError(f"{poses}: does not say of what its poses are; add --part ({known})")
    for detection in detections:
        cell.part(detection.part)
    return detections


def around_in(
    cell: Cell,
    scan: Path | None,
    detections: tuple[Detection, ...],
    standing: tuple[Detection, ...] = (),
) -> Unexplained:
    """What a scan in a file shows besides the parts; nothing without a scan.

    Args:
        cell: bin and fixtures.
        scan: the file.
        detections: the parts found in it.
        standing: parts that stand in an assembly.
    """
    if scan is None:
        return Unexplained()
    # Brings Open3D along, which takes longer to load than a plan takes.
    from workbench.perception.scene.unexplained import look_around

    return look_around(cell, read_scan(scan, cell.scanner), detections, standing)


def _print_form(out: Path, result: PlanResult, ready: float, planning: float) -> None:
    print_json(
        {
            "ok": result.is_proven,
            "file": str(out) if result.is_proven else None,
            "verdict": str(result.verdict),
            "said": result.verdict.message.program_form,
            "plan": None if result.plan is None else plan_form(result.plan, result.bound),
            "proof": None if result.proof is None else proof_form(result.proof),
            "beside": [
                None if other.plan is None else plan_form(other.plan, other.bound)
                for other in result.beside
            ],
            "row": [
                {
                    "file": str(_file_of(out, number)),
                    "plan": plan_form(proven_plan.plan, 0.0),
                    "parts": parts_taken(result.plans[0], proven_plan.plan),
                    "proof": proof_form(proven_plan.proof),
                }
                for number, proven_plan in enumerate(result.row, 2)
            ],
            "row_ends": None if result.row_ends is None else result.row_ends.program_form,
            "obstacles": len(result.obstacles),
            "candidates": [candidate_form(candidate) for candidate in result.candidates],
            "start_ms": milliseconds(ready),
            "planning_ms": milliseconds(planning),
            "stages_ms": {stage: milliseconds(s) for stage, s in result.seconds.items()},
        }
    )


def _print_words(out: Path, result: PlanResult, ready: float, planning: float) -> None:
    if not result.is_proven:
        print_candidates("every candidate", result.candidates)
    if result.candidates:
        print(f"candidates: {reasons_words(result.candidates)}")
    if result.plan is not None and result.plan.is_drop_plan:
        print("kept clear of the whole bin, which no scan shows, except on the way up out of it")
    elif result.plan is not None and (result.plan.is_view_plan or result.plan.is_tool_plan):
        print("kept clear of the whole bin, which no scan shows")
    elif result.plan is not None and result.plan.is_stir_plan:
        print("kept clear of all but what lies in the bin, which the hand stirs")
    elif result.obstacles:
        print(f"kept clear of {len(result.obstacles)} obstacles that only the scan shows")
    if result.plan is None:
        print(f"no plan: {result.verdict}")
    else:
        file = out if result.is_proven else "not written"
        print(f"{file}: {plan_words(result.plan, result.bound)}")
    if result.proof is not None:
        print(proof_words(result.proof))
    for number, proven_plan in enumerate(result.row, 2):
        first = result.plans[0]
        print(f"then {_file_of(out, number)}: {plan_words(proven_plan.plan, 0.0, first)}")
        print(proof_words(proven_plan.proof, proven_plan.plan, first))
    if result.row_ends:
        print(f"nothing in a row after that: {result.row_ends}")
    for other in result.beside:
        print(f"beside it: {_beside_words(other)}")
    print(f"start {milliseconds(ready)} ms: interpreter, libraries, cell")
    print(f"planning {milliseconds(planning)} ms: {stages_words(result.seconds)}")


def _beside_words(other: PlanResult) -> str:
    if other.plan is None:
        return f"no plan: {other.verdict}"
    words = plan_words(other.plan, other.bound)
    return words if other.is_proven else f"{words}; its proof does not hold"
