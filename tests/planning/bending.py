"""Plans and cells with something changed, for several test files."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from workbench.model.cell import Cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.part import Grasp, GraspLibrary, PartPlace
from workbench.model.plan import Plan


def with_leg(plan: Plan, arm: str, name: str, **changes) -> Plan:
    """The plan with one leg changed."""
    arms = tuple(
        replace(
            one,
            legs=tuple(
                replace(leg, **changes) if (one.arm, leg.name) == (arm, name) else leg
                for leg in one.legs
            ),
        )
        for one in plan.arms
    )
    return replace(plan, arms=arms)


def with_grasps(cell: Cell, change: Callable[[Grasp], Grasp]) -> Cell:
    """The cell with every grasp of its first part changed."""
    part = cell.parts[0]
    library = GraspLibrary(tuple(map(change, part.library.grasps)))
    return replace(cell, parts=(replace(part, library=library),))


def with_nests(cell: Cell, **changes) -> Cell:
    """The cell with no places of hands: beside the bin each arm has one for a part that stands."""

    def nest(side: float) -> PartPlace:
        return replace(PartPlace(pose_from_rpy((0.33, side * 0.33, 0.13))), **changes)

    arms = (
        replace(arm, Ts_world_place=(), part_places=(nest(np.sign(0.5 - (arm.name == "right"))),))
        for arm in cell.arms
    )
    return replace(cell, arms=tuple(arms))
