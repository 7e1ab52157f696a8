"""From detections to verdicts, picks and plans."""

from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from bending import with_grasps

from workbench.app.picking.pipeline import plan_pick
from workbench.model.candidate import Pick, Reason, Stage
from workbench.model.cell import PlanOverrides
from workbench.model.errors import InputError, JobCancelled
from workbench.model.geometry import pose_from_rpy
from workbench.model.messages.plans import PlanNote
from workbench.model.messages.verdicts import VerdictNote
from workbench.model.motion import LEG_NAMES
from workbench.model.plan import Guarantee, Strategy
from workbench.model.scan import Detection
from workbench.planning.collision.world import World
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve
from workbench.plugins.misfit import misfit
from workbench.plugins.robot_link import spoken_to_by


def test_every_detection_grasp_and_arm_has_a_verdict(cell, detections, result):
    grasps = cell.part("keyed_cylinder").library.grasps
    expected = {(d, g.name, a.name) for d in range(2) for g in grasps for a in cell.arms}
    assert {(c.detection, c.grasp.name, c.arm) for c in result.candidates} == expected
    assert len(result.candidates) == 60


def test_refusals_carry_their_evidence(result):
    reasons = Counter(candidate.verdict.reason for candidate in result.candidates)
    assert reasons[Reason.OK] >= 2 and reasons[Reason.TOOL_COLLISION] >= 10
    for candidate in result.candidates:
        verdict = candidate.verdict
        if verdict.reason is Reason.TOOL_COLLISION:
            assert verdict.pair is not None and verdict.distance < 0.001
            assert verdict.stage is Stage.PROPOSE
        if verdict.reason in (Reason.IN_COLLISION, Reason.OUT_OF_REACH):
            assert verdict.q is not None and verdict.distance is not None


def test_two_arms_take_two_parts_one_after_the_other(result):
    plan = result.plan
    assert plan.strategy is Strategy.ALTERNATED
    assert plan.guarantee is Guarantee.TIME_INDEPENDENT
    assert {arm.arm for arm in plan.arms} == {"right", "left"}
    assert {arm.detection for arm in plan.arms} == {0, 1}
    assert result.proof.holds
    first, second = (arm.arm for arm in plan.arms)
    runs = [run for step in plan.sequence for run in step.runs]
    assert runs == [(arm, leg) for arm in (first, second) for leg in LEG_NAMES]
    at_once = [step.runs for step in plan.sequence if len(step.runs) > 1]
    assert at_once == [((first, "home"), (second, "reach"))]
    assert len(plan.arms[0].leg("approach").q) == 5
    assert len(plan.arms[0].leg("extract").q) == 5


def test_the_hand_closes_where_the_grasp_was_authored(cell, detections, result):
    """Up to half a turn about the approach axis, which is the same for two fingers."""
    world = World(cell, detections)
    grasps = {grasp.name: grasp for grasp in cell.part("keyed_cylinder").library.grasps}
    for arm in result.plan.arms:
        T_world_tcp = world.chains[arm.arm].pose(np.asarray(arm.leg("approach").q[-1]))
        T_world_part = detections[arm.detection].T_world_part
        wanted = T_world_part * grasps[arm.grasp].T_part_tcp
        assert np.linalg.norm(T_world_tcp.translation - wanted.translation) < 0.0005
        np.testing.assert_allclose(T_world_tcp.rotation[:, 2], wanted.rotation[:, 2], atol=2e-3)
        assert abs(T_world_tcp.rotation[:, 1] @ wanted.rotation[:, 1]) > 1 - 1e-4
        part_again = T_world_tcp * arm.T_tcp_part
        np.testing.assert_allclose(part_again.homogeneous, T_world_part.homogeneous, atol=1e-9)


def test_the_same_seed_gives_the_same_plan_also_after_others(cell, detections, result):
    plan_pick(cell, detections, "scan", seed=7)
    assert plan_pick(cell, detections, "scan", seed=0).plan.digest == result.plan.digest


def test_stages_leave_their_inputs_alone(cell, detections):
    from workbench.model.digest import digest_of

    before = digest_of(detections), cell.digest, digest_of(cell, without=frozenset({"digest"}))
    plan_pick(cell, detections, "scan", seed=1)
    after = digest_of(detections), cell.digest, digest_of(cell, without=frozenset({"digest"}))
    assert before == after


@pytest.mark.parametrize("arm", ["right", "left"])
def test_one_arm_alone_when_asked_for(cell, detections, arm):
    result = plan_pick(cell, detections, "scan", strategy=arm, seed=0)
    assert [one.arm for one in result.plan.arms] == [arm]
    assert result.proof.holds


def test_one_part_is_taken_by_one_arm_and_the_note_says_so(cell, detections):
    result = plan_pick(cell, detections[:1], "scan", seed=0)
    assert len(result.plan.arms) == 1
    assert result.plan.notes == (PlanNote.NO_OTHER_ARM(),)
    assert plan_pick(cell, detections[:1], "scan", strategy="alternated").plan is None


def test_disabled_grasps_are_refused_as_such(cell, detections):
    result = plan_pick(with_grasps(cell, lambda g: replace(g, is_enabled=False)), detections, "s")
    assert result.plan is None
    assert {c.verdict.reason for c in result.candidates} == {Reason.DISABLED}


def test_an_arm_that_is_not_allowed_is_named(cell, detections):
    result = plan_pick(with_grasps(cell, lambda g: replace(g, arms=("left",))), detections, "s")
    for candidate in result.candidates:
        if candidate.arm == "right":
            assert candidate.verdict.reason is Reason.ARM_NOT_ALLOWED
    assert [arm.arm for arm in result.plan.arms] == ["left"]


def test_an_opening_beyond_the_stroke_is_a_refusal(cell, detections):
    wide = with_grasps(cell, lambda g: replace(g, opening=0.08))
    verdicts = [candidate.verdict for candidate in propose(World(wide, detections))]
    assert all(verdict.note.text is VerdictNote.STROKE for verdict in verdicts)


def test_a_part_far_away_is_out_of_reach(cell):
    away = Detection("keyed_cylinder", pose_from_rpy((0.41, 1.5, 0.5), (np.pi / 2, 0, 0)))
    result = plan_pick(cell, (away,), "s")
    assert result.plan is None
    assert result.verdict.reason is Reason.OUT_OF_REACH
    assert result.verdict.distance > 0.3


def with_places(cell, *Ts_world_place):
    """The cell with other places for both arms."""
    arms = tuple(replace(arm, Ts_world_place=Ts_world_place) for arm in cell.arms)
    return replace(cell, arms=arms)


def test_a_place_out_of_reach_and_no_place_are_told_apart(cell, detections):
    for other, says in (
        (with_places(cell, pose_from_rpy((3, 0, 0))), VerdictNote.PLACES_UNREACHABLE()),
        (with_places(cell), VerdictNote.NO_PLACE_FOR_ARM()),
    ):
        verdict = plan_pick(other, detections, "s", strategy="right").verdict
        assert (verdict.reason, verdict.note) == (Reason.NO_PLACE, says)


def test_a_place_where_the_arm_is_at_home_can_be_used(cell, detections):
    """The leg home then goes nowhere."""
    home = np.asarray(cell.arm("right").home)
    at_home = with_places(cell, World(cell, ()).chains["right"].pose(home))
    result = plan_pick(at_home, detections, "s", strategy="right")
    assert result.plan is not None and result.proof.holds
    q = np.asarray(result.plan.arms[0].leg("home").q)
    assert len(q) == 2 and np.array_equal(q[0], q[1])


def test_a_part_inside_the_wall_is_refused_not_crashed(cell):
    wall = cell.bin.T_world_bin * pose_from_rpy((0.0, cell.bin.size[1] / 2, 0.02))
    result = plan_pick(cell, (Detection("keyed_cylinder", wall),), "s")
    assert result.plan is None
    assert not result.verdict.is_ok


def test_a_refused_candidate_is_given_its_own_verdict_back(cell, detections):
    world = World(cell, detections)
    refused = next(c for c in propose(world) if not c.verdict.is_ok)
    assert resolve(world, refused, seed=0) is refused.verdict


def test_picks_keep_to_limits_and_the_wire(cell, detections):
    world = World(cell, detections)
    picks = [resolve(world, c, seed=0) for c in propose(world) if c.verdict.is_ok]
    picks = [pick for pick in picks if isinstance(pick, Pick)]
    assert picks
    for pick in picks:
        chain = world.chains[pick.candidate.arm]
        for path in (pick.approach, pick.extract, pick.place):
            assert np.all(path >= chain.lower) and np.all(path <= chain.upper)
            hundredths = np.rad2deg(path) * 100
            np.testing.assert_allclose(hundredths, np.round(hundredths), atol=1e-6)
        assert np.array_equal(pick.approach[-1], pick.extract[0])


def test_nothing_to_plan_and_unknown_strategies_are_clear_errors(cell, detections):
    with pytest.raises(InputError, match="no parts"):
        plan_pick(cell, (), "s")
    with pytest.raises(InputError, match="'neither' is not one of auto"):
        plan_pick(cell, detections, "s", strategy="neither")


def test_both_strategies_are_planned_and_what_can_be_sent_is_taken(cell, detections):
    one_arm = spoken_to_by(cell, "abb-socket")
    result = plan_pick(one_arm, detections, "s", strategy="both")
    (other,) = result.beside
    assert (result.plan.strategy, other.plan.strategy) == ("alternated", "coordinated")
    quicker = plan_pick(cell, detections, "s", strategy="both")
    (slower,) = quicker.beside
    assert {quicker.plan.strategy, slower.plan.strategy} == {"alternated", "coordinated"}
    assert quicker.plan.cycle_seconds <= slower.plan.cycle_seconds
    # The same work, without a stop at every waypoint.
    assert quicker.plan.cycle_seconds < other.plan.cycle_seconds
    assert result.proof.holds and other.proof.holds
    assert other.plan.cycle_seconds < result.plan.cycle_seconds
    for one, plan in ((one_arm, other.plan), (cell, quicker.plan)):
        alone = plan_pick(one, detections, "s", strategy=plan.strategy)
        assert plan.digest == alone.plan.digest


def test_a_wider_margin_is_kept(cell, detections):
    wide = plan_pick(cell, detections, "s", overrides=PlanOverrides(margin=0.02))
    usual = plan_pick(cell, detections, "s")
    assert usual.proof.clearance < 0.02 <= wide.proof.clearance


def test_planning_can_be_cancelled(cell, detections):
    with pytest.raises(JobCancelled):
        plan_pick(cell, detections, "s", cancelled=lambda: True)


@pytest.mark.parametrize(("protocol", "threshold"), [("abb-socket/2", 0.2), ("abb-socket", 0.1)])
def test_auto_takes_one_after_the_other_where_they_lie_near_or_the_controller_cannot(
    cell, detections, protocol, threshold
):
    other = spoken_to_by(cell, protocol)
    result = plan_pick(other, detections, "s", threshold=threshold)
    assert (result.plan.strategy, result.proof.holds) == ("alternated", True)
    assert result.plan.cell_digest == cell.digest
    assert result.plan.notes[0].text in (PlanNote.NEARER, PlanNote.FARTHER)


def test_auto_takes_the_quicker_way_where_they_lie_apart_and_the_controller_can(cell, detections):
    other = spoken_to_by(cell, "abb-socket/2")
    result = plan_pick(other, detections, "s", threshold=0.1)
    ways = [
        plan_pick(other, detections, "s", strategy=Strategy(name)).plan
        for name in ("coordinated", "alternated")
    ]
    quickest = min(plan.cycle_seconds for plan in ways)
    assert result.proof.holds
    assert result.plan.notes[0].text in (PlanNote.NEARER, PlanNote.FARTHER)
    assert result.plan.cycle_seconds == pytest.approx(quickest)
    assert misfit(ways[0], other) is None
    assert "moves one arm at a time" in str(misfit(ways[0], spoken_to_by(cell, "abb-socket")))
