"""How full a bin is as seen from above, and about how many parts that may be."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from workbench.model.calibration import BinCheck
from workbench.model.cell import Cell
from workbench.model.geometry import Bools, Floats
from workbench.model.messages.calibration import BinText
from workbench.model.messages.message import Message
from workbench.model.part import Bin, Part
from workbench.model.scan import Detection
from workbench.perception.bins.bin_fit import SeenBin, above_floor

GRID = 0.005
"""[m] Width of the pieces into which the inside is divided, seen from above."""

LOW = 0.004
"""[m] What is no higher above the floor takes no room."""

FLATTEST, LOW_OVER_NOISE = 0.001, 4.0
"""[m] A point this high above the floor shows that something lies there, or this many deviations of
the floor's points."""

FLAT_POINTS, FLAT_SHARE = 6, 0.4
"""This many such points on a square of two by two pieces of the grid, and this share of all on it,
show something flat: stray points of scanners lie alone."""

MARGIN = 0.01
"""[m] Beside walls nothing flat is searched for: scanners smooth wall and floor into each other."""

OVER_CELLS = 4
"""Pieces of the grid over which something sticks out, or it is a mistake of the scanner."""

LEAST_INSIDE = 0.3
"""Share of the inside that must be seen to say how full the bin is."""

MORE = 1.6
"""Ratio of estimated to found parts from which on missed parts are reported: a heap of 12 pucks,
all found, fills the volume of 19."""


def parts_in_words(cell: Cell, check: BinCheck, found: Sequence[Detection]) -> Message:
    """How many parts were found, and of about how many where more seem to lie in the bin.

    A heap takes, as seen from above, about the room of its parts' convex hulls: what is hidden
    below them and what is hollow in them make up for each other (`docs/benchmarks/seeing.md` says
    how well).
    """
    count = len(found)
    if check.fill is None or check.is_empty:
        return BinText.PARTS(count=count)
    rooms = {part.name: _room(part) for part in cell.parts}
    kinds = [detection.part for detection in found if detection.part in rooms] or list(rooms)
    taken = check.fill * float(np.prod(cell.bin.size))
    about = round(taken / float(np.mean([rooms[kind] for kind in kinds])))
    if about > MORE * count:
        return BinText.PARTS_OF(count=count, about=about)
    return BinText.PARTS(count=count)


@lru_cache(maxsize=64)
def _room(part: Part) -> float:
    """The volume [m3] of a part's convex hull."""
    from scipy.spatial import ConvexHull  # takes a while, and planning asks for no hulls

    return float(ConvexHull(part.mesh.points).volume)


@dataclass(frozen=True, slots=True)
class Filling:
    """What lies in a bin, seen from above.

    `fill` is the share of its room that is taken, None where its inside is hardly seen; `above` [m]
    how far something sticks out; `covered` the share of the floor under something higher than
    `LOW`.  `is_flat_seen`: something lies there that is higher than `lowest` [m].  `seen` is the
    share of the inside of which something was seen.
    """

    fill: float | None
    above: float
    covered: float
    lowest: float
    is_flat_seen: bool
    seen: float


def filled(p_bin: Floats, bin: Bin, seen: SeenBin) -> Filling:
    """How full a bin is.

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
    total = int(np.prod(shape))
    count = np.bincount(flat, minlength=total)
    shown = count > 0
    share = float(shown.mean())
    if share < LEAST_INSIDE:
        return Filling(None, 0.0, 0.0, LOW, is_flat_seen=False, seen=share)
    # The mean of a piece does not jump with one stray point, as its highest would.
    heights = (np.bincount(flat, inside[:, 2], total) / np.maximum(count, 1))[shown]
    over_floor = above_floor(seen, bin.size, inside)
    deep = (np.bincount(flat, over_floor, total) / np.maximum(count, 1))[shown]
    over = np.sort(heights[heights > height])
    above = float(over[-OVER_CELLS] - height) if len(over) >= OVER_CELLS else 0.0
    taken = np.where(deep > LOW, np.clip(deep, 0.0, height), 0.0)
    lowest = float(np.clip(LOW_OVER_NOISE * seen.noise, FLATTEST, LOW))
    return Filling(
        float(taken.mean() / height),
        above,
        float(np.mean(deep > LOW)),
        lowest,
        is_flat_seen=_is_flat_seen(inside, over_floor > lowest, np.asarray(bin.size[:2]) / 2),
        seen=share,
    )


def _is_flat_seen(inside: Floats, is_higher: Bools, half: Floats) -> bool:
    """Whether points (n, 3), some of them higher than the floor, show that something lies there."""
    free = (np.abs(inside[:, :2]) < half - MARGIN).all(axis=1)
    edges = [np.arange(-size, size + GRID, GRID) for size in half - MARGIN]
    if min(map(len, edges)) < 3:
        return False
    both = [
        sliding_window_view(np.histogram2d(*inside[chosen, :2].T, bins=edges)[0], (2, 2)).sum(
            axis=(2, 3)
        )
        for chosen in (free, free & is_higher)
    ]
    return bool(np.any((both[1] >= FLAT_POINTS) & (both[1] >= FLAT_SHARE * both[0])))
