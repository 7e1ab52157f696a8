"""`workbench calibrate` by pairs of a flange pose and a target pose of another program."""

from pathlib import Path

import numpy as np

from workbench.app.calibration.hand_eye import calibrated_by_pairs
from workbench.cli.arguments.top import Calibrate
from workbench.cli.calibrating.report import (
    in_cell_form,
    poses_form,
    print_in_cell,
    print_poses,
)
from workbench.cli.terminal import print_json
from workbench.formats.cells.calibrations import FILE
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
    return not (path / FILE).exists() and any(path.glob(ZIVID[0]))


def calibrate_by_pairs(typed: Calibrate, cell: Cell) -> Calibration:
    """Read the pairs, solve, and print what was found."""
    written = None if typed.format is None else convention(typed.format)
    pairs = read_pairs(typed.poses, in_hand=typed.in_hand, unit=UNITS[typed.unit], written=written)
    calibration = calibrated_by_pairs(pairs, cell.T_world_robot, in_hand=typed.in_hand)
    used = len(calibration.residuals)
    if typed.json:
        form = poses_form(calibration)
        held = "T_base_target" if typed.in_hand else "T_flange_target"
        form |= {held: calibration.T_flange_plate.homogeneous.tolist()}
        if typed.in_hand:
            form |= {"T_flange_scanner": calibration.T_world_scanner.homogeneous.tolist()}
        else:
            form |= in_cell_form(cell, calibration)
        print_json(form | {"pairs": len(pairs)})
        return calibration
    if used < len(pairs):
        print(f"{used} of {len(pairs)} pairs, evenly spread, are used")
    if typed.in_hand:
        print("the robot holds the scanner: its pose below is that in the flange")
    print_poses(calibration)
    if typed.in_hand:
        far = np.linalg.norm(calibration.T_world_scanner.translation) * 1000
        print(f"the scanner is {far:.1f} mm from the flange")
    else:
        print_in_cell(cell, calibration)
    return calibration
