"""Where the scanner hangs, measured by a plate with three balls that the robot holds up to it.

The scanner of this simulation hangs elsewhere than the cell file says, by more than a centimetre.
Nothing but the scans of the plate and the joint values tells where.
"""

import math

import numpy as np
import pinocchio as pin

import workbench as wb

cell = wb.read_cell("yumi")
plate = wb.BallPlate(radius=0.015, sides=np.array([0.08, 0.1, 0.12]))
turn = pin.rpy.rpyToMatrix(*np.deg2rad((1.2, -0.8, 1.5)))
truth = cell.scanner.T_world_scanner * pin.SE3(turn, np.array([0.012, -0.008, 0.015]))


def off(T_world_scanner: pin.SE3) -> str:
    """How far a pose is from where the scanner truly hangs."""
    between = truth.actInv(T_world_scanner)
    distance = np.linalg.norm(between.translation) * 1000
    angle = math.degrees(float(np.linalg.norm(pin.log3(between.rotation))))
    return f"{distance:.2f} mm and {angle:.2f} degrees off"


observations: list[wb.PlateObservation] = []
for number, q in enumerate(wb.plate_poses(cell, plate, count=8), start=1):
    scan = wb.simulate_plate(cell, q, plate, T_world_scanner=truth, seed=number)
    try:
        observations.append(wb.sight_plate(scan, plate, f"pose {number}", "right", q))
    except wb.InputError as error:
        print("left out:", error)
found = wb.calibrate(cell, observations)
for one in found.residuals:
    print(f"{one.name}: balls {one.distance * 1000:.2f} mm from where they should be, {one.light}")
print("the cell file:", off(cell.scanner.T_world_scanner))
print("measured:     ", off(found.T_world_scanner))
print(f"it holds itself sure to {found.position_error * 1000:.2f} mm")
cell = wb.with_calibration(cell, found, at=0.0, by="Ada")
assert cell.scanner.calibration is not None
print(f"the cell remembers {cell.scanner.calibration.poses} poses, taken over by Ada")
