"""Fingers whose place nobody knows: of arms that wait for their first leg, and before it.

The last plan left them open, or somebody moved them by hand.  So they may be anywhere in their
stroke, and a plan holds wherever they are.
"""

from dataclasses import replace

import numpy as np
import pytest
from bending import with_leg

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.cell import Cell
from workbench.model.messages.proofs import ProofText
from workbench.proof.claims.stages import tcp
from workbench.proof.engine.robot import tree_of

WIDE = 0.8
"""[m] A stroke by which fingers at home reach what is around them."""


def wide(cell: Cell, name: str, point: np.ndarray | None = None) -> Cell:
    """The cell with one arm's fingers that open far, at home towards a point (3,) [m] if any."""
    arm, tree = cell.arm(name), tree_of(cell)
    fingers = arm.tool.fingers
    if point is not None:
        T_world_tcp = tcp(tree, tree.rest, arm, np.asarray(arm.home))
        way = (T_world_tcp * arm.tool.T_flange_tcp.inverse()).actInv(point)
        fingers = tuple(replace(one, direction=way / np.linalg.norm(way)) for one in fingers)
    other = replace(arm, tool=replace(arm.tool, fingers=fingers, stroke=(0.0, WIDE)))
    return replace(cell, arms=tuple(other if one is arm else one for one in cell.arms))


@pytest.fixture(scope="module")
def alone(cell, detections):
    """A plan of the right arm, while the left one stands at home."""
    plan = plan_pick(cell, detections, "scan", strategy="right").plan
    assert plan is not None
    return plan


def found(cell: Cell, plan):
    return prove(cell, replace(plan, cell_digest=cell.digest))


def test_fingers_of_an_arm_that_waits_may_be_open(cell, alone):
    """The right hand passes where the left one's fingers can be, but are not when closed."""
    assert found(cell, alone).holds
    tree, (one,) = tree_of(cell), alone.arms
    q = one.leg("return").q[len(one.leg("return").q) // 2]
    point = tcp(tree, tree.rest, cell.arm("right"), q).translation
    proof = found(wide(cell, "left", point), alone)
    assert not proof.holds
    assert any("left finger" in " ".join(v.pair or ()) for v in proof.violations)


def test_fingers_may_be_anywhere_before_the_first_leg(cell, alone):
    """They are opened, or closed, to what the way to the part begins with."""
    proof = found(wide(cell, "right"), alone)
    assert {(v.leg, v.waypoint) for v in proof.violations} == {("reach", 0)}
    assert any("right finger" in " ".join(v.pair or ()) for v in proof.violations)


def test_fingers_do_not_move_between_two_legs(cell, alone):
    """The grasp may leave open how wide they arrive: then both legs say the same."""
    other = replace(cell, policy=replace(cell.policy, least_air=0.001))
    assert found(other, alone).holds
    opening = alone.arms[0].leg("approach").opening - 0.001
    proof = found(other, with_leg(alone, "right", "reach", opening=opening))
    assert [(v.leg, v.problem) for v in proof.violations] == [
        ("approach", ProofText.OPENING_CHANGES())
    ]
