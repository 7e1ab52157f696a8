"""Hand-eye sets of others: files in a folder that WORKBENCH_HAND_EYE names, and one written here.

`NAME.eye_to_hand.csv` or `NAME.eye_in_hand.csv`: a row of 14 numbers for each pose, `T_base_flange`
and then `T_camera_target`, each as x, y, z [m] and the quaternion x, y, z, w; other lines are
skipped.
"""

import os
from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest
from held_plates import CENTRES, X, by_opencv, scene

from workbench.model.errors import InputError
from workbench.perception.calibration.calibrate import MOST_POSES, calibrate
from workbench.perception.calibration.plate_poses import PlatePose, distances
from workbench.perception.calibration.rigid import fitted_motion

FOLDER = os.environ.get("WORKBENCH_HAND_EYE", "")
SETS = sorted(Path(FOLDER).glob("*.eye_*_hand.csv")) if FOLDER else []


def read(path: Path) -> list[PlatePose]:
    """Poses of a plate whose balls lie in the target's frame.

    Where the hand holds the camera, the base is what holds the plate and the flange is the world:
    the unknowns are then the camera on the flange, and the target at the base.
    """
    found = []
    for number, words in enumerate(path.read_text().splitlines()):
        try:
            values = np.array([float(word) for word in words.split(",")])
        except ValueError:
            continue
        assert values.shape == (14,), f"{path}: 14 numbers a row are expected"
        T_base_flange, T_camera_target = (pin.XYZQUATToSE3(one) for one in np.split(values, 2))
        T = T_base_flange.inverse() if path.name.endswith("in_hand.csv") else T_base_flange
        balls = CENTRES @ T_camera_target.rotation.T + T_camera_target.translation
        at = np.zeros(3) if path.name.endswith("in_hand.csv") else None
        found.append(PlatePose(f"row {number}", T, balls, at=at))
    return found[:: -(-len(found) // (2 * MOST_POSES))]


def check(poses: list[PlatePose]) -> pin.SE3:
    """Poses that were not fitted are predicted as well as by OpenCV."""
    fitted, others = poses[::2], poses[1::2]
    found = calibrate(fitted, CENTRES)
    theirs = by_opencv(fitted)
    plates = [one.T_world_flange.actInv(theirs * _plate(one)) for one in fitted]
    mean = plates[0] * pin.exp6(np.mean([pin.log6(plates[0].actInv(T)) for T in plates], axis=0))
    rms = [
        float(np.sqrt(np.mean(distances(others, answer, CENTRES) ** 2)))
        for answer in ((found.T_world_scanner, found.T_flange_plate), (theirs, mean))
    ]
    assert rms[0] <= 1.1 * rms[1] + 1e-4, rms
    return found.T_world_scanner


def _plate(pose: PlatePose) -> pin.SE3:
    return pin.SE3(*fitted_motion(CENTRES, pose.balls))


@pytest.mark.parametrize("path", SETS, ids=lambda path: path.name)
def test_sets_of_others_are_predicted_as_well_as_by_opencv(path):
    pytest.importorskip("cv2")
    try:
        check(read(path))
    except InputError as error:
        pytest.skip(f"refused: {error}")


@pytest.mark.parametrize("kind", ["eye_to_hand", "eye_in_hand"])
def test_a_set_that_was_written_is_read(tmp_path, kind):
    pytest.importorskip("cv2")
    lines = ["robot x,y,z,qx,qy,qz,qw,target x,y,z,qx,qy,qz,qw"]
    for pose in scene(7, count=24, shift=2e-4, turn=np.deg2rad(0.02)):
        T = pose.T_world_flange.inverse() if kind == "eye_in_hand" else pose.T_world_flange
        numbers = [*pin.SE3ToXYZQUAT(T), *pin.SE3ToXYZQUAT(_plate(pose))]
        lines.append(",".join(f"{value:.9f}" for value in numbers))
    path = tmp_path / f"written.{kind}.csv"
    path.write_text("\n".join(lines))
    poses = read(path)
    assert len(poses) == 24
    off = X.actInv(check(poses))
    assert np.linalg.norm(off.translation) < 1e-3
