"""Parts that may lie otherwise since a grip has missed, and the room that such a part may fill."""

from collections.abc import Collection, Sequence
from itertools import product

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.scan import Detection, Obstacle
from workbench.model.symmetry import BALL, ROUND
from workbench.proof.claims.scene import turned_pieces
from workbench.proof.engine.shapes import gap_of

UP = np.array([0.0, 0.0, 1.0])

STANDS = np.deg2rad(45.0)
"""[rad] A round part whose axis leans by more than this from upright may roll."""


def moved_parts(
    cell: Cell, parts: Sequence[Detection], grasped: Collection[int]
) -> frozenset[int] | None:
    """The parts that may lie otherwise after grips at some of them: all parts of their heaps.

    Parts nearer to each other than the policy's `pair_gap` are of one heap.

    Args:
        cell: with the policy.
        parts: in the bin.
        grasped: indices of those that the hands have closed on, or beside.

    Returns:
        Indices, those of `grasped` among them; None where one of the parts may have rolled
        farther than `room_of_moved` holds it.
    """
    moved, last = set(grasped), list(grasped)
    while last:
        number = last.pop()
        near = [
            other
            for other in range(len(parts))
            if other not in moved and _gap(cell, parts[number], parts[other]) < cell.policy.pair_gap
        ]
        moved.update(near)
        last += near
    if any(_may_roll(cell, parts[number]) for number in moved):
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
    # A flat part that stands on its edge is beside its place by its radius, and as wide as before.
    aside = np.sqrt(2) * radius + float(np.ptp(heights)) + cell.policy.pair_gap
    above = 2 * radius + float(heights.min()) + cell.policy.pair_gap
    centre = T.act(middle)
    centre[2] += (above - aside) / 2
    size = np.array([2 * aside, 2 * aside, above + aside])
    return Obstacle(pin.SE3(np.eye(3), centre), size)


def _gap(cell: Cell, first: Detection, second: Detection) -> float:
    """[m] between two parts; at least `pair_gap` where they are farther apart."""
    here, there = (turned_pieces(cell.part(found.part), found) for found in (first, second))
    pairs = (product(piece, other) for piece, other in product(here, there))
    return min(gap_of(a, b, cell.policy.pair_gap) for pair in pairs for a, b in pair)


def _may_roll(cell: Cell, found: Detection) -> bool:
    """Whether a part is round and does not stand on its end."""
    symmetry = cell.part(found.part).symmetry
    if not found.roll_known or symmetry.form == BALL:
        return True
    axis = found.T_world_part.rotation @ symmetry.axes[0].axis if symmetry.form == ROUND else UP
    return abs(float(axis @ UP)) < np.cos(STANDS)
