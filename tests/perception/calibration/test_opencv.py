"""Calibrations against OpenCV's, which knows rotations and positions of the plate alone."""

import numpy as np
import pytest
from held_plates import (
    CENTRES,
    H,
    V,
    by_opencv,
    hand_eye_by_opencv,
    off_at_corners,
    scene,
    wrist_scene,
)

from workbench.perception.calibration.calibrate import calibrate

pytest.importorskip("cv2", reason="opencv-python-headless is not installed")

SEEDS = range(1000, 1040)


def off(T) -> float:
    """[m] By which the corner that is furthest off is seen elsewhere."""
    return float(off_at_corners(T).max())


def test_without_noise_both_find_the_same():
    poses = scene(0, ball=0.0)
    assert off(by_opencv(poses)) < 1e-6
    assert off(calibrate(poses, CENTRES).T_world_scanner) < 1e-6


@pytest.mark.parametrize(
    ("shift", "turn"),
    [(0.0, 0.0), (3e-4, 0.0), (3e-4, np.deg2rad(0.05)), (1e-4, np.deg2rad(0.1))],
    ids=["balls", "shifts", "both", "turns"],
)
def test_errors_at_the_corners_are_not_larger_than_those_of_opencv(shift, turn):
    ours, theirs = [], []
    for seed in SEEDS:
        poses = scene(seed, count=8, shift=shift, turn=turn, at_flange=True)
        ours.append(off(calibrate(poses, CENTRES).T_world_scanner))
        theirs.append(off(by_opencv(poses)))
    ours, theirs = (float(np.sqrt(np.mean(np.square(one)))) for one in (ours, theirs))
    assert ours < theirs
    if shift == turn == 0.0:
        assert ours < 0.5 * theirs, "what is weighed by nothing wastes exact balls"


@pytest.mark.parametrize(
    ("shift", "turn"),
    [(0.0, 0.0), (3e-4, 0.0), (1e-4, np.deg2rad(0.1))],
    ids=["balls", "shifts", "turns"],
)
def test_nor_are_those_of_a_scanner_on_an_arm(shift, turn):
    ours, theirs = [], []
    for seed in SEEDS[:25]:
        poses = wrist_scene(seed, count=12, shift=shift, turn=turn)
        found = calibrate(poses, CENTRES).T_world_scanner
        ours.append(float(off_at_corners(found, V * H).max()))
        by_horaud = hand_eye_by_opencv(poses, "HORAUD")
        theirs.append(float(off_at_corners(by_horaud, V * H).max()))
    assert np.sqrt(np.mean(np.square(ours))) < np.sqrt(np.mean(np.square(theirs)))
