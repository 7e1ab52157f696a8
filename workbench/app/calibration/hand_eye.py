"""Where the scanner is, from pairs of poses that another program has taken."""

from collections.abc import Sequence

import pinocchio as pin

from workbench.app.calibration.calibration import check_in_own_frame, plate_mover
from workbench.formats.poses.hand_eye import PosePair
from workbench.model.calibration import BallPlate, Calibration
from workbench.model.cell import Cell
from workbench.model.derived.scanner_poses import flange_at_view
from workbench.model.errors import InputError
from workbench.model.geometry import transform
from workbench.perception.calibration.calibrate import MOST_POSES, calibrate
from workbench.perception.calibration.plate_poses import PlatePose


def calibrated_by_pairs(pairs: Sequence[PosePair], cell: Cell, *, in_hand: bool) -> Calibration:
    """The scanner's pose that fits pairs of a flange pose and a target pose.

    A target counts as three points of the size of the usual plate.

    Args:
        pairs: at least 4 different ones; of more than 60 every second, third, ... is used.
        cell: where the robot stands, and its view where it holds the scanner.
        in_hand: whether the robot holds the scanner; where the cell has none on an arm, its view
            counts as one with the flange at the robot's base.

    Raises:
        InputError: they are too few, too much alike, or do not agree.
    """
    check_in_own_frame(cell)
    try:
        return _solve(pairs, cell, in_hand=in_hand)
    except InputError as error:
        try:
            _solve(pairs, cell, in_hand=not in_hand)
        except InputError:
            raise error from None
        holds, hint = "holds", "state --in-hand"
        if in_hand:
            holds, hint = "does not hold", "leave out --in-hand"
        raise InputError(f"the robot {holds} the scanner in these pairs: {hint}") from None


def hand_at_view(cell: Cell) -> pin.SE3:
    """`T_world_flange` for which pairs of a scanner in the hand give the scanner's pose."""
    return cell.T_world_robot if cell.scanner.on_arm is None else flange_at_view(cell.scanner)


def _solve(pairs: Sequence[PosePair], cell: Cell, *, in_hand: bool) -> Calibration:
    centres, T_world_view = BallPlate().centres, hand_at_view(cell)
    poses: list[PlatePose] = []
    for pair in pairs[:: -(-len(pairs) // MOST_POSES)]:
        T = cell.T_world_robot * pair.T_base_flange
        T_camera_target = pair.T_camera_target
        balls = transform(T_camera_target, centres)
        if in_hand:
            mover, at = plate_mover(T, T_world_view), T_world_view.translation
        else:
            mover, at = T, None
        poses.append(PlatePose(pair.name, mover, balls, at=at))
    return calibrate(poses, centres)
