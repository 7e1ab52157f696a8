"""Parts that stand in an assembly, as a scan shows them: the next part comes to where they are."""

from collections.abc import Sequence
from dataclasses import replace

import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.assembling import assembled_kinds, bases_to_see, rest_pose
from workbench.model.geometry import shift_and_turn
from workbench.model.recipes.seen_base import MOST_SHIFT, MOST_TURN, SeenBase, SightProblem
from workbench.model.scan import Detection, Obstacle, Scan
from workbench.proof.claims.places.layers import kept_box

SAME_SHIFT, SAME_TURN = 2e-5, 3.5e-4
"""[m, rad] By so much poses seen differ between machines; see `docs/inside.md`."""


def with_sight(cell: Cell, scan: Scan | None, boxes: Sequence[Obstacle]) -> tuple[Obstacle, ...]:
    """Boxes around parts that were put down; bases that a scan has to show are where it does.

    How far a base is off counts from where it was put, wherever a scan before has shown it.

    Args:
        cell: by its recipe.
        scan: in which the other parts were found; None where there is none.
        boxes: around all that stands or lies there, where it is believed.
    """
    wanted = bases_to_see(cell, [box.part for box in boxes])
    put = {box.part: box for box in _as_put(cell, boxes)} if wanted else {}
    return tuple(
        _seen(cell, scan, box, put[box.part]) if box.part in wanted else box for box in boxes
    )


def _as_put(cell: Cell, boxes: Sequence[Obstacle]) -> tuple[Obstacle, ...]:
    """The parts of an assembly among some boxes, each where it has fallen to from the hand."""
    believed: list[Obstacle] = []
    for box in boxes:
        if box.T_world_put is not None and box.part in assembled_kinds(cell):
            put = Detection(box.part, box.T_world_put)
            believed.append(kept_box(cell, believed, put, box.T_world_put))
    return tuple(believed)


def as_scan_shows(cell: Cell, scan: Scan, obstacles: Sequence[Obstacle]) -> tuple[Obstacle, ...]:
    """The parts on pallets and in assemblies that a plan states, as far as the scan agrees.

    A base that the scan shows elsewhere, or not at all, is as the scan has it.

    Args:
        cell: by its recipe.
        scan: of the plan.
        obstacles: that the plan states.
    """
    kept = tuple(box for box in obstacles if box.part)
    seen = {
        box.part: box for box in with_sight(cell, scan, _as_put(cell, kept)) if box.seen is not None
    }
    return tuple(
        box if box.part not in seen or _is_same(box, seen[box.part]) else seen[box.part]
        for box in kept
    )


def _seen(cell: Cell, scan: Scan | None, box: Obstacle, put: Obstacle) -> Obstacle:
    """The box around a part that was `put` where a scan shows it; as it is where none does."""
    if scan is None:
        return replace(box, seen=SeenBase("", problem=SightProblem.NO_SCAN))
    # Brings Open3D along, which sessions without such parts spare.
    from workbench.perception.standing.second_look import find_standing

    T_believed = rest_pose(cell, put)
    seen = find_standing(scan, cell, cell.part(box.part), T_believed)
    if seen.T_world_part is None:
        return replace(box, seen=seen)
    T_part_box: pin.SE3 = T_believed.actInv(put.T_world_box)
    return replace(box, T_world_box=seen.T_world_part * T_part_box, seen=seen)


def _is_same(stated: Obstacle, seen: Obstacle) -> bool:
    """Whether a plan states of a part what the scan shows of it.

    Of a plan for poses from outside no scan is asked: it puts nothing onto the part.
    """
    if stated.seen is not None and stated.seen.problem is SightProblem.NO_SCAN:
        return True
    if stated.seen is None or seen.seen is None or stated.seen.problem is not seen.seen.problem:
        return False
    shift, turn = shift_and_turn(stated.T_world_box.actInv(seen.T_world_box))
    if seen.seen.problem is not None:
        # It may be where another scan has shown it.
        return shift <= MOST_SHIFT and turn <= MOST_TURN
    return shift <= SAME_SHIFT and turn <= SAME_TURN
