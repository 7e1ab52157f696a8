"""Where a scanner is: it stands, or its arm stands at the view or elsewhere."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.calibration import CalibrationRecord
from workbench.model.cell import Cell, ScannerMount
from workbench.model.geometry import Floats


def flange_at_view(mount: ScannerMount) -> pin.SE3:
    """`T_world_flange` at the view of the arm with the scanner; identity where that stands."""
    if mount.on_arm is None:
        return pin.SE3.Identity()
    return mount.T_world_scanner * mount.on_arm.T_flange_scanner.inverse()


def with_scanner_at(cell: Cell, T_world_scanner: pin.SE3) -> Cell:
    """The cell with its scanner there; one on an arm is there while the arm stands at the view."""
    mount, carrier = cell.scanner, cell.scanner.on_arm
    if carrier is not None:
        T_flange_scanner = flange_at_view(mount).actInv(T_world_scanner)
        carrier = replace(carrier, T_flange_scanner=T_flange_scanner)
    scanner = replace(mount, T_world_scanner=T_world_scanner, on_arm=carrier)
    return replace(cell, scanner=scanner)


def with_calibrated_scanner(
    cell: Cell, T_world_scanner: pin.SE3, record: CalibrationRecord
) -> Cell:
    """The cell with its scanner there, and the record of who has measured that.

    The record's covariance is along the world's axes; it is kept as `calibration_covariance` reads
    it.
    """
    after = with_scanner_at(cell, T_world_scanner)
    if record.covariance is not None:
        R_flange_world = flange_at_view(cell.scanner).rotation.T
        record = replace(record, covariance=turn_covariance(record.covariance, R_flange_world))
    return replace(after, scanner=replace(after.scanner, calibration=record))


def scanner_pose(cell: Cell, q: Floats) -> pin.SE3:
    """`T_world_scanner` while the arm that carries it, if one does, stands at `q` (n,) [rad]."""
    carrier = cell.scanner.on_arm
    if carrier is None:
        return cell.scanner.T_world_scanner
    return carrier.T_world_scanner(cell.T_world_robot, cell.robot, q)


def calibration_covariance(mount: ScannerMount) -> Floats | None:
    """Of the calibrated pose (6, 6) [m, rad] along the world's axes, on an arm at the view.

    None where no calibration states it.  A record has it along the axes of what the scanner is
    fixed to: the world's, or the flange's.
    """
    record = mount.calibration
    if record is None or record.covariance is None:
        return None
    return turn_covariance(record.covariance, flange_at_view(mount).rotation)


def turn_covariance(covariance: Floats, rotation: Floats) -> Floats:
    """A covariance (6, 6) [m, rad] of shifts and turns, its axes turned by a rotation (3, 3)."""
    R = np.kron(np.eye(2), rotation)
    return R @ covariance @ R.T
