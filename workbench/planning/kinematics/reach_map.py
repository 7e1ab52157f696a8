"""Where an arm gets its tool to, pointing straight down: a grid of places around it."""

from collections.abc import Callable

import numpy as np

from workbench.model.cell import Arm, Cell
from workbench.model.geometry import Floats, pose_from_rpy
from workbench.planning.kinematics.chain import chain_of, is_solution
from workbench.planning.kinematics.inverse import configurations

ACROSS = 22
"""Places along the longest side of the grid."""

VERTICAL_TURNS = (0.0, np.pi / 2)
"""[rad] About the vertical, tried at every place."""

IK_STARTS = 10
"""Starting points of the inverse kinematics for each pose."""


def reach_map(
    cell: Cell, arm: Arm, *, cancelled: Callable[[], bool] = lambda: False
) -> tuple[Floats, Floats]:
    """Places the arm reaches, whatever stands there.

    Args:
        cell: whose robot it is.
        arm: one of its arms.
        cancelled: True ends the search where it is.

    Returns:
        Places (n, 3) [m] in the world, and the share (n,) of the turns with which the tool gets
        there, above 0.
    """
    chain = chain_of(cell, arm)
    rng = np.random.default_rng(0)
    drawn = rng.uniform(chain.lower, chain.upper, (500, len(arm.joints)))
    tips = np.array([chain.pose(q).translation for q in drawn])
    starts = np.vstack([arm.home, drawn[: IK_STARTS - 1]])
    low, high = tips.min(axis=0), tips.max(axis=0)
    step = float(np.ceil((high - low).max() / ACROSS * 100) / 100)
    low = np.maximum(low, [-np.inf, -np.inf, _floor(cell)])
    axes = [
        np.arange(np.ceil(a / step), np.floor(b / step) + 1) * step
        for a, b in zip(low, high, strict=True)
    ]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 3)
    foot = chain.p[0]
    grid = grid[np.linalg.norm(grid - foot, axis=1) <= np.linalg.norm(tips - foot, axis=1).max()]
    places: list[Floats] = []
    shares: list[float] = []
    last = [starts[0]] * len(VERTICAL_TURNS)
    for p in grid:
        if cancelled():
            break
        reached = 0
        for number, turn in enumerate(VERTICAL_TURNS):
            T = pose_from_rpy(p, (np.pi, 0, turn))
            # What reached the place before mostly reaches this one.
            answers, residuals = chain.solve(T, last[number])
            found = answers[is_solution(residuals)]
            if not len(found):
                found = configurations(chain, T, starts).q
            if len(found):
                last[number] = found[0]
                reached += 1
        if reached:
            places.append(p)
            shares.append(reached / len(VERTICAL_TURNS))
    return np.array(places).reshape(-1, 3), np.array(shares)


def _floor(cell: Cell) -> float:
    """The height [m] of the lowest thing the arm could take something from or put it on."""
    heights = [cell.bin.T_world_bin.translation[2]]
    heights += [T.translation[2] for arm in cell.arms for T in arm.Ts_world_place]
    heights += [place.T_world_part.translation[2] for arm in cell.arms for place in arm.part_places]
    return float(min(heights))
