"""The jobs: what the worker process does.  Importing this imports all the heavy layers."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from workbench.app.calibration.ball_plate import simulated_sight
from workbench.app.calibration.simulated_checks import simulated_balls
from workbench.app.core.cycle.arm_scanner import view_problem
from workbench.app.core.cycle.correcting import CORRECT
from workbench.app.empty_hand.drop_back import plan_drop_back
from workbench.app.empty_hand.stirring import plan_stir
from workbench.app.empty_hand.tool_change import plan_tool_change
from workbench.app.empty_hand.view_plan import plan_view
from workbench.app.emptying.film import Filmed
from workbench.app.picking.exactness import with_exactness
from workbench.app.picking.glance import Glance, apply_change, glance_by_each_tcp
from workbench.app.picking.pallets import boxes_around
from workbench.app.picking.part_import import imported_part
from workbench.app.picking.row import plan_row
from workbench.app.picking.tool_making import tool_for
from workbench.app.runtime.readiness import make_ready
from workbench.app.runtime.worker import JobFunction
from workbench.app.standing.seen_again import with_sight
from workbench.formats.cells.reading import part_folders
from workbench.formats.parts.reading import read_part
from workbench.formats.parts.scales import round_shape
from workbench.model.calibration import BallScan, PlateObservation
from workbench.model.cell import Cell, Tool
from workbench.model.derived.assembling import standing_parts
from workbench.model.errors import InputError, JobCancelled
from workbench.model.messages.calibration import ScaleText
from workbench.model.messages.work import CancelText, JobText, ProgressText
from workbench.model.part import Part
from workbench.model.plan import PlanResult
from workbench.model.scan import LocalizationResult, Scan, Scene, SearchOverrides, Unexplained
from workbench.model.tools.held_body import HeldAmount
from workbench.perception.calibration.ball_scan import sight_balls
from workbench.perception.calibration.balls import sight_plate
from workbench.perception.parts.sizing import MOST_SEARCHES, learn_sizes, offset_of
from workbench.perception.scene.merging import merged
from workbench.perception.scene.own_robot import without_robot
from workbench.perception.scene.unexplained import look_around, unexplained
from workbench.planning.placing.assembling import base_errors
from workbench.plugins.localizer import find_parts as localized
from workbench.plugins.progress import Cancelled, Report
from workbench.plugins.scanner import ScanRequest, scanner_of
from workbench.proof.claims.moved import room_of_moved


def scan(cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled) -> Scan:
    """A scan by the cell's scanner; a simulated one sees `parts` parts dropped by `seed`.

    Where views are merged it is one with `earlier`, from other views.
    """
    request = ScanRequest(
        arguments["seed"],
        arguments["parts"],
        arguments.get("part", ""),
        arguments.get("lifted", ()),
    )
    found = scanner_of(cell).scan(request, report, cancelled)
    carrier = cell.scanner.on_arm
    if carrier is None:
        return found
    taken = as_taken(cell, found, arguments["joints"])
    if not carrier.merges_views:
        return taken
    return merged(cell, arguments.get("earlier"), taken, carrier.view.name)


def as_taken(cell: Cell, scan: Scan, joints: Mapping[str, float]) -> Scan:
    """The scan with the joints at which it was taken, the pose that follows, and no robot.

    Args:
        cell: whose scanner an arm carries; the scan stays as it is where it stands.
        scan: as the driver gives it.
        joints: name -> [rad, m] of all arms while it was taken.

    Raises:
        InputError: joints are missing, the arm stands elsewhere than at its view, or nothing is
            left of the scan.
    """
    if problem := view_problem(cell, joints):
        raise InputError(problem)
    carrier = cell.scanner.on_arm
    if carrier is None:
        return scan
    q = np.array([joints[name] for name in carrier.joints])
    T = carrier.T_world_scanner(cell.T_world_robot, cell.robot, q)
    return without_robot(replace(scan, T_world_scanner=T, joints=joints), cell)


def find_parts(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> LocalizationResult:
    """All parts of the cell, each kind found in `scan` with `seed`, the surest first."""
    overrides: SearchOverrides = arguments.get("overrides", SearchOverrides())
    return localized(
        arguments["scan"],
        cell,
        seed=arguments["seed"],
        detail=overrides.detail,
        least_score=overrides.least_score,
        report=report,
        cancelled=cancelled,
    )


def sight(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> PlateObservation:
    """The reference plate in a scan of the cell's scanner, with its `arm` at `q`."""
    arm, q, plate = cell.arm(arguments["arm"]), arguments["q"], arguments["plate"]
    report(0.1, ProgressText.SCANNER_LOOKS())
    if cell.scanner.source == "simulated":
        scan = simulated_sight(cell, arm, q, plate, seed=arguments["seed"])
    else:
        scan = scanner_of(cell).scan(ScanRequest(), report, cancelled)
    if cancelled():
        raise JobCancelled(CancelText.PLATE_SCAN())
    report(0.5, ProgressText.BALLS())
    return sight_plate(scan, plate, arguments["name"], arm.name, q)


def balls(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> BallScan:
    """The balls of an artefact in a scan of the cell's scanner, with its arm at `joints`."""
    carrier, artefact, seed = cell.scanner.on_arm, arguments["artefact"], arguments["seed"]
    report(0.1, ProgressText.SCANNER_LOOKS())
    if cell.scanner.source == "simulated":
        scan = simulated_balls(cell, artefact, seed=seed, joints=arguments["joints"])
    else:
        scan = scanner_of(cell).scan(ScanRequest(), report, cancelled)
    if cancelled():
        raise JobCancelled(CancelText.PLATE_SCAN())
    report(0.5, ProgressText.BALLS())
    joints = () if carrier is None else carrier.joints
    q = np.array([arguments["joints"][joint] for joint in joints])
    return sight_balls(scan, artefact, arguments["name"], q, seed)


def import_part(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> Part:
    """The part made of a CAD file, in the folder of parts of the working directory."""
    return imported_part(arguments["command"], report, cancelled)


def correct(cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled) -> Part:
    """The part of that name, read from its file in the size that `scan` shows, as `--learn` has it.

    Raises:
        InputError: the scan shows no other size, or one that is not allowed; no file is known.
    """
    name, file = arguments["part"], arguments["cell_file"]
    if file is None:
        raise InputError(JobText.NO_CELL_FILE())
    searches = 0

    def search(sized: Cell) -> LocalizationResult:
        nonlocal searches
        begun, searches = searches, searches + 1
        share = 1.0 / (MOST_SEARCHES + 1)
        return find_parts(
            sized, arguments, lambda done, note: report((begun + done) * share, note), cancelled
        )

    part = cell.part(name)
    findings, _, sizes = learn_sizes(cell, search, (name,))
    size, by = sizes.get(name, 1.0), offset_of(findings, name)
    folder = part_folders(file, [name])[name]
    shape = round_shape(folder / "part.toml", part.scale * size, part.offset + by)
    if (size, by) == (1.0, 0.0) or shape == (part.scale, part.offset):
        raise InputError(ScaleText.AS_IT_IS(part=name))
    report(MOST_SEARCHES / (MOST_SEARCHES + 1), ProgressText.READING())
    return read_part(folder, shape)


def make_tool(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> Tool:
    """The tool that is `drawn`, for the arm of that name."""
    return tool_for(cell, arguments["arm"], arguments["drawn"], report, cancelled)


def plan(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> PlanResult:
    """Candidates, plan and proof for `detections` in `scan`, if there is one; see `plan_row`.

    Refusals say so where only the bodies that stand for a part may be too near.
    """
    scan, detections = arguments["scan"], arguments["detections"]
    report(0.0, ProgressText.OBSTACLES())
    own = _own_scan(scan, arguments["scan_digest"])
    boxes = with_sight(cell, own, boxes_around(cell, arguments["placed"]))
    standing = standing_parts(cell, boxes)
    around = Unexplained() if scan is None else look_around(cell, scan, detections, standing)
    result = plan_row(
        cell,
        detections,
        arguments["scan_digest"],
        picks=arguments["overrides"].on(cell.policy).picks,
        strategy=arguments["strategy"],
        threshold=arguments["threshold"],
        overrides=arguments["overrides"],
        obstacles=(
            *around.seen,
            *boxes,
            *(room_of_moved(cell, part) for part in arguments.get("disturbed", ())),
        ),
        unseen=around.unseen,
        bases=base_errors(cell, arguments["placed"], boxes),
        avoided=dict(arguments["avoided"]),
        wanted=arguments["wanted"],
        seed=arguments["seed"],
        report=report,
        cancelled=cancelled,
    )
    return replace(result, candidates=with_exactness(cell, detections, result.candidates))


def _own_scan(scan: Scan | None, digest: str) -> Scan | None:
    """The scan where parts are of it; those from outside belong to no scan of this scanner."""
    return scan if scan is not None and scan.digest == digest else None


def view(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> PlanResult:
    """The path to the view and its proof; parts that were `placed` are in the way."""
    return plan_view(
        cell,
        view=arguments["view"],
        start=arguments["start"],
        placed=boxes_around(cell, arguments["placed"]),
        seed=arguments["seed"],
        report=report,
    )


def stir(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> PlanResult:
    """A hand that stirs the parts in the bin; what was `placed` is in the way."""
    scan, detections = arguments["scan"], arguments["detections"]
    boxes = boxes_around(cell, arguments["placed"])
    standing = standing_parts(cell, boxes)
    seen = () if scan is None else unexplained(cell, scan, detections, standing)
    obstacles = (*seen, *boxes)
    scene = Scene(arguments["scan_digest"], detections, obstacles)
    return plan_stir(cell, scene, seed=arguments["seed"], report=report)


def change(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> PlanResult:
    """An arm that changes its tool; parts that were `placed` are in the way."""
    return plan_tool_change(
        cell,
        arguments["arm"],
        arguments["tool"],
        placed=boxes_around(cell, arguments["placed"]),
        seed=arguments["seed"],
        report=report,
    )


def drop(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> PlanResult:
    """An arm that drops back what it holds; parts that were `placed` are in the way."""
    return plan_drop_back(
        cell,
        arguments["arm"],
        arguments["q"],
        HeldAmount(arguments["held"]),
        placed=boxes_around(cell, arguments["placed"]),
        seed=arguments["seed"],
        report=report,
    )


def glance(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> Glance:
    """How the candidates would be judged with `change` in the cell, the parts where they were.

    What stands around besides is `obstacles`; None: they are searched for `around`.  That holds the
    scan, the parts found, those that were put down, and the digest of the scene of the parts found.
    """
    obstacles = arguments["obstacles"]
    if obstacles is None:
        scan, found, placed, digest = arguments["around"]
        boxes = with_sight(cell, _own_scan(scan, digest), boxes_around(cell, placed))
        standing = standing_parts(cell, boxes)
        seen = () if scan is None else unexplained(cell, scan, found, standing)
        obstacles = (*seen, *boxes)
    changed = apply_change(cell, arguments["change"])
    avoided = dict(arguments["avoided"])
    return glance_by_each_tcp(changed, arguments["detections"], obstacles, avoided)


def emptying(
    cell: Cell, arguments: Mapping[str, Any], report: Report, cancelled: Cancelled
) -> Filmed:
    """Piles emptied in simulation, as the command `TryEmptying` wants them."""
    from workbench.app.emptying.piles import emptied_piles  # physics, which most sessions spare

    return emptied_piles(cell, arguments["command"], report, cancelled)


JOBS: Mapping[str, JobFunction] = {
    "scan": scan,
    "localize": find_parts,
    "sight": sight,
    "balls": balls,
    "plan": plan,
    "view": view,
    "stir": stir,
    "change": change,
    "drop": drop,
    "import": import_part,
    "tool": make_tool,
    CORRECT: correct,
    "emptying": emptying,
    "glance": glance,
}
"""By the names that `decide` gives them."""

GET_READY = make_ready
"""What comes before the first of them."""
