"""Errors of a part's pose in the bin, by their source.

All are covariances (6, 6) [m, rad] along the world's axes: of shifts of the part's origin, then of
rotations about it, as in `Detection`.
"""

import numpy as np

from workbench.model.cell import ScannerMount
from workbench.model.derived.scanner_poses import calibration_covariance
from workbench.model.geometry import Floats, motions_moved
from workbench.model.scan import Detection

CALIBRATION = (0.0005, float(np.deg2rad(0.05)))
"""[m, rad] Deviations of the scanner's place and of its direction, along any axis, where no
calibration says them: those of one by six poses of a plate."""

LOCALIZATION = (0.001, float(np.deg2rad(1.0)))
"""[m, rad] Deviations of a pose that comes without any, along any axis."""


def calibration_error(mount: ScannerMount, detection: Detection) -> Floats:
    """What the scanner's pose leaves open (6, 6) [m, rad]: more of parts that are further away."""
    # What is not known of place and direction cancels in part: the plate was near the bin.
    moves = moves_by_scanner(mount, detection)
    return moves @ scanner_error(mount) @ moves.T


def moves_by_scanner(mount: ScannerMount, detection: Detection) -> Floats:
    """How shifts and turns of the scanner move a part: `error -> moves @ error` (6, 6) [m, rad].

    A part on a station has been moved by a hand since, which has taken some of that away.
    """
    if detection.placing is not None:
        return _to_world(detection) @ detection.placing.by_scanner
    by = detection.T_world_part.translation - mount.T_world_scanner.translation
    return motions_moved(by)


def scanner_error(mount: ScannerMount) -> Floats:
    """What is not known of the scanner's pose (6, 6) [m, rad]."""
    record, covariance = mount.calibration, calibration_covariance(mount)
    if covariance is not None:
        return covariance
    place, turn = CALIBRATION
    if record is not None and record.position_error is not None:
        place = record.position_error
    if record is not None and record.angle_error is not None:
        turn = record.angle_error
    return np.diag(np.square([place] * 3 + [turn] * 3))


def localization_error(detection: Detection) -> Floats:
    """What the search leaves open (6, 6) [m, rad]; and the hand that has put a part down since."""
    if detection.placing is not None:
        to_world = _to_world(detection)
        return to_world @ detection.placing.covariance @ to_world.T
    if detection.covariance is not None:
        return np.array(detection.covariance)
    place, turn = LOCALIZATION
    return np.diag(np.square([place] * 3 + [turn] * 3))


def _to_world(detection: Detection) -> Floats:
    """From shifts and turns along the part's axes to those along the world's (6, 6), no unit."""
    return np.array(np.kron(np.eye(2), detection.T_world_part.rotation), np.float64)
