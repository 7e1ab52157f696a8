"""Both arms at once: planned, proven, and refused when bent."""

from dataclasses import replace

import numpy as np
import pytest
from bending import with_leg

from workbench.app.core.cycle.approval import approve
from workbench.app.picking import pipeline
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.errors import CommandRefused
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.message import plain
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.proofs import ProofText
from workbench.model.motion import LEG_NAMES
from workbench.model.plan import Guarantee, Step, Strategy, Violation
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.collision.legs import phase_of, stretches
from workbench.planning.collision.world import World
from workbench.planning.kinematics.chain import is_solution
from workbench.planning.picking.synchronized_motion import in_step
from workbench.planning.picking.weave import interleave
from workbench.plugins.robot_link import send, spoken_to_by


def lying(cell, x: float, y: float, turn: float) -> Detection:
    floor = cell.bin.T_world_bin.translation
    return Detection(
        cell.parts[0].name, pose_from_rpy(floor + [x, y, 0.0191], (np.pi / 2, 0.0, turn))
    )


@pytest.fixture(scope="module")
def apart(cell) -> tuple[Detection, ...]:
    """Two parts at the two ends of the bin."""
    return (lying(cell, 0.0, -0.1, np.pi / 2), lying(cell, 0.0, 0.1, np.pi / 2))


@pytest.fixture(scope="module")
def coordinated(cell, apart):
    return plan_pick(cell, apart, "scan", strategy="coordinated", seed=0)


def text(proof) -> str:
    return "; ".join(str(violation) for violation in proof.violations)


def test_parts_far_apart_are_taken_side_by_side(coordinated):
    plan = coordinated.plan
    assert plan.strategy is Strategy.COORDINATED
    assert plan.guarantee is Guarantee.TIME_INDEPENDENT
    assert [len(step.runs) for step in plan.sequence] == [2] * len(LEG_NAMES)
    assert coordinated.proof.holds, text(coordinated.proof)


def test_it_is_faster_than_one_after_the_other(cell, apart, coordinated):
    alternated = plan_pick(cell, apart, "scan", strategy="alternated", seed=0).plan
    assert coordinated.plan.cycle_seconds < 0.75 * alternated.cycle_seconds


def test_auto_takes_the_quicker_where_the_distance_allows_both(cell, apart, coordinated):
    """Nearer than the threshold arms work in turn; from there on whichever takes less time."""
    near = plan_pick(cell, apart, "scan", threshold=0.3, seed=0).plan
    assert near.strategy is Strategy.ALTERNATED
    far = plan_pick(cell, apart, "scan", threshold=0.1, seed=0).plan
    assert far.strategy is Strategy.COORDINATED
    assert far.cycle_seconds == coordinated.plan.cycle_seconds < near.cycle_seconds


WAITING = 5
"""A pile in which one arm cannot be in the bin while the other is."""


def test_where_arms_have_to_wait_auto_takes_the_quickest_order(cell):
    """It is never slower than turns, as these are among the orders."""
    pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=WAITING)
    plans = {
        strategy: plan_pick(cell, pile, "scan", strategy=strategy, threshold=0.0, seed=WAITING)
        for strategy in ("alternated", "coordinated", "auto")
    }
    times = {strategy: result.plan.cycle_seconds for strategy, result in plans.items()}
    assert times["auto"] == times["coordinated"] < times["alternated"]
    auto = plans["auto"]
    assert auto.plan.strategy is Strategy.COORDINATED and auto.proof.holds
    assert len({len(step.runs) for step in auto.plan.sequence}) == 2, "alone and both at once"


def test_it_holds_at_four_times_finer_resolution(cell, coordinated):
    fine = prove(cell, coordinated.plan, resolution=coordinated.proof.resolution / 4)
    assert fine.holds, text(fine)


def test_the_same_seed_gives_the_same_plan(cell, apart, coordinated):
    again = plan_pick(cell, apart, "scan", strategy="coordinated", seed=0).plan
    assert again.digest == coordinated.plan.digest


@pytest.mark.parametrize("seed", [1, 8, 16, 18, 38])
def test_whatever_comes_out_of_a_pile_is_proven_and_apart_at_any_speeds(cell, seed):
    """At random times of each arm, independent of each other, the arms keep their margin."""
    pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=seed)
    result = plan_pick(cell, pile, "scan", strategy="coordinated", seed=seed)
    plan = result.plan
    assert plan is not None
    assert result.proof.holds, text(result.proof)
    if plan.guarantee is not Guarantee.TIME_INDEPENDENT:
        return
    world = World(cell, pile)
    rng = np.random.default_rng(seed)
    for stretch in stretches(plan):
        world.enter(stretch.phase)
        for _ in range(40):
            state = dict(stretch.standing)
            for arm_plan, leg in stretch.runs:
                # Corners are rounded between the waypoints; at their middles nothing is.
                k = rng.integers(len(leg.t) - 1)
                state[arm_plan.arm] = leg.at(float(leg.t[k] + leg.t[k + 1]) / 2)
            assert not world.meets(world.configuration(state))


def test_a_sequence_in_another_order_fails_the_proof(cell, coordinated):
    plan = coordinated.plan
    late = (*plan.sequence[1:], plan.sequence[0])
    assert "every leg once" in text(prove(cell, replace(plan, sequence=late)))
    doubled = (*plan.sequence, plan.sequence[-1])
    assert "every leg once" in text(prove(cell, replace(plan, sequence=doubled)))
    both = plan.sequence[0].runs
    wrong = (Step((both[0], both[0])), *plan.sequence[1:])
    assert "twice" in text(prove(cell, replace(plan, sequence=wrong)))


@pytest.mark.parametrize("guarantee", [Guarantee.TIME_INDEPENDENT, Guarantee.SYNCHRONISED])
def test_arms_planned_for_turns_meet_when_they_go_at_once(cell, guarantee):
    """Two parts close together: the proof names what meets, and on which leg."""
    close = (lying(cell, 0.0, -0.03, np.pi / 2), lying(cell, 0.0, 0.03, np.pi / 2))
    plan = plan_pick(cell, close, "scan", strategy="alternated", seed=0).plan
    first, second = plan.arms
    pairs = tuple(Step(((first.arm, name), (second.arm, name))) for name in LEG_NAMES)
    at_once = replace(plan, strategy=Strategy.COORDINATED, guarantee=guarantee, sequence=pairs)
    proof = prove(cell, at_once)
    met = [
        violation
        for violation in proof.violations
        if violation.problem.text is ProofText.MARGIN_BESIDE
    ]
    assert met
    for violation in met:
        assert {label.split("_")[0].split()[0] for label in violation.pair} == {"right", "left"}
        assert violation.distance < cell.policy.margin
    claimed = replace(plan, guarantee=Guarantee.ONE_AT_A_TIME, sequence=pairs)
    assert "one arm after the other" in text(prove(cell, claimed))


def test_legs_in_step_are_proven_in_step_only(cell, apart, coordinated):
    """Side by side at any speeds is more than in step; the other way about it is not."""
    plan = coordinated.plan
    legs = [plan.arm(arm).leg("approach") for arm in ("right", "left")]
    t = np.maximum(legs[0].t, legs[1].t) * 2
    in_step = with_leg(with_leg(plan, "right", "approach", t=t), "left", "approach", t=t)
    in_step = replace(in_step, guarantee=Guarantee.SYNCHRONISED)
    assert prove(cell, in_step).holds


def test_what_the_controller_cannot_do_is_not_approved(cell, coordinated):
    cell = spoken_to_by(cell, "abb-socket")
    with pytest.raises(CommandRefused, match="moves one arm at a time"):
        approve(cell, coordinated.plan, coordinated.proof, "Ada", 0.0)


def test_no_controller_is_sent_finer_steps_than_it_can_take(cell, coordinated):
    """What it would make of them is not what was proven; its cell has the same digest."""
    motion = replace(cell.controller.motion, link="coarse", decimals=1)
    coarse = replace(cell, controller=replace(cell.controller, motion=motion))
    assert coarse.digest == cell.digest
    plan, proof = coordinated.plan, coordinated.proof
    with pytest.raises(CommandRefused, match="finer steps than the robot link coarse"):
        approve(coarse, plan, proof, "Ada", 0.0)
    approval = approve(cell, plan, proof, "Ada", 0.0)
    with pytest.raises(CommandRefused, match="finer steps than the robot link coarse"):
        next(send(plan, approval, coarse, now=lambda: 1.0))


def test_one_part_is_still_taken(cell, apart):
    result = plan_pick(cell, apart[:1], "scan", strategy="coordinated", seed=0)
    assert result.plan is None
    assert "coordinated" in str(result.verdict)


def test_both_arms_as_one_motion(cell, apart, coordinated):
    """All joints searched together: the legs share their times, and the plan is proven in step."""
    plan = coordinated.plan
    world = World(cell, apart)
    for name in ("reach", "approach"):
        runs = [(arm, name, arm.leg(name).opening) for arm in plan.arms]
        world.enter(phase_of(runs))
        legs = in_step(world, plan.arms, name, np.random.default_rng(0))
        assert legs is not None
        assert np.array_equal(legs[0].t, legs[1].t)
        for arm, leg in zip(plan.arms, legs, strict=True):
            assert np.array_equal(leg.q[0], arm.leg(name).q[0])
            assert np.array_equal(leg.q[-1], arm.leg(name).q[-1])
            plan = with_leg(plan, arm.arm, name, q=leg.q, t=leg.t)
    proof = prove(cell, replace(plan, guarantee=Guarantee.SYNCHRONISED))
    assert proof.holds, text(proof)


def test_there_is_no_motion_to_where_the_arms_touch(cell, result):
    """Both hands at one place: refused before any search."""
    world = World(cell, result.plan.detections)
    chains = world.chains
    right, left = (result.plan.arm(name) for name in ("right", "left"))
    T_world_tcp = chains["right"].pose(np.asarray(right.leg("reach").q[-1]))
    starts = np.random.default_rng(0).uniform(chains["left"].lower, chains["left"].upper, (40, 7))
    answers, residuals = chains["left"].solve(T_world_tcp, starts)
    q = np.vstack([left.leg("reach").q[:-1], answers[is_solution(residuals)][:1]])
    bent = with_leg(result.plan, "left", "reach", q=q).arm("left")
    runs = [(arm, "reach", 0.04) for arm in (right, bent)]
    world.enter(phase_of(runs))
    before = world.checks
    assert in_step(world, (right, bent), "reach", np.random.default_rng(0)) is None
    assert world.checks - before < 5


def refusing(monkeypatch, refuses) -> list[str]:
    """Have the proof refuse some plans, and note the strategies of all that it is asked for."""
    asked = []

    def proven(cell, scene, plan):
        asked.append(str(plan.strategy))
        proof = pipeline.prove_as_it_is(cell, scene, plan)
        if refuses(plan):
            proof = replace(proof, violations=(Violation(plain("refused by the test")),))
        return proof

    monkeypatch.setattr(pipeline, "prove_as_it_is", pipeline.prove, raising=False)
    monkeypatch.setattr(pipeline, "prove", proven)
    return asked


def is_at_once(plan) -> bool:
    return any(len(step.runs) > 1 for step in plan.sequence)


@pytest.mark.parametrize(
    ("strategy", "tried"),
    [
        ("alternated", ["alternated"] * 2),
        ("auto", ["coordinated", "alternated", "alternated"]),
    ],
)
def test_where_the_proof_refuses_arms_at_once_the_plan_in_turns_is_taken(
    cell, apart, monkeypatch, strategy, tried
):
    as_it_is = plan_pick(cell, apart, "scan", strategy=strategy, threshold=0.1, seed=0)
    assert is_at_once(as_it_is.plan)
    asked = refusing(monkeypatch, is_at_once)
    result = plan_pick(cell, apart, "scan", strategy=strategy, threshold=0.1, seed=0)
    assert asked == tried
    assert result.proof.holds and result.proof.plan_digest == result.plan.digest
    assert not is_at_once(result.plan)
    assert result.plan.strategy == Strategy.ALTERNATED
    assert result.plan.guarantee is Guarantee.ONE_AT_A_TIME
    assert result.plan.cycle_seconds > as_it_is.plan.cycle_seconds
    (note,) = (one for one in result.plan.notes if one.text is PlanNote.QUICKER_REFUSED)
    assert "refused by the test" in str(note)
    assert not any(one.text is PlanNote.QUICKER_REFUSED for one in as_it_is.plan.notes)


def test_where_every_proof_is_refused_the_first_plan_is_shown(cell, apart, monkeypatch):
    asked = refusing(monkeypatch, lambda plan: True)
    result = plan_pick(cell, apart, "scan", strategy="alternated", seed=0)
    assert len(asked) == 2 and is_at_once(result.plan)
    assert "refused by the test" in text(result.proof)


@pytest.fixture(scope="module")
def in_turn(cell, apart):
    """One arm after the other, as it is before the second sets out early."""
    with pytest.MonkeyPatch.context() as patch:
        refusing(patch, is_at_once)
        return plan_pick(cell, apart, "scan", strategy="alternated", seed=0).plan


def test_the_second_arm_sets_out_while_the_first_goes_home(cell, apart, in_turn):
    shorter, last = interleave(World(cell, apart), in_turn, freely=False)
    assert last is in_turn
    assert shorter.strategy is Strategy.ALTERNATED
    assert shorter.guarantee is Guarantee.TIME_INDEPENDENT
    assert shorter.cycle_seconds < in_turn.cycle_seconds
    (both,) = [step.runs for step in shorter.sequence if len(step.runs) > 1]
    assert both == ((in_turn.arms[0].arm, "home"), (in_turn.arms[1].arm, "reach"))
