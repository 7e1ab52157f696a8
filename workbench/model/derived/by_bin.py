"""A cell by one of its bins: parts are taken from that one, and the others stand in the way."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import combinations, product

import numpy as np

from workbench.model.cell import Cell, Fixture
from workbench.model.derived.by_view import view_name, with_view
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Floats, Solid, pose_from_rpy
from workbench.model.messages.cells import BinChoiceText
from workbench.model.part import Bin
from workbench.model.scan import Detection
from workbench.model.tools.slots import standing_tools

MOST_BINS = 8


def with_bin(cell: Cell, name: str) -> Cell:
    """A cell that takes parts from the bin of that name; empty: the bin that it has now.

    Where another view sees that bin, a scanner on an arm scans from there.

    Raises:
        InputError: there is none; the message lists those there are.
    """
    if name in ("", cell.bin.name):
        return cell
    found = next((box for box in cell.other_bins if box.name == name), None)
    if found is None:
        if not cell.other_bins:
            raise InputError(BinChoiceText.ONLY(cell=cell.name))
        known = [box.name for box in cell.bins]
        raise InputError(BinChoiceText.UNKNOWN(cell=cell.name, name=f"{name:.40}", known=known))
    others = tuple(box for box in cell.bins if box is not found)
    return with_view(replace(cell, bin=found, other_bins=others), "")


def chosen_as_in(cell: Cell, other: Cell) -> Cell:
    """A cell by the bin and the view that are chosen in another one.

    Raises:
        InputError: it has no such bin or view.
    """
    return with_view(with_bin(cell, other.bin.name), view_name(other))


def bin_around(cell: Cell, p_world: Floats) -> Bin:
    """The bin of a cell over whose floor a point (3,) [m] lies, or the nearest by its sides."""

    def off(box: Bin) -> float:
        p_bin = box.T_world_bin.actInv(p_world)
        return float((np.abs(p_bin[:2]) / box.size[:2]).max())

    return min(cell.bins, key=off)


def barriers(cell: Cell) -> tuple[Fixture, ...]:
    """Fixtures, tools in their slots, and each other bin as a block: nothing reaches into it."""
    blocks = (Fixture(f"bin {b.name}", b.T_world_bin, (block_of(b),)) for b in cell.other_bins)
    return (*cell.fixtures, *standing_tools(cell), *blocks)


def surfaces(cell: Cell) -> tuple[Fixture, ...]:
    """Fixtures, tools in their slots, floor and walls of each other bin: what a scanner sees."""
    boxes = (Fixture(f"bin {b.name}", b.T_world_bin, b.solids) for b in cell.other_bins)
    return (*cell.fixtures, *standing_tools(cell), *boxes)


def block_of(box: Bin) -> Solid:
    """All of a bin as one box in its frame, up to the rim: nobody knows what lies in it."""
    middle = pose_from_rpy((0, 0, (float(box.size[2]) - box.wall) / 2))
    return Solid(f"bin {box.name}", Box(_size(box)), middle)


def _size(box: Bin) -> Floats:
    """Of its block (3,) [m]."""
    wall = box.wall if box.has_walls else 0.0
    return np.asarray(box.size) + (2 * wall, 2 * wall, box.wall)


def overlapping(bins: Sequence[Bin]) -> tuple[str, str] | None:
    """The names of two bins that overlap, walls and inside counted; None where all stand apart."""
    for one, other in combinations(bins, 2):
        if _meet(one, other):
            return one.name, other.name
    return None


def _meet(one: Bin, other: Bin) -> bool:
    """Whether two blocks meet: no face and no pair of edges has a plane between them."""
    T, U = (box.T_world_bin * block_of(box).T_owner_shape for box in (one, other))
    halves = [_size(box) / 2 for box in (one, other)]
    R, S = T.rotation, U.rotation
    axes = [*R.T, *S.T, *(np.cross(a, b) for a, b in product(R.T, S.T))]
    apart = T.translation - U.translation
    return all(
        abs(axis @ apart) < np.abs(axis @ R) @ halves[0] + np.abs(axis @ S) @ halves[1]
        for axis in axes
        if np.linalg.norm(axis) > 1e-9
    )


def is_between_walls(box: Bin, p_world: Floats) -> bool:
    """Whether a place (3,) [m] in the world is between the walls of a bin, or above that."""
    length, width, _ = box.size
    x, y, _ = box.T_world_bin.actInv(np.asarray(p_world))
    return bool(abs(x) <= length / 2 and abs(y) <= width / 2)


def part_beside_bin(cell: Cell, detections: Sequence[Detection]) -> int | None:
    """The index of the first part whose middle is not between the walls of the bin; None: no such.

    A part that a plan has put on a station is none in the bin.
    """
    for number, found in enumerate(detections):
        middle = found.T_world_part.act(np.asarray(cell.part(found.part).mesh.middle))
        if found.T_world_found is not None or not is_between_walls(cell.bin, middle):
            return number
    return None
