"""A part that has been put down is in the way of all that comes after."""

from dataclasses import replace

import numpy as np
import pytest
from bending import with_grasps, with_leg
from penetration import deepest

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import drop_parts
from workbench.proof.claims.walk import SPARE_MARGIN

DOWN = (np.pi, 0.0, 0.0)


@pytest.fixture(scope="module")
def tx2():
    return read_cell("tx2_90")


@pytest.fixture(scope="module")
def pucks(tx2):
    height = float(np.ptp(tx2.parts[0].mesh.points[:, 2])) / 2
    T = tx2.bin.T_world_bin * pose_from_rpy((0.05, -0.05, height + 0.0005))
    return plan_pick(tx2, (Detection("puck", T),), "scan")


@pytest.fixture(scope="module")
def apart(cell):
    """Both arms at once, each with a part of its own."""
    floor = cell.bin.T_world_bin.translation
    ends = [
        pose_from_rpy(floor + [0.0, y, 0.0191], (np.pi / 2, 0.0, np.pi / 2)) for y in (-0.1, 0.1)
    ]
    parts = tuple(Detection(cell.parts[0].name, T_world_part) for T_world_part in ends)
    return plan_pick(cell, parts, "scan", strategy="coordinated", seed=0)


def straight_home(plan, arm: str):
    """The plan with the way home straight ahead in joint space, in as much time."""
    leg = plan.arm(arm).leg("home")
    q = np.deg2rad(np.round(np.rad2deg(np.linspace(leg.q[0], leg.q[-1], 10)), 2))
    return with_leg(plan, arm, "home", q=q, t=np.linspace(0.0, 10.0, 10))


def test_fingers_do_not_pass_through_the_part_they_have_put_down(cell, result, apart):
    for plan in (result.plan, apart.plan):
        for one in plan.arms:
            assert deepest(cell, plan, one, "home", one) > 0.0


def test_a_cup_comes_off_the_part_it_has_put_down_no_deeper_than_it_was(tx2, pucks):
    (one,) = pucks.plan.arms
    assert deepest(tx2, pucks.plan, one, "home", one) > -tx2.arms[0].tool.press - 1e-3
    assert pucks.proof.holds


def test_a_way_home_through_the_part_just_put_down_is_refused(cell, result):
    for one in result.plan.arms:
        bent = straight_home(result.plan, one.arm)
        assert deepest(cell, bent, bent.arm(one.arm), "home", bent.arm(one.arm)) < 0.0
        violation = next(one for one in prove(cell, bent).violations if one.pair is not None)
        assert (violation.arm, violation.leg) == (one.arm, "home")
        assert f"part-{one.detection + 1}" in violation.pair


def test_so_it_is_while_both_arms_move(cell, apart):
    for one in apart.plan.arms:
        bent = straight_home(apart.plan, one.arm)
        problems = [one for one in prove(cell, bent).violations if one.leg == "home" and one.pair]
        assert any(f"part-{one.detection + 1}" in problem.pair for problem in problems)


def test_a_hand_that_was_clear_of_the_part_does_not_come_back_to_it(cell, result):
    """Out, nearer again than the margin without touching, and out."""
    (one, *_) = result.plan.arms
    leg = one.leg("home")
    out = cell.policy.straight_points
    back = np.array([leg.q[0], *leg.q[1:out], leg.q[0], *leg.q[1:]])
    times = np.linspace(0.0, 20.0, len(back))
    violations = prove(cell, with_leg(result.plan, one.arm, "home", q=back, t=times)).violations
    assert [violation.leg for violation in violations] == ["home"]
    assert f"part-{one.detection + 1}" in violations[0].pair
    assert 0.0 < violations[0].distance < cell.policy.margin


@pytest.fixture(scope="module")
def shared(cell):
    """Both arms put their parts onto the same two spots."""
    spots = [
        pose_from_rpy((0.41, y, 0.16), (np.pi, 0.0, turn))
        for y in (0.05, -0.05)
        for turn in (0.0, np.pi / 2)
    ]
    arms = tuple(replace(arm, Ts_world_place=tuple(spots)) for arm in cell.arms)
    return replace(cell, arms=arms)


@pytest.fixture(scope="module")
def pile(cell):
    """Two parts that each arm can lift past what the other has put down above the bin."""
    return drop_parts(cell.parts[:1] * 2, cell.bin, seed=1)


@pytest.mark.parametrize("strategy", ["alternated", "coordinated"])
def test_the_second_arm_puts_its_part_beside_that_of_the_first(shared, pile, strategy):
    result = plan_pick(shared, pile, "scan", strategy=strategy, seed=0)
    assert result.plan is not None, str(result.verdict)
    assert result.proof.holds, result.proof.violations
    first, second = result.plan.arms
    assert deepest(shared, result.plan, second, "place", first) > 0.0
    assert deepest(shared, result.plan, second, "home", first) > 0.0


def test_a_part_that_is_put_where_one_lies_already_is_refused(shared, pile):
    plan = plan_pick(shared, pile, "scan", strategy="alternated", seed=0).plan
    first, second = plan.arms
    # Alone the second arm takes the first spot of both.
    left_out = {first.detection: "for the other arm"}
    alone = plan_pick(shared, pile, "scan", strategy=second.arm, avoided=left_out, seed=0)
    assert alone.proof.holds, alone.proof.violations
    violations = prove(shared, replace(plan, arms=(first, *alone.plan.arms))).violations
    assert any(f"part-{first.detection + 1}" in violation.pair for violation in violations)


@pytest.mark.parametrize("strategy", ["left", "alternated", "coordinated"])
def test_a_hand_that_turns_on_its_way_out_is_refused(cell, detections, result, apart, strategy):
    """By two degrees, at the first waypoint: it comes near nothing by that."""
    plan = {"alternated": result.plan, "coordinated": apart.plan}.get(strategy)
    plan = plan or plan_pick(cell, detections, "scan", strategy=strategy, seed=0).plan
    assert plan.strategy == strategy
    for one in plan.arms:
        leg = one.leg("home")
        q = np.array(leg.q)
        q[1, -1] += np.deg2rad(2.0)
        bent = with_leg(plan, one.arm, "home", q=q, t=leg.t * 4)
        assert deepest(cell, bent, bent.arm(one.arm), "home", bent.arm(one.arm)) > 0.0
        said = [str(violation) for violation in prove(cell, bent).violations]
        assert said == [f"arm {one.arm} leg home after waypoint 0: is not straight"]


def test_a_hand_that_is_wide_open_has_not_left_the_part_between_its_fingers(cell, detections):
    """It keeps the whole margin as it opens; it goes straight all the same until it is past."""
    wide = with_grasps(cell, lambda grasp: replace(grasp, opening=0.05))
    plan = plan_pick(wide, detections, "scan", strategy="left", seed=0)
    assert plan.proof.holds
    (one,) = plan.plan.arms
    q = np.array(one.leg("home").q)
    assert deepest(wide, plan.plan, one, "home", one) > wide.policy.margin + SPARE_MARGIN
    q[1, -1] += np.deg2rad(10.0)
    q = wide.controller.motion.rounded(q)
    bent = with_leg(plan.plan, one.arm, "home", q=q, t=one.leg("home").t * 20)
    said = [str(violation) for violation in prove(wide, bent).violations]
    assert said == [f"arm {one.arm} leg home after waypoint 0: is not straight"]
