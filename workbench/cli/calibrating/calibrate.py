"""`workbench calibrate`: where the scanner hangs, from scans of a plate.

The robot holds the plate, or carries the scanner.
"""

import time
from dataclasses import replace
from pathlib import Path

import numpy as np
import pinocchio as pin

from workbench.app.calibration.ball_plate import simulated_sight, suggested_poses
from workbench.app.calibration.calibration import compute_calibration, with_calibration
from workbench.app.calibration.hand_eye import hand_at_view
from workbench.app.calibration.next_pose import next_poses
from workbench.app.core.value_checks import SEED_LIMIT
from workbench.app.runtime.readiness import make_ready
from workbench.cli.arguments import top as arguments
from workbench.cli.calibrating.pairs import calibrate_by_pairs, is_pairs
from workbench.cli.calibrating.report import (
    format_numbers,
    in_cell_form,
    in_flange,
    poses_form,
    print_in_cell,
    print_poses,
    words_of_motion,
)
from workbench.cli.exits import SUCCESS
from workbench.cli.terminal import check_whole, print_json, progress
from workbench.formats.cells.calibrations import (
    CALIBRATION_FILE,
    ScannedPose,
    read_scanned_poses,
    write_scanned_poses,
)
from workbench.formats.cells.edits import log_change, save_cell
from workbench.formats.cells.reading import cell_path, read_cell
from workbench.formats.clouds.scans import read_scan, write_cloud
from workbench.formats.files.whole_files import make_folder
from workbench.formats.poses.hand_eye import write_scanner_pose
from workbench.model.calibration import BallPlate, Calibration, NextPose, PlateObservation
from workbench.model.cell import Arm, Cell
from workbench.model.derived.controller_axes import shown_axes
from workbench.model.derived.scanner_poses import with_scanner_at
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.perception.calibration.balls import sight_plate

WRONG = pose_from_rpy((0.012, -0.008, 0.015), np.deg2rad((1.2, -0.8, 1.5)))
"""From where the cell has the scanner to where it truly hangs in a simulation."""

MOST_POSES = 30
"""Poses that are simulated."""


def calibrate(typed: arguments.Calibrate) -> int:
    """Find the plate in every scan, solve, compare with the cell, and save if asked to."""
    cell = read_cell(typed.cell)
    if typed.save and not typed.by.strip():
        raise InputError("--save needs --by NAME: who answers for the calibration")
    if is_pairs(typed.poses):
        return _by_pairs(typed, cell)
    if typed.in_hand and cell.scanner.on_arm is None:
        raise InputError(f"the scanner of cell {cell.name} stands: --in-hand is for pairs")
    if typed.simulate:
        check_whole("--count", typed.count, 4, MOST_POSES)
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
            scan = read_scan(
                pose.scan, mount, key=f"`unit` in {CALIBRATION_FILE}, or that of the cell"
            )
            try:
                observations.append(sight_plate(scan, found.plate, name, found.arm, pose.q))
            except InputError as error:
                missed.append(str(error))
    if not typed.json:
        for problem in missed:
            print(f"left out: {problem}")
    calibration = compute_calibration(cell, observations)
    following = _next(cell, observations, calibration) if typed.next else ()
    if typed.json:
        form = poses_form(calibration) | in_cell_form(cell, calibration) | {"not_seen": missed}
        if typed.next:
            form["next"] = [
                _next_form(cell, cell.arm(found.arm), next_pose) for next_pose in following[:1]
            ]
        print_json(form)
    else:
        print_poses(calibration, in_flange(cell, calibration))
        print_in_cell(cell, calibration)
        if typed.next:
            _print_next(cell, cell.arm(found.arm), following)
        if typed.simulate:
            off = _true_pose(cell).actInv(calibration.T_world_scanner)
            print(f"off the truth of this simulation: {words_of_motion(off)}")
    return _store(typed, cell, calibration)


def _by_pairs(typed: arguments.Calibrate, cell: Cell) -> int:
    """The same by pairs of poses of another program."""
    carrier = cell.scanner.on_arm
    if carrier is not None and not typed.in_hand:
        raise InputError(
            f"the scanner of cell {cell.name} hangs on the {carrier.arm} arm: state --in-hand"
        )
    if typed.simulate or typed.next:
        raise InputError(f"{typed.poses} holds pairs of poses: --simulate and --next need scans")
    if typed.save and typed.in_hand and carrier is None:
        raise InputError("--save with --in-hand needs [scanner.on_arm] in the cell file")
    calibration = calibrate_by_pairs(typed, cell)
    return _store(typed, cell, calibration)


def _store(typed: arguments.Calibrate, cell: Cell, calibration: Calibration) -> int:
    """Save the calibration into the cell file, and write it for another program, if asked to."""
    if typed.save:
        _save(typed, cell, calibration)
    if typed.write is not None:
        in_hand = typed.in_hand or cell.scanner.on_arm is not None
        T_world_base = hand_at_view(cell) if in_hand else cell.T_world_robot
        T = T_world_base.actInv(calibration.T_world_scanner)
        write_scanner_pose(typed.write, T, typed.style, in_hand=in_hand)
        if not typed.json:
            print(f"written to {typed.write}")
    return SUCCESS


def _true_pose(cell: Cell) -> pin.SE3:
    return cell.scanner.T_world_scanner * WRONG


def _simulate(cell: Cell, typed: arguments.Calibrate) -> None:
    """Scans of the simulated cell, whose scanner hangs elsewhere than the cell says."""
    folder: Path = typed.poses
    if (folder / CALIBRATION_FILE).exists():
        raise InputError(
            f"{folder / CALIBRATION_FILE}: is there already; name another folder for --simulate"
        )
    carrier, plate = cell.scanner.on_arm, BallPlate()
    arm = cell.arms[0] if carrier is None else cell.arm(carrier.arm)
    seen = with_scanner_at(cell, _true_pose(cell))
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
    write_scanned_poses(folder, cell, arm, plate, poses)


def _save(typed: arguments.Calibrate, cell: Cell, calibration: Calibration) -> None:
    at, path = time.time(), cell_path(typed.cell)
    save_cell(path, with_calibration(cell, calibration, at, typed.by))
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


def _print_next(cell: Cell, arm: Arm, following: tuple[NextPose, ...]) -> None:
    if not following:
        print(f"next: the {arm.name} arm reaches no other pose in which the plate is seen")
        return
    best = following[0]
    print(
        f"next, from {best.after}: {', '.join(map(str, best.steps))}; "
        f"that would bring the worst corner from {best.error * 1000:.2f} "
        f"to {best.error_with * 1000:.2f} mm"
    )
    print(f"joints_deg = {format_numbers(shown_axes(cell, arm, best.q), 1)}")


def _next_form(cell: Cell, arm: Arm, pose: NextPose) -> dict[str, object]:
    return {
        "after": pose.after,
        "steps": list(pose.steps),
        "joints_deg": [round(float(value), 2) for value in shown_axes(cell, arm, pose.q)],
        "largest_corner_mm": round(pose.error_with * 1000, 4),
    }
