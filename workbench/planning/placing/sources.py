"""What is not known of where a part lies in the bin, by where it comes from.

All are covariances (6, 6) [m, rad] of shifts of the part's origin, then of turns about it, along
the world's axes, as `Detection` has it.
"""

import numpy as np

from workbench.model.cell import ScannerMount
from workbench.model.derived.scanner_poses import calibration_covariance
from workbench.model.geometry import Floats
from workbench.model.scan import Detection

CALIBRATION = (0.0005, float(np.deg2rad(0.05)))
"""[m, rad] Deviations of the scanner's place and of its direction, along any axis, where no
calibration says them: those of one by six poses of a plate."""

LOCALIZATION = (0.001, float(np.deg2rad(1.0)))
"""[m, rad] Deviations of a pose that comes without any, along any axis."""


def calibration_error(mount: ScannerMount, detection: Detection) -> Floats:
    """What the scanner's pose leaves open (6, 6) [m, rad]: more of parts that are further away."""
    record, covariance = mount.calibration, calibration_covariance(mount)
    x, y, z = detection.T_world_part.translation - mount.T_world_scanner.translation
    moved = np.zeros((6, 3))  # by turns of the scanner
    moved[:3] = [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]
    moved[3:] = np.eye(3)
    if covariance is not None:
        # What is not known of place and direction cancels in part: the plate was near the bin.
        moves = np.hstack([np.eye(6, 3), moved])
        return moves @ covariance @ moves.T
    place, turn = CALIBRATION
    if record is not None and record.position_error is not None:
        place = record.position_error
    if record is not None and record.angle_error is not None:
        turn = record.angle_error
    found = turn**2 * moved @ moved.T
    found[:3, :3] += place**2 * np.eye(3)
    return found


def localization_error(detection: Detection) -> Floats:
    """What the search leaves open (6, 6) [m, rad]."""
    if detection.covariance is not None:
        return np.array(detection.covariance)
    place, turn = LOCALIZATION
    return np.diag(np.square([place] * 3 + [turn] * 3))
