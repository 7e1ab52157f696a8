"""What a bend is of, and what bends draw by: a plan in a cell and a scene."""

from dataclasses import dataclass

import numpy as np
from judge_files import Files

from workbench.model.cell import Cell
from workbench.model.plan import Plan
from workbench.model.scan import Scene


@dataclass(frozen=True, eq=False)
class Case:
    """A plan in a cell and a scene; the cell also as the judge reads it."""

    cell: Cell
    files: Files
    scene: Scene
    plan: Plan


Draw = np.random.Generator


def one_of(items, draw: Draw):
    return items[draw.integers(len(items))]


def small(draw: Draw, low: float, high: float) -> float:
    """Of any size between two, small ones as often as large ones."""
    return float(10 ** draw.uniform(np.log10(low), np.log10(high)))


def near_a_way(case: Case, draw: Draw) -> np.ndarray:
    """A place (3,) [m] above the bin, or by where parts are put."""
    if draw.random() < 0.6:
        room = np.append(case.cell.bin.size[:2] * 0.9, 0.35)
        return case.cell.bin.T_world_bin.act((draw.random(3) - [0.5, 0.5, -0.05]) * room)
    arm = case.cell.arm(one_of(case.plan.arms, draw).arm)
    Ts = (*arm.Ts_world_place, *(place.T_world_part for place in arm.part_places))
    T = one_of(Ts, draw)
    return T.translation + draw.normal(0, 0.08, 3)
