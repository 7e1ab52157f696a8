"""What a recipe assembles: which parts come onto which others."""

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell
from workbench.model.derived.by_recipe import kit_of
from workbench.model.messages.cells import SeenBaseText
from workbench.model.messages.message import Message
from workbench.model.recipes.kit import Insertion
from workbench.model.scan import Detection, Obstacle


def assembled_kinds(cell: Cell) -> frozenset[str]:
    """The kinds that come onto another part of the kit, or that others come onto."""
    insertions = [item.insertion for item in kit_of(cell)]
    bases = {insertion.base for insertion in insertions if insertion is not None}
    return frozenset(bases | {item.part for item in kit_of(cell) if item.insertion is not None})


def insertion_of(cell: Cell, part: str) -> Insertion | None:
    """How parts of a kind come onto another one of the kit; None for kinds that do not."""
    return next((item.insertion for item in kit_of(cell) if item.part == part), None)


def bases_to_see(cell: Cell, standing: Iterable[str]) -> frozenset[str]:
    """The kinds that a scan has to show before a part comes onto them.

    Args:
        cell: by its recipe.
        standing: the kinds that are in the assembly already.
    """
    there = set(standing)
    lacking = (item.insertion for item in kit_of(cell) if item.part not in there)
    return frozenset(each.base for each in lacking if each is not None and each.look_again)


def sight_problem(
    insertion: Insertion, obstacles: Sequence[Obstacle], scan_digest: str | None = None
) -> Message | None:
    """Why a part may not come onto its base yet, which a scan has to show; None where it may.

    Args:
        insertion: of the part.
        obstacles: of the plan, the base among them.
        scan_digest: of the scan of the plan; None where it is not compared.
    """
    box = next((box for box in obstacles if box.part == insertion.base), None)
    if box is None or not insertion.look_again:
        return None
    if box.seen is None or (scan_digest is not None and box.seen.scan not in ("", scan_digest)):
        return SeenBaseText.PUT_SINCE(base=insertion.base)
    return None if box.seen.problem is None else box.seen.message(insertion.base)


def is_base_unseen(obstacles: Iterable[Obstacle]) -> bool:
    """Whether a scan does not show a part that it has to show, as a plan knows it."""
    return any(box.seen is not None and box.seen.problem is not None for box in obstacles)


def looks_again(cell: Cell) -> bool:
    """Whether a part of the kit comes only onto a base that the scan shows."""
    return bool(bases_to_see(cell, ()))


def seen_pose(detection: Detection, obstacles: Iterable[Obstacle]) -> pin.SE3 | None:
    """`T_world_part` of a part that was put down, where a scan shows it; None where none does.

    Args:
        detection: as the hand has let go of it.
        obstacles: with what scans show of them.
    """
    for box in obstacles:
        T = box.T_world_put
        if box.seen is None or T is None or box.part != detection.part:
            continue
        if T.isApprox(detection.T_world_part, 1e-6):
            return box.seen.T_world_part
    return None


def with_poses_seen(
    placed: Iterable[Detection], obstacles: Sequence[Obstacle]
) -> tuple[Detection, ...]:
    """Parts that were put down, each where a scan shows it, or has shown it before.

    Args:
        placed: as the hands have let go of them.
        obstacles: of a plan, with what its scan shows of them.
    """
    return tuple(
        detection if T is None else replace(detection, T_world_seen=T)
        for detection in placed
        for T in [seen_pose(detection, obstacles)]
    )


def standing_parts(cell: Cell, obstacles: Iterable[Obstacle]) -> tuple[Detection, ...]:
    """The parts that surely stand in the assembly, without those that a scan does not show."""
    kinds = assembled_kinds(cell)
    return tuple(
        Detection(box.part, rest_pose(cell, box))
        for box in obstacles
        if box.part in kinds and (box.seen is None or box.seen.problem is None)
    )


def assembled_pose(cell: Cell, obstacles: Sequence[Obstacle], part: str) -> pin.SE3 | None:
    """`T_world_part` of the part of a kind that surely is in the assembly; None where none is."""
    return next((rest_pose(cell, box) for box in obstacles if part and box.part == part), None)


def rest_pose(cell: Cell, box: Obstacle) -> pin.SE3:
    """`T_world_part` of a part of an assembly, from the box around it."""
    return box.T_world_box * pin.SE3(np.eye(3), -cell.part(box.part).mesh.middle)
