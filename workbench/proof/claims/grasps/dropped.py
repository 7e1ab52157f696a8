"""How a hand goes that drops back what it holds: straight up, and to where it opens."""

from collections.abc import Iterator

import numpy as np

from workbench.model.cell import Cell
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import ArmPlan, Leg, Plan, Violation
from workbench.model.tools.held_body import HeldAmount, held_radius
from workbench.proof.claims.drop_back import DROPPED, TIPPED, drop_point
from workbench.proof.claims.grasps.straight import straight_violations
from workbench.proof.claims.stages import tcp
from workbench.proof.claims.tolerances import HAND_TURN_REACH
from workbench.proof.engine.robot import Tree

OFF_LIFT = 0.0005
"""[m] Any point of what the hand holds, off its straight line up."""


def held_violations(cell: Cell, tree: Tree, plan: Plan) -> Iterator[Violation]:
    """Whether a hand goes straight up, and opens where the cell has it open, pointing down."""
    if not plan.is_drop_plan:
        return
    (arm_plan,) = plan.arms
    for leg in arm_plan.legs:
        if leg.name == "lift":
            yield from _lift_violations(cell, tree, arm_plan, leg)
        elif leg.name == "carry":
            yield from _end_violations(cell, tree, arm_plan, leg)


def _lift_violations(cell: Cell, tree: Tree, arm_plan: ArmPlan, leg: Leg) -> Iterator[Violation]:
    arm, q = cell.arm(arm_plan.arm), np.asarray(leg.q)
    begin, end = (tcp(tree, tree.rest, arm, at).translation for at in (q[0], q[-1]))
    gone = cell.bin.T_world_bin.rotation.T @ (end - begin)
    if not (gone[2] > 0.0 and np.hypot(gone[0], gone[1]) <= OFF_LIFT):
        yield Violation(ProofText.NOT_UP(), arm.name, leg.name)
    # What cannot be met on the way up is not compared: so the hand may neither lean nor turn.
    reach = HAND_TURN_REACH / OFF_LIFT * held_radius(cell, HeldAmount(arm_plan.held))
    may_be_off = OFF_LIFT, OFF_LIFT
    yield from straight_violations(tree, arm, leg.name, q, reach=reach, may_be_off=may_be_off)


def _end_violations(cell: Cell, tree: Tree, arm_plan: ArmPlan, leg: Leg) -> Iterator[Violation]:
    arm, last = cell.arm(arm_plan.arm), len(leg.q) - 1
    T_world_tcp = tcp(tree, tree.rest, arm, np.asarray(leg.q[-1]))
    wanted = drop_point(cell, HeldAmount(arm_plan.held))
    off = float(np.linalg.norm(T_world_tcp.translation - wanted))
    if not off <= DROPPED:
        yield Violation(ProofText.OTHER_DROP(off=off), arm.name, leg.name, last)
    # What it lets go of falls plumb down, however the bin stands.
    tilt = float(np.arccos(np.clip(-T_world_tcp.rotation[2, 2], -1.0, 1.0)))
    if not tilt <= TIPPED:
        yield Violation(ProofText.DROP_TIPPED(tilt=tilt), arm.name, leg.name, last)
