"""How well calibrations say how sure they are: `calibration_figures.py [SEEDS] [FIRST]`, by hand.

With `PYTHONPATH=.:tests/perception`, and OpenCV installed.
"""

import sys

import numpy as np
from held_plates import CENTRES, CORNERS, by_opencv, off_at_corners, off_truth, scene

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


def main(count: int, first: int) -> None:
    """Print a table of the documentation."""
    print("| noise | poses | refused | in the 99% ellipsoid | corners in 95% | ours | OpenCV |")
    print("|---|---|---|---|---|---|---|")
    for name, noise in NOISES.items():
        for poses in (8, 12):
            inside, corners, ours, theirs = 0, [], [], []
            for seed in range(first, first + count):
                held = scene(seed, count=poses, at_flange=True, **noise)
                try:
                    found = calibrate(held, CENTRES)
                except InputError:
                    continue
                T, off = found.T_world_scanner, off_truth(found.T_world_scanner)
                inside += off @ np.linalg.solve(found.covariance, off) < CHI_SQUARE
                far = off_at_corners(T)
                corners.append(far < point_errors(found.covariance, T.translation, CORNERS))
                ours.append(far.max())
                theirs.append(off_at_corners(by_opencv(held)).max())
            done = len(ours)
            ours, theirs = (np.sqrt(np.mean(np.square(one))) * 1000 for one in (ours, theirs))
            print(
                f"| {name} | {poses} | {count - done} | {inside / done:.1%} "
                f"| {np.mean(corners):.1%} | {ours:.2f} mm | {theirs:.2f} mm |",
                flush=True,
            )


if __name__ == "__main__":
    main(*(int(word) for word in (*sys.argv[1:], "100", "31000")[:2]))
