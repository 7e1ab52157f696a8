"""How well calibrations say how sure they are: `calibration_figures.py [SEEDS] [FIRST]`, by hand.

With `PYTHONPATH=.:tests:tests/perception`, and OpenCV installed; kinhec's solvers where it is.
"""

import sys
from functools import partial
from importlib.util import find_spec

import numpy as np
from held_plates import (
    CENTRES,
    CORNERS,
    HAND_EYE,
    H,
    V,
    X,
    by_kinhec,
    by_opencv,
    hand_eye_by_kinhec,
    hand_eye_by_opencv,
    off_at_corners,
    off_truth,
    scene,
    wrist_scene,
)

from workbench.model.errors import InputError
from workbench.perception.calibration.calibrate import calibrate
from workbench.perception.calibration.sureness import point_errors

CHI_SQUARE = 16.81
"""99 % of six standard normals have a sum of squares up to this."""

NOISES = {
    "balls 0.05 mm": {},
    "robot 0.3 mm": {"shift": 3e-4},
    "robot 0.3 mm, 0.05 deg": {"shift": 3e-4, "turn": np.deg2rad(0.05)},
    "robot 0.1 mm, 0.1 deg": {"shift": 1e-4, "turn": np.deg2rad(0.1)},
}


def stands_scene(seed, **noise):
    """A plate in the hand of a robot whose flange is off."""
    return scene(seed, at_flange=True, **noise)


SCANNERS = {
    "stands": (stands_scene, X, {"SHAH": by_opencv}),
    "on an arm": (
        wrist_scene,
        V * H,
        {name: lambda poses, name=name: hand_eye_by_opencv(poses, name) for name in HAND_EYE},
    ),
}
"""What makes the poses, the scanner's true pose, and methods of OpenCV and kinhec."""

KINHEC = {
    "stands": (by_kinhec, ("shah", "li_kronecker", "refined")),
    "on an arm": (
        hand_eye_by_kinhec,
        ("tsai_lenz", "park_martin", "horaud_dornaika", "daniilidis", "andreff", "refined"),
    ),
}

if find_spec("kinhec"):
    for scanner, (solve, methods) in KINHEC.items():
        for method in methods:
            SCANNERS[scanner][2][f"kinhec {method}"] = partial(solve, method=method)


def main(count: int, first: int) -> None:
    """Print a table of the documentation."""
    print(
        "| scanner; noise | poses | refused | in the 99% ellipsoid | corners in 95% | RMS, others |"
    )
    print("|---|---|---|---|---|---|")
    for scanner in SCANNERS:
        for name in NOISES:
            for poses in (8, 12):
                print(f"| {scanner}; {name} | {poses} {row(scanner, name, poses, count, first)}")


def row(scanner: str, noise: str, poses: int, count: int, first: int) -> str:
    """What so many calibrations give."""
    make, truth, methods = SCANNERS[scanner]
    inside, corners, ours = 0, [], []
    theirs = {method: [] for method in methods}
    for seed in range(first, first + count):
        shown = make(seed, count=poses, **NOISES[noise])
        try:
            found = calibrate(shown, CENTRES)
        except InputError:
            continue
        T = found.T_world_scanner
        off = off_truth(T, truth)
        inside += off @ np.linalg.solve(found.covariance, off) < CHI_SQUARE
        far = off_at_corners(T, truth)
        corners.append(far < point_errors(found.covariance, T.translation, CORNERS))
        ours.append(far.max())
        for method, solve in methods.items():
            theirs[method].append(off_at_corners(solve(shown), truth).max())
    said = ", ".join(f"{method} {rms(errors):.2f}" for method, errors in theirs.items())
    done = len(ours)
    return (
        f"| {count - done} | {inside / done:.1%} | {np.mean(corners):.1%} "
        f"| {rms(ours):.2f}, {said} mm |"
    )


def rms(errors: list[float]) -> float:
    """In millimetres, of errors in metres."""
    return float(np.sqrt(np.mean(np.square(errors)))) * 1000


if __name__ == "__main__":
    main(*(int(word) for word in (*sys.argv[1:], "100", "31000")[:2]))
