"""How full a bin is as seen from above, and about how many parts that may be."""

from collections.abc import Sequence
from functools import lru_cache

import numpy as np
from scipy.spatial import ConvexHull

from workbench.model.calibration import BinCheck
from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.part import Bin, Part
from workbench.model.scan import Detection
from workbench.perception.scene.bin_fit import SeenBin, above_floor

GRID = 0.005
"""[m] Width of the pieces into which the inside is divided, seen from above."""

LOW = 0.004
"""[m] What is no higher above the floor is floor."""

OVER_CELLS = 4
"""Pieces of the grid over which something sticks out, or it is a mistake of the scanner."""

LEAST_INSIDE = 0.3
"""Share of the inside that must be seen to say how full the bin is."""

MORE = 1.6
"""So many times as many parts as were found have to be there to be told of: 12 pucks in a heap, all
found, took the room of 19."""


def parts_in_words(cell: Cell, check: BinCheck, found: Sequence[Detection]) -> str:
    """How many parts were found, and of about how many where more seem to lie in the bin.

    A heap takes, as seen from above, about the room of its parts' convex hulls: what is hidden
    below them and what is hollow in them make up for each other (`docs/benchmarks/seeing.md` says
    how well).
    """
    count = len(found)
    noun = "part" if count == 1 else "parts"
    if check.fill is None or check.is_empty:
        return f"{count} {noun}"
    rooms = {part.name: _room(part) for part in cell.parts}
    kinds = [one.part for one in found if one.part in rooms] or list(rooms)
    taken = check.fill * float(np.prod(cell.bin.size))
    about = round(taken / float(np.mean([rooms[kind] for kind in kinds])))
    return f"{count} of about {about} parts" if about > MORE * count else f"{count} {noun}"


@lru_cache(maxsize=64)
def _room(part: Part) -> float:
    """The volume [m3] of a part's convex hull."""
    return float(ConvexHull(part.mesh.points).volume)


def filled(p_bin: Floats, bin: Bin, seen: SeenBin) -> tuple[float | None, float, float]:
    """Share of the room taken or None, what sticks out [m], and share of the floor covered.

    Args:
        p_bin: (n, 3) [m] of a scan, in the frame of the bin.
        bin: its size.
        seen: where its floor is.
    """
    inner, height = np.asarray(bin.size[:2]) / 2 - GRID, float(bin.size[2])
    inside = p_bin[(np.abs(p_bin[:, :2]) < inner).all(axis=1) & (p_bin[:, 2] < 4 * height + 0.2)]
    shape = tuple(np.maximum(1, np.ceil(2 * inner / GRID).astype(int)))
    index = np.minimum(((inside[:, :2] + inner) / GRID).astype(int), np.array(shape) - 1)
    flat = index[:, 0] * shape[1] + index[:, 1]
    total, count = int(np.prod(shape)), np.bincount(flat, minlength=int(np.prod(shape)))
    # The mean of a piece does not jump with one stray point, as its highest would.
    heights = np.bincount(flat, inside[:, 2], total)[count > 0] / count[count > 0]
    deep = np.bincount(flat, above_floor(seen, bin.size, inside), total)[count > 0]
    deep = deep / count[count > 0]
    if len(heights) < LEAST_INSIDE * total:
        return None, 0.0, 0.0
    over = np.sort(heights[heights > height])
    above = float(over[-OVER_CELLS] - height) if len(over) >= OVER_CELLS else 0.0
    taken = np.where(deep > LOW, np.clip(deep, 0.0, height), 0.0)
    return float(taken.mean() / height), above, float(np.mean(deep > LOW))
