"""The proof: good plans pass, also looked at more finely; bent ones fail with the reason."""

from dataclasses import replace

import numpy as np
import pytest
from bending import with_leg

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.geometry import pose_from_rpy
from workbench.model.plan import Guarantee, Step
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import is_solution
from workbench.proof.claims import prove as layer
from workbench.proof.engine.space import Space


def text(proof) -> str:
    return "; ".join(str(violation) for violation in proof.violations)


def test_a_planned_plan_holds(cell, result):
    proof = prove(cell, result.plan)
    assert proof.holds, text(proof)
    assert proof.plan_digest == result.plan.digest
    assert cell.policy.margin - proof.resolution <= proof.clearance


def test_it_holds_at_four_times_finer_resolution(cell, result):
    usual = prove(cell, result.plan)
    fine = prove(cell, result.plan, resolution=usual.resolution / 4)
    assert fine.holds, text(fine)
    assert fine.checks >= usual.checks


def test_the_same_plan_has_the_same_proof(cell, result):
    assert prove(cell, result.plan).digest == prove(cell, result.plan).digest


def test_less_is_measured_to_check_a_proof_than_to_find_it(cell, detections, monkeypatch):
    """For one arm, for two in turn, and for both at once: states that are looked at, and pairs."""
    counted, distance = [], Space.distance

    def counting(space, row):
        counted.append(row)
        return distance(space, row)

    monkeypatch.setattr(Space, "distance", counting)
    for strategy in ("left", "alternated", "coordinated"):
        plan = plan_pick(cell, detections, "scan", strategy=strategy, seed=0).plan
        measured = []
        for stated in (None, layer.prove(cell, plan.scene, plan)):
            counted.clear()
            proof = layer.prove(cell, plan.scene, plan, stated=stated)
            assert proof.holds, text(proof)
            measured.append((proof.checks, len(counted)))
        (found, pairs), (checked, pairs_checked) = measured
        assert checked < found and pairs_checked < pairs, (strategy, measured)


def test_a_part_put_down_elsewhere_fails(cell, result):
    """The last straight way ends 5 mm above the place."""
    arm = cell.arm(result.plan.arms[0].arm)
    chain = World(cell, result.plan.detections).chains[arm.name]
    place, home = (result.plan.arm(arm.name).leg(name).q.copy() for name in ("place", "home"))
    above = pose_from_rpy((0.0, 0.0, 0.005)) * chain.pose(place[-1])
    answers, residuals = chain.solve(above, place[-1])
    assert is_solution(residuals)[0]
    place[-1] = home[0] = cell.controller.motion.rounded(answers[0])
    bent = result.plan
    for name, q in (("place", place), ("home", home)):
        bent = with_leg(bent, arm.name, name, q=q, t=bent.arm(arm.name).leg(name).t * 2)
    (violation,) = prove(cell, bent).violations
    assert str(violation) == f"arm {arm.name} leg place: the hand opens where the arm has no place"


def test_a_waypoint_in_the_wall_names_leg_pair_and_clearance(cell, result):
    """A waypoint of the way back is replaced by one with the hand inside the bin's wall."""
    arm = cell.arm(result.plan.arms[0].arm)
    chain = World(cell, result.plan.detections).chains[arm.name]
    q = result.plan.arm(arm.name).leg("return").q.copy()
    side = -1.0 if arm.name == "right" else 1.0
    wall = cell.bin.T_world_bin * pose_from_rpy(
        (0.0, side * cell.bin.size[1] / 2, 0.05), (np.pi, 0, 0)
    )
    starts = np.vstack([q, np.random.default_rng(0).uniform(chain.lower, chain.upper, (30, 7))])
    answers, residuals = chain.solve(wall, starts)
    q[3] = cell.controller.motion.rounded(answers[is_solution(residuals)][0])
    proof = prove(cell, with_leg(result.plan, arm.name, "return", q=q))
    violation = next(violation for violation in proof.violations if violation.pair is not None)
    assert (violation.arm, violation.leg) == (arm.name, "return")
    assert violation.waypoint in (2, 3)
    assert "bin_wall" in violation.pair[0] + violation.pair[1]
    assert violation.distance < cell.policy.margin


def turned_in_hand(arm):
    return replace(arm, T_tcp_part=pose_from_rpy((0, 0, 0), (0, 0, 0.1)) * arm.T_tcp_part)


@pytest.mark.parametrize(
    ("bend", "says"),
    [
        (lambda p: replace(p, cell_digest="0" * 64), "another cell"),
        (lambda p: replace(p, arms=()), "moves no arm"),
        (lambda p: replace(p, sequence=p.sequence[::-1]), "sequence"),
        (
            lambda p: replace(p, sequence=(Step(tuple(r for s in p.sequence for r in s.runs)),)),
            "sequence",
        ),
        (
            lambda p: replace(
                p, guarantee=Guarantee.TIME_INDEPENDENT, sequence=(*p.sequence, Step(()))
            ),
            "moves no arm",
        ),
        (lambda p: replace(p, arms=(p.arms[0], p.arms[0])), "used twice"),
        (lambda p: replace(p, arms=(replace(p.arms[0], detection=9),)), "no detection 9"),
        (lambda p: replace(p, arms=(replace(p.arms[0], arm="third"),)), "no arm third"),
        (
            lambda p: replace(p, arms=(replace(p.arms[0], grasp="none"), *p.arms[1:])),
            "no grasp none",
        ),
        (lambda p: replace(p, arms=(replace(p.arms[0], legs=p.arms[0].legs[1:]),)), "legs are not"),
        (
            lambda p: replace(p, arms=(turned_in_hand(p.arms[0]), *p.arms[1:])),
            "not where the hand closes",
        ),
    ],
)
def test_a_plan_of_wrong_form_fails(cell, result, bend, says):
    proof = prove(cell, bend(result.plan))
    assert not proof.holds
    assert says in text(proof)


def bent_leg(result, change, name="return"):
    arm = result.plan.arms[0].arm
    leg = result.plan.arm(arm).leg(name)
    return with_leg(result.plan, arm, name, **change(leg))


def joint_beyond_limit(leg):
    q = leg.q.copy()
    q[3, 1] = np.deg2rad(60.0)
    return {"q": q}


def finer_than_wire(leg):
    q = leg.q.copy()
    q[3, 1] += np.deg2rad(0.003)
    return {"q": q}


def jump(leg):
    q = leg.q.copy()
    q[0, 0] += np.deg2rad(2.0)
    return {"q": q}


def nan(leg):
    q = leg.q.copy()
    q[2, 2] = np.nan
    return {"q": q}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (joint_beyond_limit, "is outside"),
        (finer_than_wire, "finer than what can be sent"),
        (jump, "does not start where the arm stands"),
        (nan, "not a finite number"),
        (lambda leg: {"holding": False}, "in the hand"),
        (lambda leg: {"opening": 0.2}, "fingers at 200.0 mm"),
        (lambda leg: {"t": leg.t[::-1].copy()}, "do not increase"),
        (lambda leg: {"t": leg.t * 1e-3}, "faster than the joints"),
        (lambda leg: {"q": leg.q[:, :5]}, "shape"),
    ],
)
def test_a_bent_leg_fails_with_its_reason(cell, result, change, says):
    proof = prove(cell, bent_leg(result, change))
    assert not proof.holds
    assert says in text(proof)


@pytest.mark.parametrize(
    "moved",
    [pose_from_rpy((0.005, 0, 0)), pose_from_rpy((0, 0, 0), (0, 0, 0.05))],
    ids=["by 5 mm", "turned by 3 degrees"],
)
def test_a_part_that_is_elsewhere_fails(cell, result, moved):
    """The hand would close beside it."""
    detections = list(result.plan.detections)
    number = result.plan.arms[0].detection
    T_world_part = detections[number].T_world_part * moved
    detections[number] = replace(detections[number], T_world_part=T_world_part)
    proof = prove(cell, replace(result.plan, detections=tuple(detections)))
    assert not proof.holds
    assert "not where the hand closes" in text(proof)


def test_two_arms_with_very_many_waypoints_are_refused_before_all_pairs_are_looked_at(cell, result):
    """Each way for itself may be as long as it likes; beside another one it would take hours."""
    plan = result.plan
    first, second = plan.arms
    for one, name in ((first, "home"), (second, "reach")):
        q = np.asarray(one.leg(name).q)
        rows = np.vstack([q[0], *[q[[0, 1]]] * 150, q[1:]])
        plan = with_leg(plan, one.arm, name, q=rows, t=np.arange(len(rows)) * 50.0)
    assert any(len(step.runs) == 2 for step in plan.sequence)
    proof = prove(cell, plan)
    assert "too many waypoints beside leg reach" in "; ".join(map(str, proof.violations))
