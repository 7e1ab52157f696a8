"""Parts that may lie otherwise since a grip has missed, and the room that such a part may fill."""

from collections.abc import Collection, Iterator, Sequence
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.geometry import Box, Floats, Shape
from workbench.model.part import Part
from workbench.model.scan import Detection, Obstacle
from workbench.proof.claims.scene import turned_pieces
from workbench.proof.engine.shapes import gap_of

STANDS = np.deg2rad(45.0)
"""[rad] A part that is round about an axis rolls where that leans by more than this."""

ROUND_SHARE = 0.8
"""From narrowest to widest: what is rounder seen along an axis may roll about it; a hexagon has
0.87, a square 0.71."""

FLAT_SHARE = 0.5
"""A part that is lower than this share of its width stays on its face when it is pushed."""

WIDTH_DIRECTIONS = 36
"""In which a width is measured, over half a turn."""

Placed = tuple[Shape, pin.SE3]


def moved_parts(
    cell: Cell,
    parts: Sequence[Detection],
    grasped: Collection[int],
    disturbed: Sequence[Detection] = (),
) -> frozenset[int] | None:
    """The parts that may lie otherwise after grips at some of them.

    A part does that lies nearer than the policy's `pair_gap` to the room of another one that does
    (`room_of_moved`): that may have fallen onto it.

    Args:
        cell: with the policy.
        parts: in the bin.
        grasped: indices of those that the hands have closed on.
        disturbed: parts that grips before may have moved, as they were found.

    Returns:
        Indices, those of `grasped` among them; None where one of the parts may have rolled farther
        than `room_of_moved` holds it, or have pushed a disturbed one out of its room.
    """
    moved, last = set(grasped), list(grasped)
    while last:
        room = [[_room(cell, parts[last.pop()])]]
        near = [
            other
            for other in range(len(parts))
            if other not in moved and _is_near(cell, room, _pieces(cell, parts[other]))
        ]
        moved.update(near)
        last += near
    rooms = [[_room(cell, found)] for found in disturbed]
    for number in sorted(moved):
        mine = [[_room(cell, parts[number])]]
        if _may_roll(cell, parts[number]) or any(_is_near(cell, mine, [r]) for r in rooms):
            return None
    return frozenset(moved)


def room_of_moved(cell: Cell, found: Detection) -> Obstacle:
    """An upright box that holds a part however it lies where it was found.

    It holds the part turned by any angle about its middle, set upright, fallen over to any side, or
    pushed by the policy's `pair_gap`.  A part that rolls farther is not in it.

    Args:
        cell: with the kind of the part.
        found: as the scan showed it, before.
    """
    points, T = cell.part(found.part).mesh.points, found.T_world_part
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    radius = float(np.linalg.norm(points - middle, axis=1).max())
    heights = (points - middle) @ T.rotation[2]
    # A flat part that falls off its edge lies a radius from its place, and is as wide as before.
    aside = np.sqrt(2) * radius + float(np.ptp(heights)) + cell.policy.pair_gap
    above = 2 * radius + float(heights.min()) + cell.policy.pair_gap
    centre = T.act(middle)
    centre[2] += (above - aside) / 2
    size = np.array([2 * aside, 2 * aside, above + aside])
    return Obstacle(pin.SE3(np.eye(3), centre), size)


def _room(cell: Cell, found: Detection) -> Placed:
    room = room_of_moved(cell, found)
    return Box(room.size), room.T_world_box


def _pieces(cell: Cell, found: Detection) -> list[list[Placed]]:
    """Each piece of a part as it may lie: once, or at several turns."""
    return turned_pieces(cell.part(found.part), found)


def _is_near(cell: Cell, first: list[list[Placed]], second: list[list[Placed]]) -> bool:
    """Whether two things come nearer to each other than the policy's `pair_gap`."""
    gap = cell.policy.pair_gap
    return any(
        gap_of(a, b, gap) < gap
        for piece, other in product(first, second)
        for a, b in product(piece, other)
    )


def _may_roll(cell: Cell, found: Detection) -> bool:
    """Whether a part may roll: round about an axis that lies, or may come to lie.

    A part that stands on its end falls over and rolls then, unless it is flat.
    """
    part = cell.part(found.part)
    if not found.roll_known:
        return True
    for axis, width, length in _round_axes(part):
        stands = abs(float(found.T_world_part.rotation[2] @ axis)) >= np.cos(STANDS)
        if not stands or length >= FLAT_SHARE * width:
            return True
    return False


def _round_axes(part: Part) -> Iterator[tuple[Floats, float, float]]:
    """Axes (3,) about which a part is round, with its width across and its length along each [m].

    Those of its frame, of its symmetry and of the spread of its points are looked along.
    """
    points = np.asarray(part.mesh.points)
    _, spread = np.linalg.eigh(np.cov(points.T))
    stated = [known.axis for known in part.symmetry.axes]
    for axis in (*np.eye(3), *spread.T, *stated):
        _, _, across = np.linalg.svd(np.asarray(axis)[None])
        angles = np.linspace(0.0, np.pi, WIDTH_DIRECTIONS, endpoint=False)
        ways = np.column_stack([np.cos(angles), np.sin(angles)]) @ across[1:]
        widths = np.ptp(points @ ways.T, axis=0)
        if widths.min() >= ROUND_SHARE * widths.max():
            yield np.asarray(axis), float(widths.max()), float(np.ptp(points @ axis))
