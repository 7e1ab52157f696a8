"""What holds for each leg and grip of an arm: said once, for planner and proof."""

import math
from collections.abc import Iterator

from workbench.model.cell import Arm
from workbench.model.plan import ArmPlan, Leg, LegName, Plan
from workbench.planning.pairing import Phase

STRAIGHT: frozenset[LegName] = frozenset({"approach", "extract"})
"""Legs on which tool and held part may come as near as the policy's `near_margin`."""

HOLDING: frozenset[LegName] = frozenset({"extract", "return", "place"})
"""Legs with the part in the hand; after `place` it is released."""

FREE_STEP = math.radians(30.0)
"""[rad] Grasps that may turn about the hand's axis are tried this far apart, or closer."""

TARGETED: frozenset[LegName] = frozenset({"approach"})
"""Legs on which the tool goes around the part that it takes."""


def grip_turns(arm: Arm, free_rotation: float = 0.0) -> list[float]:
    """Turns of the hand about its own z [rad] that are the same grip, the authored one first.

    Two fingers can change places; `free_rotation` [rad] either way is covered in steps.
    """
    count = math.ceil(free_rotation / FREE_STEP - 1e-9)
    free = [0.0]
    for k in range(1, count + 1):
        free += [free_rotation * k / count, -free_rotation * k / count]
    halves = (0.0, math.pi) if len(arm.tool.fingers) == 2 else (0.0,)
    return [turn + half for turn in free for half in halves]


def phase_of(arm_plan: ArmPlan, name: LegName, opening: float, gone: frozenset[int]) -> Phase:
    """The phase of one leg when it runs alone.

    Args:
        arm_plan: whose arm moves; detection and in-hand pose are read from it.
        name: which leg.
        opening: of the fingers during the leg [m].
        gone: detections that other arms have taken away before.
    """
    holding = name in HOLDING
    taken = frozenset({arm_plan.detection}) if name == "home" else frozenset()
    return Phase(
        moving=frozenset({arm_plan.arm}),
        openings={arm_plan.arm: opening},
        held={arm_plan.arm: (arm_plan.detection, arm_plan.T_tcp_part)} if holding else {},
        absent=gone | taken,
        target=arm_plan.detection if name in TARGETED else None,
        straight=name in STRAIGHT,
    )


def phases_of(plan: Plan) -> Iterator[tuple[ArmPlan, Leg, Phase]]:
    """The legs of a plan that moves one arm at a time, in its order, each with its phase."""
    gone: frozenset[int] = frozenset()
    for step in plan.sequence:
        for arm, name in step.runs:
            arm_plan = plan.arm(arm)
            leg = arm_plan.leg(name)
            yield arm_plan, leg, phase_of(arm_plan, leg.name, leg.opening, gone)
            if leg.name == "home":
                gone = gone | {arm_plan.detection}
