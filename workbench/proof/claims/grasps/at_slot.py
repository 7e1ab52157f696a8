"""Whether a flange goes straight into the slot of a tool, and out of it, as the slot states."""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.cell import Cell, Tool
from workbench.model.geometry import Floats
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import SLOT_LEGS, LegName
from workbench.model.plan import Plan, Violation
from workbench.model.robot import ToolSlot
from workbench.model.tools.slots import NO_TOOL
from workbench.proof.claims.grasps.straight import straight_violations
from workbench.proof.claims.stages import INTO_SLOT, tcp
from workbench.proof.claims.tolerances import AT_SLOT
from workbench.proof.engine.robot import Tree


def slot_violations(cell: Cell, tree: Tree, plan: Plan) -> Iterator[Violation]:
    """Whether the straight legs of a stretch go as its slot states, from its pose or to it.

    Args:
        cell: as it is on the stretch.
        tree: of its robot.
        plan: of the stretch.
    """
    for arm_plan in plan.arms if plan.is_tool_plan else ():
        arm = cell.arm(arm_plan.arm)
        slot = next(slot for slot in arm.tool_slots if slot.tool == arm_plan.tool)
        tool = next(tool for tool in arm.tools if tool.name == arm_plan.tool)
        flange = replace(arm, tool=NO_TOOL)
        for leg in arm_plan.legs:
            if leg.name not in SLOT_LEGS:
                continue
            path, at = np.asarray(leg.q), len(leg.q) - 1 if leg.name in INTO_SLOT else 0
            off = _displacement(tool, tcp(tree, tree.rest, flange, path[at]), slot.T_world_flange)
            if not off <= AT_SLOT:
                problem = ProofText.NOT_AT_SLOT(off=off, tool=tool.name)
                yield Violation(problem, arm.name, leg.name, at)
            way = _way(slot, leg.name)
            yield from (
                replace(found, problem=ProofText.OTHER_LEAVE(tool=tool.name))
                if found.problem.text is ProofText.OTHER_DIRECTION
                else found
                for found in straight_violations(
                    tree, flange, leg.name, path, way, reach=tool.reach
                )
            )


def _displacement(tool: Tool, T: pin.SE3, other: pin.SE3) -> float:
    """How far [m] two poses of the flange put any point of a tool apart, at most."""
    turn = float(np.linalg.norm(pin.log3(T.rotation.T @ other.rotation)))
    return float(np.linalg.norm(T.translation - other.translation)) + turn * tool.reach


def _way(slot: ToolSlot, leg: LegName) -> Floats:
    """How far (3,) [m] the flange goes in the world on a straight leg at a slot."""
    out = -slot.T_world_flange.rotation[:, 2]
    if leg in ("stow", "undock"):
        out = np.asarray(slot.leave) / np.linalg.norm(slot.leave)
    return (-slot.distance if leg in INTO_SLOT else slot.distance) * out
