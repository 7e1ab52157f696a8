"""The path of a scanner on an arm to its view, or home: one free leg, as it will be sent."""

from dataclasses import replace

import numpy as np
import pinocchio as pin

from workbench.model.candidate import Verdict
from workbench.model.geometry import Floats
from workbench.model.load import tool_loads
from workbench.model.plan import NO_PART, ArmPlan, Guarantee, Plan, Step, Strategy
from workbench.planning.collision.legs import phase_of
from workbench.planning.collision.world import World
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
    nothing = arm.name, NO_PART, "", pin.SE3.Identity()
    plan = ArmPlan(*nothing, arm.joints, (), loads=tool_loads(arm.tool))
    opening = float(arm.tool.stroke[1])
    world.enter(phase_of([(plan, "view", opening)]))
    start, goal = (posture_of(world, arm, np.asarray(q)) for q in between)
    rng = np.random.default_rng(np.random.SeedSequence([seed, ord(arm.controller_id)]))
    path = free_path(world, arm, start[None], goal, rng)
    if isinstance(path, Verdict):
        return path
    leg = leg_of(world, arm, "view", path, opening, None)
    return Plan(
        cell=world.cell.name,
        cell_digest=world.cell.digest,
        scan_digest=scan_digest,
        seed=seed,
        strategy=Strategy.single(arm.name),
        guarantee=Guarantee.ONE_AT_A_TIME,
        detections=(),
        obstacles=world.obstacles,
        arms=(replace(plan, legs=(leg,)),),
        sequence=(Step(((arm.name, "view"),)),),
        seconds={"route": working_time() - began},
    )
