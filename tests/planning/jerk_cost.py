"""What limits of jerk cost: the cycle, and processor time of planning and proving, in pairs.

PYTHONPATH=.:tests/planning python tests/planning/jerk_cost.py --cell yumi --piles 20 --first 7000

Each pile is planned by the cell as it is and by the cell with limits of jerk, one after the other.
Ruckig says what the straight way between the ends of each leg takes, each joint by itself.
"""

import argparse
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from ruckig import InputParameter, Ruckig, Trajectory

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.model.cell import Cell
from workbench.model.plan import ArmPlan
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.kinematics.execution import compute_times
from workbench.plugins.robot_link import spoken_to_by

RATIOS = (None, 50.0, 20.0, 10.0)
"""[1/s] Jerk over acceleration: which builds up in 20, 50 and 100 ms."""


def with_jerk(cell: Cell, ratio: float | None) -> Cell:
    """The cell with that much jerk, or without limits of it."""
    jerks = [None if ratio is None else arm.acceleration * ratio for arm in cell.arms]
    return replace(
        cell, arms=tuple(replace(a, jerk=j) for a, j in zip(cell.arms, jerks, strict=True))
    )


def by_ruckig(far: np.ndarray, *limits: np.ndarray) -> float:
    """What joints need from rest to rest [s]."""
    asked, found = InputParameter(len(far)), Trajectory(len(far))
    asked.current_position, asked.target_position = [0.0] * len(far), far.tolist()
    asked.max_velocity, asked.max_acceleration, asked.max_jerk = (one.tolist() for one in limits)
    Ruckig(len(far)).calculate(asked, found)
    return found.duration


class Row(NamedTuple):
    """Of one plan: seconds, those of computing in processor time, and whether it is proven.

    Planning includes a proof.
    """

    cycle: float
    bound: float
    planning: float
    proving: float
    straight: list[float]
    holds: bool


def row_of(cell: Cell, pile: Sequence[Detection]) -> Row | None:
    """A pile planned and proven, None without a plan."""
    began = time.process_time()
    result = plan_pick(cell, pile, "scan", seed=0)
    plan = result.plan
    planned = time.process_time()
    if plan is None:
        return None
    proof = prove(cell, plan)
    proven = time.process_time()
    straight = [share for one in plan.arms for share in straight_shares(cell, one)]
    return Row(
        plan.cycle_seconds,
        result.bound,
        planned - began,
        proven - planned,
        straight,
        proof.holds,
    )


def straight_shares(cell: Cell, one: ArmPlan) -> Iterator[float]:
    """What the straight way between the ends of each leg takes, as a share of Ruckig's time."""
    arm = cell.arm(one.arm)
    if arm.jerk is None:
        return
    velocity = cell.robot.limits(arm.joints)[2] * cell.policy.speed
    # A joint that just reaches its acceleration, to the last digit, is no input for Ruckig.
    acceleration, jerk = np.asarray(arm.acceleration) * (1 + 1e-9), np.asarray(arm.jerk)
    for leg in one.legs:
        ends = np.asarray(leg.q)[[0, -1]]
        if np.abs(ends[1] - ends[0]).max() > 1e-6:
            taken = compute_times(ends, velocity, acceleration, cell.zone, jerk)[-1]
            yield taken / by_ruckig(ends[1] - ends[0], velocity, acceleration, jerk)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--cell", default="yumi")
    parser.add_argument("--link", default="")
    parser.add_argument("--parts", type=int, default=4)
    parser.add_argument("--piles", type=int, default=20)
    parser.add_argument("--first", type=int, default=7000)
    asked = parser.parse_args()
    plain = read_cell(asked.cell)
    if asked.link:
        plain = spoken_to_by(plain, asked.link)
    cells = {ratio: with_jerk(plain, ratio) for ratio in RATIOS}
    found: dict[float | None, list[Row]] = {ratio: [] for ratio in RATIOS}
    for seed in range(asked.first - 1, asked.first + asked.piles):
        pile = drop_parts((plain.parts[0],) * asked.parts, plain.bin, seed=seed)
        rows = {ratio: row_of(cell, pile) for ratio, cell in cells.items()}
        # The first one loads compiled code; a pile that some cell has no plan for is left out.
        if seed >= asked.first and None not in rows.values():
            for ratio, row in rows.items():
                found[ratio].append(row)
    plans = [row for rows in found.values() for row in rows]
    corners, count = plain.controller.motion.corners, len(found[None])
    print(f"{plain.name}, {corners}: {count} of {asked.piles} piles planned by each cell")
    print(f"{sum(row.holds for row in plans)} of {len(plans)} plans hold")
    for ratio, rows in found.items():
        shares = [row.cycle / plain.cycle for row, plain in zip(rows, found[None], strict=True)]
        words = f"jerk {ratio}: cycle {np.median([row.cycle for row in rows]):.2f} s"
        words += f", x {np.median(shares):.3f}, at most {max(shares):.3f}"
        words += f"; bound {np.median([row.bound for row in rows]):.2f} s"
        words += f"; planning {1000 * np.median([row.planning for row in rows]):.0f} ms"
        words += f", proving {1000 * np.median([row.proving for row in rows]):.0f} ms"
        if ratio is not None:
            some = [share for row in rows for share in row.straight]
            words += f"; straight / Ruckig {np.median(some):.3f}, at most {max(some):.3f}"
        print(words)


if __name__ == "__main__":
    main()
