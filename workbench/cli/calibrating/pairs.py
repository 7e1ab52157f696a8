"""`workbench calibrate` by pairs of a flange pose and a target pose of another program."""

from pathlib import Path

import numpy as np

from workbench.app.calibration.hand_eye import calibrated_by_pairs, hand_at_view
from workbench.cli.arguments.top import Calibrate
from workbench.cli.calibrating.report import (
    in_cell_form,
    poses_form,
    print_in_cell,
    print_poses,
)
from workbench.cli.terminal import print_json
from workbench.formats.cells.calibrations import CALIBRATION_FILE
from workbench.formats.files.units import UNITS
from workbench.formats.files.whole_files import is_folder
from workbench.formats.poses.conventions import convention
from workbench.formats.poses.hand_eye import ZIVID, read_pairs
from workbench.model.calibration import Calibration
from workbench.model.cell import Cell


def is_pairs(path: Path) -> bool:
    """Whether this is a file of pairs, or a folder of Zivid's, and no folder of scans."""
    if not is_folder(path):
        return path.is_file()
    return not (path / CALIBRATION_FILE).exists() and any(path.glob(ZIVID[0]))


def calibrate_by_pairs(typed: Calibrate, cell: Cell) -> Calibration:
    """Read the pairs, solve, and print what was found."""
    written = None if typed.format is None else convention(typed.format)
    pairs = read_pairs(typed.poses, in_hand=typed.in_hand, unit=UNITS[typed.unit], written=written)
    calibration = calibrated_by_pairs(pairs, cell, in_hand=typed.in_hand)
    used = len(calibration.residuals)
    is_of_cell = typed.in_hand == (cell.scanner.on_arm is not None)
    T_world_hand, T_flange_scanner = hand_at_view(cell), None
    if typed.in_hand:
        T_flange_scanner = T_world_hand.actInv(calibration.T_world_scanner)
    if typed.json:
        form = poses_form(calibration)
        if T_flange_scanner is None:
            form |= {"T_flange_target": calibration.T_flange_plate.homogeneous.tolist()}
        else:
            T_base_target = cell.T_world_robot.actInv(T_world_hand * calibration.T_flange_plate)
            form |= {"T_base_target": T_base_target.homogeneous.tolist()}
            form |= {"T_flange_scanner": T_flange_scanner.homogeneous.tolist()}
        form |= in_cell_form(cell, calibration) if is_of_cell else {}
        print_json(form | {"pairs": len(pairs)})
        return calibration
    if used < len(pairs):
        print(f"{used} of {len(pairs)} pairs, evenly spread, are used")
    print_poses(calibration, T_flange_scanner)
    if T_flange_scanner is not None:
        far = np.linalg.norm(T_flange_scanner.translation) * 1000
        print(f"the scanner is {far:.1f} mm from the flange")
    if is_of_cell:
        print_in_cell(cell, calibration)
    return calibration
