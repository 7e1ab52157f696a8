"""`workbench calibrate`: where the scanner hangs, from scans of a plate that the robot holds."""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.app.calibration.calibration import (
    calibrated,
    corner_errors,
    moved_by,
    with_calibration,
)
from workbench.app.calibration.held_plate import simulated_sight, suggested_poses
from workbench.app.calibration.next_pose import next_poses
from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_whole, print_json, print_table, progress
from workbench.formats.cells.calibrations import (
    FILE,
    ScannedPose,
    read_scanned_poses,
    write_scanned_poses,
)
from workbench.formats.cells.edits import log_change, save_cell
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.formats.files.whole_files import make_folder
from workbench.model.calibration import BallPlate, Calibration, NextPose, PlateObservation
from workbench.model.cell import Arm, Cell
from workbench.model.errors import InputError
from workbench.model.geometry import Floats, pose_from_rpy, shift_and_turn
from workbench.perception.calibration.balls import sight_plate

WRONG = pose_from_rpy((0.012, -0.008, 0.015), np.deg2rad((1.2, -0.8, 1.5)))
"""From where the cell has the scanner to where it truly hangs in a simulation."""

ADVISED, MOST = 8, 30


def calibrate(typed: arguments.Calibrate) -> int:
    """Find the plate in every scan, solve, compare with the cell, and save if asked to."""
    cell = read_cell(typed.cell)
    if typed.save and not typed.by.strip():
        raise InputError("--save needs --by NAME: who answers for the calibration")
    if typed.simulate:
        check_whole("--count", typed.count, 4, MOST)
        check_whole("--seed", typed.seed, 0, SEED_LIMIT - 1)
        _simulate(cell, typed)
    found = read_scanned_poses(typed.poses, cell)
    mount = replace(cell.scanner, unit=found.unit)
    observations: list[PlateObservation] = []
    missed: list[str] = []
    with progress("calibrate") as report:
        for number, pose in enumerate(found.poses):
            name = pose.scan.name
            report(number / len(found.poses), name)
            scan = read_scan(pose.scan, mount, key=f"`unit` in {FILE}, or that of the cell")
            try:
                observations.append(sight_plate(scan, found.plate, name, found.arm, pose.q))
            except InputError as error:
                missed.append(str(error))
    if not typed.json:
        for problem in missed:
            print(f"left out: {problem}")
    calibration = calibrated(cell, observations)
    following = _next(cell, observations, calibration) if typed.next else ()
    if typed.json:
        form = _form(cell, calibration, missed)
        if typed.next:
            form["next"] = [
                _next_form(cell.arm(found.arm), next_pose) for next_pose in following[:1]
            ]
        print_json(form)
    else:
        _print(cell, calibration)
        if typed.next:
            _print_next(cell.arm(found.arm), following)
        if typed.simulate:
            off = _true_pose(cell).actInv(calibration.T_world_scanner)
            print(f"off the truth of this simulation: {_between(off)}")
    if typed.save:
        _save(typed, cell, calibration)
    return SUCCESS


def _true_pose(cell: Cell) -> pin.SE3:
    return cell.scanner.T_world_scanner * WRONG


def _simulate(cell: Cell, typed: arguments.Calibrate) -> None:
    """Scans of the simulated cell, whose scanner hangs elsewhere than the cell says."""
    folder: Path = typed.poses
    if (folder / FILE).exists():
        raise InputError(f"{folder / FILE}: is there already; name another folder for --simulate")
    arm, plate = cell.arms[0], BallPlate()
    seen = replace(cell, scanner=replace(cell.scanner, T_world_scanner=_true_pose(cell)))
    with progress("calibrate") as report:
        make_ready(report, ("planning",))
    qs = suggested_poses(seen, arm, plate, typed.count, seed=typed.seed)
    if len(qs) < typed.count:
        raise InputError(
            f"cell {cell.name}: the scanner sees the plate in {len(qs)} poses of the {arm.name} "
            f"arm only, {typed.count} are wanted"
        )
    poses = [ScannedPose(folder / f"pose_{k + 1}.ply", q) for k, q in enumerate(qs)]
    make_folder(folder)
    with progress("simulate") as report:
        for number, pose in enumerate(poses):
            report(number / len(poses), pose.scan.name)
            scan = simulated_sight(seen, arm, pose.q, plate, seed=typed.seed + number)
            write_cloud(pose.scan, scan, axes=cell.scanner.cloud_axes)
    write_scanned_poses(folder, arm, plate, poses)


def _save(typed: arguments.Calibrate, cell: Cell, calibration: Calibration) -> None:
    at, path = time.time(), cell_path(typed.cell)
    calibrated_cell = with_calibration(cell, calibration, at, typed.by)
    save_cell(path, calibrated_cell)
    says = f"calibrated by {calibration.used} poses, {calibration.rms * 1000:.2f} mm"
    log_change(path, read_cell(path), typed.by, at, says)
    if not typed.json:
        print(f"saved into {path}")


def _next(
    cell: Cell, observations: list[PlateObservation], calibration: Calibration
) -> tuple[NextPose, ...]:
    with progress("calibrate") as report:
        make_ready(report, ("planning",))
    return next_poses(cell, observations, calibration, seed=len(observations))


def _print_next(arm: Arm, following: tuple[NextPose, ...]) -> None:
    if not following:
        print(f"next: the {arm.name} arm reaches no other pose in which the plate is seen")
        return
    best = following[0]
    print(
        f"next, from {best.after}: {', '.join(best.steps)}; that would bring the worst corner from "
        f"{best.error * 1000:.2f} to {best.error_with * 1000:.2f} mm"
    )
    print(f"joints_deg = {_list(np.rad2deg(arm.to_axes(best.q)), 1)}")


def _next_form(arm: Arm, pose: NextPose) -> dict[str, object]:
    return {
        "after": pose.after,
        "steps": list(pose.steps),
        "joints_deg": [round(float(value), 2) for value in np.rad2deg(arm.to_axes(pose.q))],
        "largest_corner_mm": round(pose.error_with * 1000, 4),
    }


def _print(cell: Cell, calibration: Calibration) -> None:
    rows = (
        (
            residual.name,
            f"{residual.distance * 1000:.2f}",
            f"{np.rad2deg(residual.angle):.2f}",
            *_format_prediction(residual.predicted),
            residual.light if not residual.left_out else "left out",
            residual.left_out,
        )
        for residual in calibration.residuals
    )
    print_table(
        f"{calibration.used} poses, {calibration.rms * 1000:.2f} mm RMS",
        ("pose", "off mm", "off deg", "others mm", "others deg", "light", "why"),
        rows,
    )
    worst, all_of_them = calibration.worst_predicted, calibration.predicted_rms
    if worst is not None and all_of_them is not None:
        print(
            "others: each pose as all the others predict it, "
            f"{' mm, '.join(_format_prediction(all_of_them))} degrees RMS; "
            f"the worst is {worst.name}, "
            f"{' mm, '.join(_format_prediction(worst.predicted))} degrees"
        )
    T = calibration.T_world_scanner
    rpy = np.rad2deg(pin.rpy.matrixToRpy(T.rotation))
    print(f"position_mm = {_list(T.translation * 1000, 2)}")
    print(f"rpy_deg = {_list(rpy, 3)}")
    print(
        f"sure to {calibration.position_error * 1000:.2f} mm and "
        f"{np.rad2deg(calibration.angle_error):.3f} degrees (standard errors, worst direction)"
    )
    errors = corner_errors(cell, calibration.covariance, T)
    print_table(
        f"what lies at the corners of the bin is seen to {max(errors.values()) * 1000:.2f} mm or "
        "better in 95% of such calibrations",
        ("corner", "mm"),
        ((name, f"{error * 1000:.2f}") for name, error in errors.items()),
    )
    before = cell.scanner.T_world_scanner.actInv(T)
    shift = moved_by(cell, calibration)[2]
    print(
        f"from where the cell has it: {_between(before)}; what lies in the bin moves by "
        f"{shift * 1000:.2f} mm"
    )
    if calibration.used < ADVISED:
        print(f"{ADVISED} poses are better than {calibration.used}")


def _form(cell: Cell, calibration: Calibration, missed: list[str]) -> dict[str, object]:
    distance, angle, shift = moved_by(cell, calibration)
    errors = corner_errors(cell, calibration.covariance, calibration.T_world_scanner)
    return {
        "ok": True,
        "T_world_scanner": calibration.T_world_scanner.homogeneous.tolist(),
        "poses": [
            {
                "name": residual.name,
                "off_mm": round(residual.distance * 1000, 4),
                "off_deg": round(float(np.rad2deg(residual.angle)), 4),
                "predicted_mm": _round(residual.predicted, 0),
                "predicted_deg": _round(residual.predicted, 1),
                "light": residual.light,
                "left_out": residual.left_out,
            }
            for residual in calibration.residuals
        ],
        "not_seen": missed,
        "rms_mm": round(calibration.rms * 1000, 4),
        "position_error_mm": round(calibration.position_error * 1000, 4),
        "angle_error_deg": round(float(np.rad2deg(calibration.angle_error)), 5),
        "predicted_rms_mm": _round(calibration.predicted_rms, 0),
        "predicted_rms_deg": _round(calibration.predicted_rms, 1),
        "covariance": calibration.covariance.tolist(),
        "corners_mm": {name: round(error * 1000, 4) for name, error in errors.items()},
        "largest_corner_mm": round(max(errors.values()) * 1000, 4),
        "moved_mm": round(distance * 1000, 4),
        "moved_deg": round(float(np.rad2deg(angle)), 5),
        "moved_in_bin_mm": round(shift * 1000, 4),
    }


def _format_prediction(off: tuple[float, float] | None) -> tuple[str, str]:
    """In mm and degrees; the others may leave a pose open."""
    if off is None:
        return "open", "open"
    return f"{off[0] * 1000:.2f}", f"{np.rad2deg(off[1]):.2f}"


def _round(off: tuple[float, float] | None, which: int) -> float | None:
    """In mm (0) or degrees (1)."""
    if off is None:
        return None
    return round(float((off[0] * 1000, np.rad2deg(off[1]))[which]), 4)


def _between(T: pin.SE3) -> str:
    distance, angle = shift_and_turn(T)
    return f"{distance * 1000:.2f} mm and {np.rad2deg(angle):.3f} degrees"


def _list(values: Floats, digits: int) -> str:
    return f"[{', '.join(f'{value + 0.0:.{digits}f}' for value in values)}]"
