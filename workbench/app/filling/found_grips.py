"""Grips that a plan's search has found, added to the libraries of their parts."""

from dataclasses import replace

from workbench.app.core.cell.part_edits import EditPart
from workbench.app.filling.naming import make_name
from workbench.model.cell import Cell
from workbench.model.messages.commands import GraspEditText
from workbench.model.part import Entry, Grasp, widen_grasp
from workbench.model.plan import Plan


def make_found_commands(cell: Cell, plan: Plan) -> list[EditPart]:
    """The commands that add the grips which a plan's search has found, one for each kind of part.

    Args:
        cell: that the plan is of.
        plan: with grips that no library has, or without.
    """
    added: dict[str, list[Entry]] = {}
    for arm_plan in plan.arms:
        found, name = arm_plan.found, plan.detections[arm_plan.detection].part
        if found is None:
            continue
        part, entries = cell.part(name), added.setdefault(name, [])
        grasp = Grasp("", found.T_part_tcp, found.opening, found.grip)
        # In a library without the room for the part's tolerance, which is added when it is used.
        grasp = widen_grasp(grasp, -(part.tolerance or 0.0))
        taken = {entry.name for entry in (*part.library.entries, *entries)}
        tool = cell.arm(arm_plan.arm).tool.name
        name_of_grip = make_name(part, grasp, taken)
        entries.append(replace(grasp, name=name_of_grip, tool=tool, tcp=arm_plan.tcp))
    return [
        EditPart(
            name,
            (),
            tuple(entries),
            says=GraspEditText.FOUND(grasps=tuple(entry.name for entry in entries)),
        )
        for name, entries in added.items()
    ]
