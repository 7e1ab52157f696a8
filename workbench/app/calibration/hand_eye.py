"""Where the scanner is, from pairs of poses that another program has taken."""

from collections.abc import Sequence

import pinocchio as pin

from workbench.formats.poses.hand_eye import PosePair
from workbench.model.calibration import BallPlate, Calibration
from workbench.model.errors import InputError
from workbench.perception.calibration.calibrate import MOST, calibrate
from workbench.perception.calibration.plate_poses import PlatePose


def calibrated_by_pairs(
    pairs: Sequence[PosePair], T_world_base: pin.SE3, *, in_hand: bool
) -> Calibration:
    """The scanner's pose that fits pairs of a flange pose and a target pose.

    A target counts as three points of the size of the usual plate.  Where the robot holds the
    scanner, base and flange change places: the flange is the world, and what moves is the base.

    Args:
        pairs: at least 4 different ones; of more than 60 every second, third, ... is used.
        T_world_base: where the robot stands; not used where it holds the scanner.
        in_hand: whether the robot holds the scanner.

    Returns:
        `T_world_scanner` is `T_flange_scanner` where the robot holds the scanner, and
        `T_flange_plate` is `T_base_target` then.

    Raises:
        InputError: they are too few, too much alike, or do not agree.
    """
    try:
        return _solve(pairs, T_world_base, in_hand=in_hand)
    except InputError as error:
        try:
            _solve(pairs, T_world_base, in_hand=not in_hand)
        except InputError:
            raise error from None
        holds, hint = "holds", "state --in-hand"
        if in_hand:
            holds, hint = "does not hold", "leave out --in-hand"
        raise InputError(f"the robot {holds} the scanner in these pairs: {hint}") from None


def _solve(pairs: Sequence[PosePair], T_world_base: pin.SE3, *, in_hand: bool) -> Calibration:
    centres = BallPlate().centres
    poses = [
        PlatePose(
            pair.name,
            pair.T_base_flange.inverse() if in_hand else T_world_base * pair.T_base_flange,
            centres @ pair.T_camera_target.rotation.T + pair.T_camera_target.translation,
        )
        for pair in pairs[:: -(-len(pairs) // MOST)]
    ]
    return calibrate(poses, centres)
