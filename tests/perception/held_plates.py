"""A plate held before a scanner, or seen by one on an arm, by a robot that is not exact.

And what OpenCV and kinhec make of it.
"""

from itertools import combinations

import numpy as np
import pinocchio as pin

from workbench.app.calibration.calibration import plate_mover
from workbench.model.calibration import BallPlate
from workbench.model.geometry import pose_from_rpy
from workbench.perception.calibration.plate_poses import PlatePose
from workbench.perception.calibration.rigid import fitted_motion

X = pose_from_rpy((0.41, 0.01, 0.9), (np.pi + 0.02, 0.01, 1.5))
Y = pose_from_rpy((0.05, 0.02, 0.12), (0.3, 0.2, 0.1))
CENTRES = BallPlate().centres
CORNERS = X.translation + np.array(
    [[x, y, z] for x in (-0.2, 0.2) for y in (-0.15, 0.15) for z in (-0.9, -0.78)]
)
H = pose_from_rpy((0.012, -0.085, 0.04), (0.02, -0.01, 0.03))
"""T_flange_scanner of one on an arm."""
V = pose_from_rpy((0.41, 0.01, 0.55), (np.pi + 0.02, 0.01, 1.5)) * H.inverse()
"""T_world_flange at its view."""
STANDS = pose_from_rpy((0.37, 0.02, 0.135), (0.02, 0.01, 0.4))
"""T_world_plate: over the bin."""

NEAR = (X * pose_from_rpy((0.001, 0.0, 0.001), (0.001, 0.0, 0.0)), Y)
"""Where a fit may begin."""


def scene(
    seed, *, count=12, ball=5e-5, shift=0.0, turn=0.0, turns=None, at_flange=False
) -> list[PlatePose]:
    """Poses whose balls are off by `ball` [m] each, and the robot by `shift` [m] and `turn` [rad].

    The robot is off along and about each axis of the plate's middle, or of the flange, where a turn
    moves the plate, too.
    """
    rng = np.random.default_rng(seed)
    held = pin.SE3.Identity() if at_flange else Y * pin.SE3(np.eye(3), CENTRES.mean(axis=0))
    if turns is None:
        turns = rng.uniform((-0.5, -0.5, -2.5), (0.5, 0.5, 2.5), (count, 3))
    poses = []
    for number, lean in enumerate(turns, start=1):
        place = rng.uniform(-0.08, 0.08, 3) + (0.41, 0.0, 0.3)
        T = pose_from_rpy(place, np.array(lean) + (np.pi, 0, 0))
        U = X.actInv(T * Y)
        balls = CENTRES @ U.rotation.T + U.translation + rng.normal(0, ball, (3, 3))
        wrong = pin.SE3(pin.exp3(turn * rng.standard_normal(3)), shift * rng.standard_normal(3))
        poses.append(PlatePose(f"pose {number}", T * held * wrong * held.inverse(), balls))
    return poses


def wrist_scene(seed, *, count=12, ball=5e-5, shift=0.0, turn=0.0) -> list[PlatePose]:
    """The same of a scanner on an arm, as `plate_mover` has it, before a plate that stands."""
    rng = np.random.default_rng(seed)
    view, middle = V * H, STANDS.act(CENTRES.mean(axis=0))
    away = np.linalg.norm(view.translation - middle)
    poses = []
    for number in range(1, count + 1):
        lean, tilt, yaw = rng.uniform(-np.pi, np.pi), rng.uniform(0, np.pi / 6), rng.uniform(-2, 2)
        axis = tilt * np.array([np.cos(lean), np.sin(lean), 0.0])
        R = view.rotation @ pin.exp3(axis) @ pin.rpy.rpyToMatrix(0.0, 0.0, yaw)
        aim = (*rng.uniform(-0.1, 0.1, 2), away * rng.uniform(0.7, 1.1))
        T = pin.SE3(R, middle - R @ aim) * H.inverse()
        U = (T * H).actInv(STANDS)
        balls = CENTRES @ U.rotation.T + U.translation + rng.normal(0, ball, (3, 3))
        wrong = pin.SE3(pin.exp3(turn * rng.standard_normal(3)), shift * rng.standard_normal(3))
        mover = plate_mover(T * wrong, V)
        poses.append(PlatePose(f"pose {number}", mover, balls, at=V.translation))
    return poses


def off_truth(T: pin.SE3, X: pin.SE3 = X) -> np.ndarray:
    """Shift [m] and turn [rad] (6,) along the world's axes from a scanner's pose to the truth."""
    turn = pin.log3(X.rotation @ T.rotation.T)
    return np.concatenate([X.translation - T.translation, turn])


def off_at_corners(T: pin.SE3, X: pin.SE3 = X) -> np.ndarray:
    """How far off the corners of the bin are seen (8,) [m] by a scanner's pose."""
    wrong = T * X.inverse()
    return np.array([np.linalg.norm(wrong.act(corner) - corner) for corner in CORNERS])


def by_opencv(poses: list[PlatePose]) -> pin.SE3:
    """`T_world_scanner` by Shah's closed form; `plate to scanner` is what it calls world to cam."""
    import cv2

    plates = [fitted_motion(CENTRES, pose.balls) for pose in poses]
    flanges = [pose.T_world_flange for pose in poses]
    *_, R, t = cv2.calibrateRobotWorldHandEye(
        [R for R, _ in plates],
        [t for _, t in plates],
        [T.rotation for T in flanges],
        [T.translation for T in flanges],
        method=cv2.CALIB_ROBOT_WORLD_HAND_EYE_SHAH,
    )
    return pin.SE3(R, t.ravel()).inverse()


HAND_EYE = ("TSAI", "PARK", "HORAUD", "ANDREFF", "DANIILIDIS")


def hand_eye_by_opencv(poses: list[PlatePose], method: str) -> pin.SE3:
    """`T_world_scanner` at the view by one of OpenCV's `calibrateHandEye`."""
    import cv2

    plates = [fitted_motion(CENTRES, pose.balls) for pose in poses]
    flanges = [plate_mover(pose.T_world_flange, V) for pose in poses]
    R, t = cv2.calibrateHandEye(
        [T.rotation for T in flanges],
        [T.translation for T in flanges],
        [R for R, _ in plates],
        [t for _, t in plates],
        method=getattr(cv2, f"CALIB_HAND_EYE_{method}"),
    )
    return V * pin.SE3(R, t.ravel())


def by_kinhec(poses: list[PlatePose], method: str) -> pin.SE3:
    """`T_world_scanner` by a solver of kinhec for `A X = Y B`; `refined` is its least squares."""
    from kinhec import solvers

    flanges = np.array([pose.T_world_flange.homogeneous for pose in poses])
    plates = np.array([_plate_of(pose).homogeneous for pose in poses])
    if method == "refined":
        _, Y = solvers.refine_lm_axyb(flanges, plates, *solvers.shah(flanges, plates))
    else:
        _, Y = solvers.AXYB_SOLVERS[method](flanges, plates)
    return pin.SE3(Y)


def hand_eye_by_kinhec(poses: list[PlatePose], method: str) -> pin.SE3:
    """`T_world_scanner` at the view by a solver of kinhec for `A X = X B`."""
    from kinhec import se3, solvers

    pairs = list(combinations(range(len(poses)), 2))
    flanges = np.array([plate_mover(pose.T_world_flange, V).homogeneous for pose in poses])
    scanners = np.array([_plate_of(pose).inverse().homogeneous for pose in poses])
    A, B = (se3.relative_motions(Ts, pairs) for Ts in (flanges, scanners))
    if method == "refined":
        return V * pin.SE3(solvers.refine_lm(A, B, solvers.park_martin(A, B)))
    return V * pin.SE3(solvers.AXXB_SOLVERS[method](A, B))


def _plate_of(pose: PlatePose) -> pin.SE3:
    """`T_scanner_plate` by the balls."""
    return pin.SE3(*fitted_motion(CENTRES, pose.balls))
