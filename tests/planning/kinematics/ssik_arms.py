"""Makers' arms by the numbers of `ssik` (PyPI): poses that are missed, and the time a pose takes.

`python tests/planning/kinematics/ssik_arms.py [CELL_FILE ...]` prints the table of
`docs/benchmarks/judged.md`, with rows for the arms of further cells.
"""

import sys
import time
from pathlib import Path

import numpy as np
from ssik import Manipulator

from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import Floats
from workbench.planning.kinematics.chain import Chain, chain_of, is_solution
from workbench.planning.kinematics.inverse import configurations, starts_of

ARMS = ("ur5e_ik", "irb120_ik", "kr6_r900_ik", "fanuc_crx10ia_ik")
CELLS = ("tx2_90", "yumi")
POSES = 5_000


def made(name: str) -> tuple[Manipulator, Chain]:
    """The judge's arm, and ours by its own numbers."""
    arm = Manipulator.from_prebuilt(name)
    R, p, axes, T = [], [], [], np.eye(4)
    for joint in arm.kinbody.joints:
        T = T @ joint.T_left
        R.append(T[:3, :3])
        p.append(T[:3, 3])
        axes.append(np.asarray(joint.axis, dtype=float))
        T = np.asarray(joint.T_right)
    R.append(T[:3, :3])
    p.append(T[:3, 3])
    lower, upper = np.array(arm.joint_limits).T.copy()
    fixed, n = (np.array(R), np.array(p), np.array(axes)), len(axes)
    return arm, Chain(*fixed, np.zeros(n), lower, upper, np.ones(n), np.ones(n))


def row(name: str, chain: Chain, starts: Floats) -> str:
    """A line of the table."""
    first = configurations(chain, chain.pose(starts[0]), starts)
    draw, missed, seconds = np.random.default_rng(1), [0, 0], [0.0, 0.0]
    for q in draw.uniform(chain.lower, chain.upper, (POSES, len(chain.axes))):
        T = chain.pose(q)
        begun = time.process_time()
        missed[0] += not len(configurations(chain, T, starts).q)
        half = time.process_time()
        missed[1] += not is_solution(chain.solve(T, starts)[1]).any()
        seconds = [seconds[0] + half - begun, seconds[1] + time.process_time() - half]
    how = "closed form" if first.is_complete else "iterations"
    now, before = (1000 * one / POSES for one in seconds)
    return f"| {name} | {how} | {missed[0]} ({missed[1]}) | {now:.2f} ms ({before:.2f}) |"


def main() -> None:
    """Print the table."""
    print("| arm | method | missed (before) | time a pose (before) |\n|---|---|---|---|")
    for name in ARMS:
        _, chain = made(name)
        draw = np.random.default_rng(0).uniform(chain.lower, chain.upper, (11, 6))
        print(row(name, chain, np.vstack([(chain.lower + chain.upper) / 2, draw])), flush=True)
    shipped = [Path("robots") / name / "cell.toml" for name in CELLS]
    for cell in map(read_cell, (*shipped, *map(Path, sys.argv[1:]))):
        for arm in cell.arms:
            chain = chain_of(cell, arm)
            print(row(f"{cell.name} {arm.name}", chain, starts_of(chain, arm, 0)), flush=True)


if __name__ == "__main__":
    main()
