"""Plans and cells with something changed, for several test files."""

from collections.abc import Callable
from dataclasses import replace

from workbench.model.cell import Cell
from workbench.model.part import Grasp, GraspLibrary
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
