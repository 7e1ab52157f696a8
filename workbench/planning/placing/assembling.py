"""Where an arm may put a part of an assembly."""

from dataclasses import replace

import numpy as np

from workbench.model.candidate import Reason, Stage, Verdict
from workbench.model.cell import Arm
from workbench.model.derived.assembling import assembled_kinds, assembled_pose, insertion_of
from workbench.model.messages.cells import KitText
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.part import PartPlace
from workbench.planning.collision.world import World


def arm_placing(world: World, arm: Arm, number: int) -> Arm | Verdict:
    """An arm with the places that count for a part found; or why there are none.

    What a recipe assembles has to lie in a known way: places of the hand do not count.  A part that
    comes onto another one has one place, its seat there.

    Args:
        world: whose obstacles say what stands in the assembly.
        arm: that brings the part.
        number: of the detection.
    """
    found = world.detections[number]
    if found.part not in assembled_kinds(world.cell):
        return arm
    note, insertion = None, insertion_of(world.cell, found.part)
    base = "" if insertion is None else insertion.base
    T_world_base = assembled_pose(world.cell, world.obstacles, base)
    if assembled_pose(world.cell, world.obstacles, found.part) is not None:
        note = KitText.HAS_ENOUGH(part=found.part)
    elif not found.roll_known:
        note = VerdictNote.PLACE_NEEDS_ROLL()
    elif base and T_world_base is None:
        note = VerdictNote.NO_BASE(base=base)
    if note is not None:
        return Verdict(Reason.NO_PLACE, Stage.PLACE, note=note)
    arm = replace(arm, Ts_world_place=(), place_names=())
    if insertion is None or T_world_base is None:
        return arm
    x, y, z = (T_world_base.rotation @ np.array(insertion.along)).tolist()
    T_seat = T_world_base * insertion.T_base_part
    seat = PartPlace(T_seat, found.part, approach=(x, y, z), length=insertion.length)
    return replace(arm, part_places=(seat,))
