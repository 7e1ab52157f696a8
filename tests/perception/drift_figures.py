"""How surely drift is told, and how exactly: `drift_figures.py table|parts SEEDS FIRST`, by hand.

With `PYTHONPATH=.:tests/perception`.
"""

import sys
import time

import numpy as np
from drifting import PRIOR, weeks, yumi

from workbench.app.calibration.calibration import bin_corners
from workbench.model.geometry import pose_from_rpy
from workbench.perception.calibration.drift import PARTS_LABEL
from workbench.perception.calibration.refinement import drift_of
from workbench.perception.calibration.sureness import point_errors
from workbench.perception.calibration.things import moved_to

DRIFTS = {"none": (0.0, 0.0), "0.5 mm": (5e-4, 0.0), "1 mm": (1e-3, 0.0), "2 mm": (2e-3, 0.0)}
DRIFTS["0.1 deg"] = (0.0, np.deg2rad(0.1))
BIN_MOVES = "none; bin 2 mm"


def main(has_parts: bool, count: int, first: int) -> None:
    """Print a table of the documentation."""
    print("| drift | seen | scanner told | bin told | before | after | in 95% | time |")
    print("|---|---|---|---|---|---|---|---|")
    cell = yumi(np.deg2rad(46) if has_parts else None)
    middle = cell.bin.T_world_bin.translation
    corners = np.array(list(bin_corners(cell.bin).values()))
    for name in (*DRIFTS, BIN_MOVES):
        told, bins, before, after, inside, took = 0, 0, [], [], [], time.process_time()
        for seed in range(first, first + count):
            rng = np.random.default_rng(seed)
            shift, turn = DRIFTS.get(name, (0.0, 0.0))
            ways = rng.normal(size=(2, 3))
            ways /= np.linalg.norm(ways, axis=1)[:, None]
            # The scanner shifts, and turns about its own origin.
            to_middle = moved_to(middle - cell.scanner.T_world_scanner.translation)
            drift = to_middle @ np.concatenate([shift * ways[0], turn * ways[1]])
            start = np.linalg.cholesky(PRIOR) @ rng.standard_normal(6)
            moves = pose_from_rpy((0.002, 0, 0)) if name == BIN_MOVES else None
            jitter = 5e-4 if seed % 2 else 0.0
            sightings = weeks(
                cell, seed, drift, start=start, jitter=jitter, bin_moves=moves,
                has_parts=has_parts,
            )  # fmt: skip
            found = drift_of(sightings, PRIOR, 0.9)
            told += bool(found.drifted)
            bins += found.is_bin_off
            truth = start + drift
            before.append(_far(truth, corners - middle))
            moved = np.zeros(6) if found.moved is None else found.moved
            far = _far(truth - moved, corners - middle)
            after.append(far)
            if found.covariance is not None:
                inside.append(far < point_errors(found.covariance, middle, corners))
        rms = [np.sqrt(np.mean(np.square(one))) * 1000 for one in (before, after)]
        share = f"{np.mean(inside):.0%}" if inside else "-"
        seconds = (time.process_time() - took) / count
        print(
            f"| {name} | table{', ' + PARTS_LABEL if has_parts else ''} | {told} of {count} "
            f"| {bins} of {count} | {rms[0]:.2f} mm | {rms[1]:.2f} mm | {share} | "
            f"{seconds:.1f} s |",
            flush=True,
        )


def _far(moved, arms):
    """How far off the corners (8,) [m] are seen."""
    return np.linalg.norm(moved[:3] + np.cross(moved[3:], arms), axis=1)


if __name__ == "__main__":
    main(sys.argv[1] == "parts", int(sys.argv[2]), int(sys.argv[3]))
