"""The path of a scanner on an arm to its view, or home: one free leg, as it will be sent."""

import numpy as np

from workbench.model.candidate import Verdict
from workbench.model.geometry import Floats
from workbench.model.load import tool_loads
from workbench.model.plan import Plan
from workbench.model.scan import Scene
from workbench.planning.collision.pairing import LegPhase
from workbench.planning.collision.world import World
from workbench.planning.empty_hand.alone import arm_alone, plan_alone, random_of
from workbench.planning.picking.put_down import posture_of
from workbench.planning.picking.route import free_path, leg_of
from workbench.planning.planners.clock import working_time


def route_view(
    world: World, arm_name: str, between: tuple[Floats, Floats], *, scan_digest: str, seed: int
) -> Plan | Verdict:
    """A plan in which an arm takes its scanner to a view, or home.

    Its hand is empty and as wide open as it can be.

    Args:
        world: without parts; its obstacles fill the bin.
        arm_name: which arm carries it.
        between: the postures (n,) [rad, m] where it begins and ends.
        scan_digest: of the parts, of which there are none.
        seed: of the request.

    Returns:
        The plan, or the verdict of its leg.
    """
    began = working_time()
    arm = world.arm(arm_name)
    opening = float(arm.tool.stroke[1])
    world.enter(LegPhase(frozenset({arm.name}), {arm.name: opening}))
    start, goal = (posture_of(world, arm, np.asarray(q)) for q in between)
    path = free_path(world, arm, start[None], goal, random_of(arm, seed))
    if isinstance(path, Verdict):
        return path
    leg = leg_of(world, arm, "view", path, opening, None)
    scene = Scene(scan_digest, (), world.obstacles)
    arm_plan = arm_alone(arm, (leg,), tool_loads(arm.tool))
    return plan_alone(world.cell, scene, arm_plan, seed=seed, began=began)
