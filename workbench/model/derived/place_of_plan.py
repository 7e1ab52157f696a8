"""Which of its arm's places a plan brings a part to."""

import numpy as np

from workbench.model.cell import Cell
from workbench.model.derived.by_tcp import by_taking
from workbench.model.plan import ArmPlan


def place_number(cell: Cell, arm_plan: ArmPlan) -> int:
    """The place where an arm lets go of its part, counted from 1; 0 where it is none.

    Places of the tool come first, then those of parts, each in the order of the cell file.  The
    nearest one counts: places do not overlap.
    """
    arm = by_taking(cell, arm_plan).arm(arm_plan.arm)
    held = [leg for leg in arm_plan.legs if leg.holding]
    if arm_plan.station or not held:
        return 0
    values = dict(zip(arm_plan.joints, map(float, held[-1].q[-1]), strict=True))
    T_robot_flange = cell.robot.link_poses(values)[arm.flange]
    T_world_tcp = cell.T_world_robot * T_robot_flange * arm.tool.T_flange_tcp
    T_world_part = T_world_tcp * arm_plan.T_tcp_part
    away = [T_world_tcp.translation - T.translation for T in arm.Ts_world_place]
    away += [T_world_part.translation - p.T_world_part.translation for p in arm.part_places]
    return int(np.argmin(np.linalg.norm(away, axis=1))) + 1 if away else 0
