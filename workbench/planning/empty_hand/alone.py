"""A plan of one arm that takes no part: what a path to a view, stirring, a drop back share."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from workbench.model.cell import Arm, Cell
from workbench.model.load import Loads
from workbench.model.plan import NO_PART, ArmPlan, Guarantee, Leg, Plan, Step, Strategy
from workbench.model.scan import Scene
from workbench.planning.planners.clock import working_time


def arm_alone(arm: Arm, legs: Sequence[Leg], loads: Loads | None) -> ArmPlan:
    """What an arm does that takes no part: legs in their order, with the loads that it carries."""
    nothing = arm.name, NO_PART, "", pin.SE3.Identity()
    return ArmPlan(*nothing, arm.joints, tuple(legs), loads=loads)


def plan_alone(cell: Cell, scene: Scene, arm_plan: ArmPlan, *, seed: int, began: float) -> Plan:
    """A plan in which one arm moves, leg after leg.

    Args:
        cell: for which it was planned.
        scene: what the plan states of the bin.
        arm_plan: all that the arm does.
        seed: of the request.
        began: when planning began [s], by `working_time`.
    """
    arm = arm_plan.arm
    return Plan(
        cell=cell.name,
        cell_digest=cell.digest,
        scan_digest=scene.scan_digest,
        seed=seed,
        strategy=Strategy.single(arm),
        guarantee=Guarantee.ONE_AT_A_TIME,
        detections=scene.detections,
        obstacles=scene.obstacles,
        arms=(arm_plan,),
        sequence=tuple(Step(((arm, leg.name),)) for leg in arm_plan.legs),
        seconds={"route": working_time() - began},
    )


def random_of(arm: Arm, seed: int) -> np.random.Generator:
    """Everything random of an arm's paths, the same for the same seed."""
    return np.random.default_rng(np.random.SeedSequence([seed, ord(arm.controller_id)]))
