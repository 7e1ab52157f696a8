"""A plate held before the scanner: poses that show it, and what a simulated scanner sees of it."""

import numpy as np
import pinocchio as pin

from workbench.model.calibration import BallPlate
from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats
from workbench.model.scan import Scan
from workbench.perception.simulation.held_plate import held_pose, is_plate_in_sight, scan_held_plate
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.viewpoints import ASIDE, sample_showing_configurations

SPARE = 3
"""Times as many poses are searched for as are wanted: the arm itself hides the plate in some."""


def simulated_sight(
    cell: Cell,
    arm: Arm,
    q: Floats,
    plate: BallPlate,
    *,
    seed: int,
    T_world_scanner: pin.SE3 | None = None,
) -> Scan:
    """What the simulated scanner sees of an arm at `q` (n,) [rad] that holds the plate."""
    links = Kinematics(cell).link_poses(cell.joint_values({arm.name: q}))
    return scan_held_plate(cell, links, arm.name, plate, seed=seed, T_world_scanner=T_world_scanner)


def suggested_poses(
    cell: Cell,
    arm: Arm,
    plate: BallPlate,
    count: int,
    *,
    seed: int,
    T_tcp_plate: pin.SE3 | None = None,
    aside: float = ASIDE,
) -> tuple[Floats, ...]:
    """Configurations (n,) [rad] in which the scanner sees the plate.

    They are clear of everything by the policy's margin and differ in how the wrist is turned.  The
    plate is held beside the tool where `T_tcp_plate` does not say how, up to `aside` [m] from the
    scanner's axis.
    """
    held = held_pose(plate) if T_tcp_plate is None else T_tcp_plate
    T_tcp_middle = held * pin.SE3(np.eye(3), plate.centres.mean(axis=0))
    kinematics, seen = Kinematics(cell), list[Floats]()
    for q in sample_showing_configurations(
        cell, arm, T_tcp_middle, SPARE * count, seed=seed, aside=aside
    ):
        links = kinematics.link_poses(cell.joint_values({arm.name: q}))
        if is_plate_in_sight(cell, links, arm.name, plate, held):
            seen.append(q)
        if len(seen) == count:
            break
    return tuple(seen)
