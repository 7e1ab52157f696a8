"""The plate before the scanner: poses that show it, and what a simulated scanner sees of it.

An arm holds the plate, or it stands and the arm carries the scanner.
"""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from workbench.app.calibration.calibration import plate_pose
from workbench.model.calibration import BallPlate, PlateObservation
from workbench.model.cell import Arm, Cell
from workbench.model.derived.scanner_poses import flange_at_view, scanner_pose, with_scanner_at
from workbench.model.geometry import Floats, transform
from workbench.model.scan import Obstacle, Scan
from workbench.perception.calibration.rigid import fitted_motion
from workbench.perception.simulation.ball_plate import (
    held_pose,
    is_plate_in_sight,
    scan_plate,
    standing_pose,
)
from workbench.planning.kinematics.robot import Kinematics
from workbench.planning.picking.viewpoints import (
    ASIDE,
    sample_configurations,
    showing_poses,
    viewing_poses,
)

SPARE = 3
"""Times as many poses are searched for as are wanted: the arm itself hides the plate in some."""


def simulated_plate(cell: Cell, arm: Arm, plate: BallPlate) -> pin.SE3:
    """`T_flange_plate` of the simulation, at the view where the arm carries the scanner."""
    if cell.scanner.on_arm is None:
        return arm.tool.T_flange_tcp * held_pose(plate)
    return flange_at_view(cell.scanner).actInv(standing_pose(cell.bin, plate))


def simulated_sight(
    cell: Cell,
    arm: Arm,
    q: Floats,
    plate: BallPlate,
    *,
    seed: int,
    T_world_scanner: pin.SE3 | None = None,
) -> Scan:
    """What the simulated scanner sees of the plate while an arm stands at `q` (n,) [rad].

    The scanner hangs where the cell says, or at `T_world_scanner`; on an arm that is at the view.
    """
    truth = cell if T_world_scanner is None else with_scanner_at(cell, T_world_scanner)
    kinematics = Kinematics(cell)
    T_world_plate = plate_pose(cell, kinematics, arm, q, simulated_plate(cell, arm, plate))
    links = kinematics.link_poses(cell.joint_values({arm.name: q}))
    T = scanner_pose(truth, q)
    return scan_plate(cell, links, plate, T_world_plate, seed=seed, T_world_scanner=T)


def seen_plate(cell: Cell, observation: PlateObservation) -> pin.SE3:
    """`T_flange_plate` at the view by one scan of a scanner on an arm, as far as the cell is right.

    So the plate may lie anywhere.
    """
    T_scanner_plate = pin.SE3(*fitted_motion(observation.plate.centres, observation.balls))
    T_world_plate = scanner_pose(cell, observation.q) * T_scanner_plate
    return flange_at_view(cell.scanner).actInv(T_world_plate)


def first_poses(
    cell: Cell,
    arm: Arm,
    plate: BallPlate,
    count: int,
    *,
    seed: int,
    observations: Sequence[PlateObservation],
) -> tuple[Floats, ...]:
    """Configurations (n,) [rad] to begin with, while poses are too few for an answer.

    A scanner on an arm first looks from its view; then it is known about where the plate lies.
    """
    if cell.scanner.on_arm is None:
        return suggested_poses(cell, arm, plate, count, seed=seed)
    if not observations:
        return (cell.scanner.on_arm.view.q,)
    seen = seen_plate(cell, observations[-1])
    return suggested_poses(cell, arm, plate, count, seed=seed, T_flange_plate=seen)


def suggested_poses(
    cell: Cell,
    arm: Arm,
    plate: BallPlate,
    count: int,
    *,
    seed: int,
    T_flange_plate: pin.SE3 | None = None,
    aside: float = ASIDE,
) -> tuple[Floats, ...]:
    """Configurations (n,) [rad] in which the scanner sees the plate.

    They are clear of everything by the policy's margin and differ in how the wrist is turned.  The
    plate is where the simulation has it where `T_flange_plate` does not say where, up to `aside`
    [m] from the scanner's axis.
    """
    placed = simulated_plate(cell, arm, plate) if T_flange_plate is None else T_flange_plate
    middle = pin.SE3(np.eye(3), plate.centres.mean(axis=0))
    T_tcp_flange = arm.tool.T_flange_tcp.inverse()
    kinematics, seen = Kinematics(cell), list[Floats]()
    carrier, obstacles = cell.scanner.on_arm, tuple[Obstacle, ...]()
    if carrier is None:
        draw = showing_poses(cell, T_tcp_flange * placed * middle, aside)
    else:
        T_world_plate = plate_pose(cell, kinematics, arm, carrier.view.q, placed)
        T_tcp_scanner = T_tcp_flange * carrier.T_flange_scanner
        shown = (T_world_plate * middle).translation
        draw = viewing_poses(cell.scanner, T_tcp_scanner, shown, aside)
        obstacles = (_box_around(plate, T_world_plate),)
    for q in sample_configurations(cell, arm, draw, SPARE * count, seed=seed, obstacles=obstacles):
        links = kinematics.link_poses(cell.joint_values({arm.name: q}))
        T_world_plate = plate_pose(cell, kinematics, arm, q, placed)
        if is_plate_in_sight(cell, links, plate, T_world_plate, scanner_pose(cell, q)):
            seen.append(q)
        if len(seen) == count:
            break
    return tuple(seen)


def _box_around(plate: BallPlate, T_world_plate: pin.SE3) -> Obstacle:
    """An upright box around the balls of a plate that stands."""
    centres = transform(T_world_plate, plate.centres)
    low, high = centres.min(axis=0) - plate.radius, centres.max(axis=0) + plate.radius
    return Obstacle(pin.SE3(np.eye(3), (low + high) / 2), high - low)
