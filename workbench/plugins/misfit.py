"""Why the controller of a cell cannot run a plan as it was proven."""

import numpy as np

from workbench.model.cell import Cell
from workbench.model.messages.cells import SlotText
from workbench.model.messages.devices import DeviceText
from workbench.model.messages.message import Message
from workbench.model.messages.refusals import Refusal
from workbench.model.plan import Plan
from workbench.model.release import AS_PLANNED, Manner


def link_problem(cell: Cell) -> Message | None:
    """Why the link of a cell does not know its controller's numbers or outputs; else None."""
    motion = cell.controller.motion
    mapped = [arm.name for arm in cell.arms if arm.mapping is not None]
    if mapped and not motion.maps_axes:
        return DeviceText.NO_MAPPING(link=motion.link, arm=mapped[0])
    tools = [tool for arm in cell.arms for tool in (arm.tool, *arm.tools)]
    switched = [tcp.name for tool in tools for tcp in tool.tcps if tcp.output is not None]
    if switched and not motion.takes_outputs:
        return DeviceText.NO_OUTPUTS(link=motion.link, tcp=switched[0])
    return None


def misfit(plan: Plan, cell: Cell, manner: Manner = AS_PLANNED) -> Message | None:
    """Why the controller of a cell cannot run a plan as it was proven, in this manner; else None.

    The controller is not in the cell's digest: a plan may have been made for another one.
    """
    motion = cell.controller.motion
    if problem := link_problem(cell):
        return problem
    if motion.sends_poses and not plan.picks:
        return DeviceText.NO_PATHS(link=motion.link)
    if plan.is_tool_plan and not motion.takes_tools:
        return SlotText.NO_LINK(link=motion.link)
    if plan.is_drop_plan and not motion.keeps_hand:
        return Refusal.DROP_NO_LINK(link=motion.link)
    if plan.is_stir_plan and not motion.takes_share:
        return DeviceText.NO_TIMES(link=motion.link)
    if any(len(step.runs) > motion.arms_at_once for step in plan.sequence):
        return DeviceText.ONE_ARM(link=motion.link)
    if not all(motion.is_sendable(leg.q) for arm in plan.arms for leg in arm.legs):
        return DeviceText.FINER_STEPS(link=motion.link)
    share, is_stepped = manner
    if share < 1.0 and not motion.takes_share:
        return DeviceText.NO_SHARE(link=motion.link)
    if is_stepped and not motion.takes_steps:
        return DeviceText.NO_STEPS(link=motion.link)
    longest = max(float(np.diff(leg.t).max()) for arm in plan.arms for leg in arm.legs) / share
    if longest > motion.longest:
        return DeviceText.TOO_SLOW(
            share=share, longest=longest, link=motion.link, most=motion.longest
        )
    return None
