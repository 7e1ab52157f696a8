"""A plan that tilts a part too far, at waypoints, between them or in a corner, is not proven."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from bending import with_leg

from workbench.app.picking.pipeline import plan_pick
from workbench.formats.cells.reading import read_cell
from workbench.model.derived.upright import tilt_from_vertical
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import MotionModel
from workbench.model.scan import Detection
from workbench.planning.kinematics.chain import chain_of
from workbench.proof.claims.grasps import upright as claims
from workbench.proof.claims.grasps.upright import upright_violations
from workbench.proof.claims.tolerances import TILTED
from workbench.proof.engine.robot import tree_of

MOST = np.deg2rad(12.0)


@pytest.fixture(scope="module")
def cell():
    plain = read_cell("tx2_90")
    part = replace(plain.parts[0], upright=np.array([0.0, 0.0, 1.0]), tilt=MOST)
    return replace(plain, parts=(part,))


@pytest.fixture(scope="module")
def plan(cell):
    lying = Detection("puck", pose_from_rpy((0.6, 0.1, 0.03), (0.05, 0, 0)))
    return plan_pick(cell, (lying,), "scan", seed=0).plan


def violations(cell, plan):
    return list(upright_violations(cell, tree_of(cell), plan, plan.arms[0]))


def largest_tilt(cell, plan, q) -> float:
    """Of straight motions between waypoints (m, n) [rad], densely sampled."""
    arm_plan = plan.arms[0]
    chain = chain_of(cell, cell.arm(arm_plan.arm))
    shares = np.linspace(0, 1, 200)[:, None]
    return max(
        tilt_from_vertical(chain.pose(between).rotation @ arm_plan.T_tcp_part.rotation[:, 2])
        for start, end in pairwise(q)
        for between in start + shares * (end - start)
    )


def test_a_plan_as_planned_keeps_it_upright(cell, plan):
    assert violations(cell, plan) == []


@pytest.mark.parametrize("seed", range(40))
def test_what_is_accepted_is_never_tilted_farther(cell, plan, seed):
    """Waypoints of each leg moved at random, by little and by much."""
    rng = np.random.default_rng(seed)
    name = ("extract", "return", "place")[seed % 3]
    q = np.array(plan.arms[0].leg(name).q)
    q[1:-1] += rng.normal(0, rng.choice([0.01, 0.05, 0.2]), q[1:-1].shape)
    bent = with_leg(plan, plan.arms[0].arm, name, q=q)
    stops = replace(
        cell, controller=replace(cell.controller, motion=MotionModel("stop", corners="stop"))
    )
    tilt = largest_tilt(cell, plan, q)
    found = [one for one in violations(stops, bent) if one.leg == name]
    assert bool(found) or tilt <= MOST + 2 * TILTED
    # With its corners cut it may do more.
    assert not found or violations(cell, bent)
    if tilt > MOST + TILTED:
        assert found and found[0].problem.mentions(ProofText.TILTED)
        assert tilt_from_vertical(axis_at(cell, plan, found[0].q)) > MOST


def axis_at(cell, plan, q):
    chain = chain_of(cell, cell.arm(plan.arms[0].arm))
    return chain.pose(q).rotation @ plan.arms[0].T_tcp_part.rotation[:, 2]


def test_a_joint_that_turns_between_two_upright_waypoints_is_seen(cell, plan):
    """The wrist goes over by a half turn and back: both ends are upright."""
    q = np.array(plan.arms[0].leg("return").q)
    over = q[0].copy()
    over[4] += 0.5
    bent = with_leg(plan, plan.arms[0].arm, "return", q=np.array([q[0], over, *q]))
    assert any(one.leg == "return" for one in violations(cell, bent))


def test_what_is_near_its_limit_for_too_long_is_refused(cell, plan, monkeypatch):
    monkeypatch.setattr(claims, "MOST_SETS", 1)
    said = violations(cell, plan)
    assert said and all(one.problem.mentions(ProofText.TILTS_TOO_LONG) for one in said)


def test_a_leg_with_no_number_is_not_upright(cell, plan):
    q = np.array(plan.arms[0].leg("return").q)
    q[1] = np.nan
    assert violations(cell, with_leg(plan, plan.arms[0].arm, "return", q=q))


def test_a_part_that_may_be_tilted_is_not_looked_at(cell, plan):
    free = replace(cell, parts=(replace(cell.parts[0], upright=None),))
    q = np.array(plan.arms[0].leg("return").q)[::-1]
    assert violations(free, with_leg(plan, plan.arms[0].arm, "return", q=q)) == []
