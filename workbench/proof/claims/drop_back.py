"""What the proof asks of a plan by which an arm drops back what it holds.

Nobody knows what the hand holds, so a ball about the TCP stands for it (`tools.held_body`), and
no scan shows the bin: it counts as full (`stirring.unseen_content`).  On the leg `lift` the hand
goes straight up, and the rules of a hand that stirs hold for the content of the bin.  Bin and
fixtures below it cannot be met and are not compared (`held_body.stand_below`).  All else is, links
of the arm that holds it included: on `carry` the ball keeps its margin to everything but the hand.
At the end of `carry` the hand points down, where the cell has it open; from there the part falls.
"""

from collections.abc import Iterator

import numpy as np

from workbench.model.cell import Cell
from workbench.model.geometry import Floats
from workbench.model.messages.proofs import ProofText
from workbench.model.plan import ArmPlan, Plan, Violation
from workbench.model.scan import Scene
from workbench.model.tools.held_body import HeldAmount, held_radius, tool_problem
from workbench.proof.claims.stirring import unseen_content
from workbench.proof.claims.tolerances import OPENING

ABOVE_CONTENT = 0.005
"""[m] Above the content of the bin and the margin the ball is where the hand opens."""

DROPPED = 0.005
"""[m] From where the cell has the hand open to the TCP."""

TIPPED = np.deg2rad(30.0)
"""[rad] The hand that opens, off pointing down."""

LEAST_STEEP = 0.2
"""No unit: of the normal of a bin's floor, upwards; a bin that lies on its side holds no parts."""


def drop_point(cell: Cell, held: HeldAmount) -> Floats:
    """Where (3,) [m] the TCP is in the world as the hand opens.

    It is the place of the cell file; else plumb over the middle of the bin's rim, clear of content.
    """
    if cell.bin.p_world_drop is not None:
        return np.asarray(cell.bin.p_world_drop)
    top, rim = unseen_content(cell, Scene("", ())).top, float(cell.bin.size[2])
    high = top + held_radius(cell, held) + cell.policy.margin + ABOVE_CONTENT
    p_world_rim = cell.bin.T_world_bin.act(np.array([0.0, 0.0, rim]))
    return p_world_rim + np.array([0.0, 0.0, (high - rim) / _steepness(cell)])


def fall_height(cell: Cell, held: HeldAmount) -> float | None:
    """From how high [m] above the lowest point of the bin's floor a part falls, at most.

    A part reaches from the TCP down, so its lowest point is no higher than the TCP.  None where the
    place of the cell file is not plumb over the bin: what lies below it is not known.
    """
    T, p = cell.bin.T_world_bin, drop_point(cell, held)
    length, width, rim = np.asarray(cell.bin.size)
    p_bin = T.actInv(p)
    above_rim = max(float(p_bin[2]) - rim, 0.0) / _steepness(cell)
    entry = T.actInv(p - np.array([0.0, 0.0, above_rim]))
    if p_bin[2] < 0.0 or np.any(np.abs(entry[:2]) > np.array([length, width]) / 2):
        return None
    R = T.rotation
    lowest = T.translation[2] - abs(R[2, 0]) * length / 2 - abs(R[2, 1]) * width / 2
    return float(p[2] - lowest) + DROPPED


def _steepness(cell: Cell) -> float:
    """How far [m/m] what falls goes along the normal of the bin's floor, per way plumb down."""
    return max(float(cell.bin.T_world_bin.rotation[2, 2]), LEAST_STEEP)


def drop_violations(cell: Cell, plan: Plan, arm_plan: ArmPlan) -> Iterator[Violation]:
    """Whether a plan does nothing else, of an amount that is known, with the hand open after it."""
    arm = cell.arm(arm_plan.arm)
    does_more = plan.detections or arm_plan.takes_part or arm_plan.grasp or arm_plan.station
    if len(plan.arms) > 1 or does_more or arm_plan.tcp or arm_plan.found is not None:
        yield Violation(ProofText.NOT_ONLY_DROP(), arm.name)
    if arm_plan.held not in set(HeldAmount):
        problem = ProofText.UNKNOWN_AMOUNT(held=f"{arm_plan.held!r:.60}", known=list(HeldAmount))
        yield Violation(problem, arm.name)
    if problem := tool_problem(arm.tool):
        yield Violation(problem, arm.name)
    if not cell.controller.motion.keeps_hand:
        yield Violation(ProofText.DROP_LINK(link=cell.controller.link), arm.name)
    for leg in arm_plan.legs:
        is_closed = leg.name == "home" and abs(leg.opening - arm.tool.stroke[1]) > OPENING
        if arm.tool.fingers and is_closed:
            yield Violation(ProofText.DROP_OPENING(opening=leg.opening), arm.name, leg.name)
