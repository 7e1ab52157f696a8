"""What holds for every plan, whatever lies in the bin."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from shipped import shipped

from workbench.app.picking.judging import judge
from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.model.candidate import Pick, Reason, Verdict
from workbench.model.cell import PlanOverrides
from workbench.model.errors import InputError
from workbench.model.geometry import pose_from_rpy
from workbench.model.motion import MotionModel
from workbench.model.scan import Detection
from workbench.perception.simulation.piles import drop_parts
from workbench.planning.collision.contact import Contact
from workbench.planning.collision.motion import RESOLUTION
from workbench.planning.collision.world import World
from workbench.planning.picking.dual_arm import coordinate, pairs_of
from workbench.planning.picking.order import cost_of
from workbench.planning.picking.propose import propose
from workbench.planning.picking.resolve import resolve
from workbench.planning.picking.route import arm_plan
from workbench.planning.picking.search import PathQuery, search_path
from workbench.planning.planners.clock import processor_time

MOTION = MotionModel("anything")

CELL = shipped("yumi")
PART = CELL.parts[0]
FLOOR = CELL.bin.T_world_bin.translation


def pile(seed: int, count: int) -> tuple[Detection, ...]:
    return drop_parts((PART,) * count, CELL.bin, seed=seed)


@settings(
    max_examples=25, deadline=None, suppress_health_check=[HealthCheck.too_slow], derandomize=True
)
@given(
    seed=st.integers(0, 10_000),
    count=st.integers(1, 5),
    strategy=st.sampled_from(["auto", "alternated", "coordinated", "right", "left"]),
    planner=st.sampled_from(["rrtconnect", "rrt", "sbl"]),
    order=st.sampled_from(["travel", "highest", "thesis"]),
)
def test_every_plan_holds_when_it_is_looked_at_four_times_as_closely(
    seed, count, strategy, planner, order
):
    result = plan_pick(
        CELL,
        pile(seed, count),
        "test",
        strategy=strategy,
        overrides=PlanOverrides(planner=planner, order=order),
        seed=seed,
    )
    if result.plan is None:
        assert not result.verdict.is_ok
        return
    assert result.proof.holds, result.proof.violations
    finer = prove(CELL, result.plan, resolution=RESOLUTION / 4)
    assert finer.holds, finer.violations
    for arm in result.plan.arms:
        lower, upper, velocity = CELL.robot.limits(arm.joints)
        for leg in arm.legs:
            q, t = np.asarray(leg.q), np.asarray(leg.t)
            assert np.all((q >= lower - 1e-9) & (q <= upper + 1e-9))
            assert np.all(np.abs(np.diff(q, axis=0)) <= velocity * np.diff(t)[:, None] * 1.001)


MIRROR = np.diag([1.0, -1.0, 1.0])


def mirrored(detection: Detection) -> Detection:
    """The same part on the other side of the cell's middle plane.

    The part itself is symmetric about its own x-z plane, so its mirror image is a pose of it.
    """
    T = detection.T_world_part
    R = MIRROR @ T.rotation @ MIRROR
    return replace(detection, T_world_part=type(T)(R, MIRROR @ T.translation))


@settings(max_examples=12, deadline=None, derandomize=True)
@given(
    x=st.floats(-0.05, 0.05), y=st.floats(-0.09, 0.09), yaw=st.floats(-3, 3), roll=st.floats(-3, 3)
)
def test_a_mirrored_scene_gives_mirrored_feasibility(x, y, yaw, roll):
    T = pose_from_rpy(FLOOR + (x, y, 0.0195), (np.pi / 2, 0, yaw)) * pose_from_rpy(
        (0, 0, 0), (0, 0, roll)
    )
    here = Detection(PART.name, T)

    def able(detection: Detection, arm: str) -> int:
        found = judge(CELL, (detection,))
        return sum(one.verdict.is_ok for one in found if one.arm == arm)

    # Inverse kinematics starts at random, so a grasp at the edge may be found on one side alone.
    assert abs(able(here, "right") - able(mirrored(here), "left")) <= 1
    assert abs(able(here, "left") - able(mirrored(here), "right")) <= 1


def test_the_same_request_gives_the_same_plan_in_other_processes_and_after_other_plans():
    code = (
        "import sys; from workbench.app.picking.pipeline import plan_pick\n"
        "from workbench.formats.cells.reading import read_cell\n"
        "from workbench.model.cell import PlanOverrides\n"
        "from workbench.perception.simulation.piles import drop_parts\n"
        "cell = read_cell('yumi')\n"
        "def digest(s, strategy, planner):\n"
        "    pile = drop_parts(cell.parts[:1] * 2, cell.bin, seed=s)\n"
        "    w = PlanOverrides(planner=planner)\n"
        "    r = plan_pick(cell, pile, 'x', strategy=strategy, overrides=w, seed=s)\n"
        "    return r.plan.digest if r.plan else str(r.verdict)\n"
        "for s in map(int, sys.argv[1].split(',')):\n"
        "    for asked in (('auto', 'sbl'), ('coordinated', 'rrtconnect')):\n"
        "        print(s, *asked, digest(s, *asked))\n"
    )

    def said(seeds: str) -> set[str]:
        ended = subprocess.run(
            [sys.executable, "-c", code, seeds],
            capture_output=True, text=True, timeout=800, check=True,
        )  # fmt: skip
        return set(ended.stdout.splitlines())

    assert said("0,1,2") == said("2,0,1")


def test_a_planning_that_takes_too_long_is_ended_with_a_verdict():
    hurried = replace(CELL, policy=replace(CELL.policy, seconds=1e-6))
    result = plan_pick(hurried, pile(0, 2), "test")
    assert result.plan is None
    assert result.verdict.reason is Reason.OUT_OF_TIME
    reasons = {one.verdict.reason for one in result.candidates}
    assert reasons <= {Reason.OUT_OF_TIME, Reason.TOOL_COLLISION}


def test_a_search_that_takes_too_long_is_ended_with_a_verdict():
    def check(curves):
        return Contact(("hand", "wall"), -0.01, 0.0), np.zeros(2)

    box = np.full(2, 3.0)
    policy = replace(CELL.policy, iterations=10**6)
    rng = np.random.default_rng(0)
    query = PathQuery(check, (-box, box), np.ones(2), policy, MOTION, processor_time() + 0.05)
    found = search_path(query, -box / 2, box / 2, rng)
    assert found.reason is Reason.OUT_OF_TIME


def test_a_leg_for_which_no_time_was_left_is_not_called_impossible():
    detections = tuple(
        Detection(PART.name, pose_from_rpy(FLOOR + (0.0, y, 0.0191), (np.pi / 2, 0, np.pi / 2)))
        for y in (-0.03, 0.03)
    )
    world = World(CELL, detections)
    picks = [resolve(world, one, seed=0) for one in propose(world)]
    picks = [pick for pick in picks if isinstance(pick, Pick)]
    world.deadline = 0.0
    alone = [arm_plan(world, pick, 0) for pick in picks]
    refused = {one.reason for one in alone if isinstance(one, Verdict)}
    assert refused == {Reason.OUT_OF_TIME}
    pairs = pairs_of(world, picks, cost_of(world, "travel"))
    both = [coordinate(world, pair, scan_digest="s", seed=0) for pair in pairs[:6]]
    assert {one.reason for one in both if isinstance(one, Verdict)} == {Reason.OUT_OF_TIME}


@pytest.mark.parametrize("margin", [0.0, 0.5])
def test_margins_at_their_ends_give_a_plan_or_a_verdict(margin):
    policy = replace(CELL.policy, margin=margin, near_margin=min(margin, 0.05))
    result = plan_pick(replace(CELL, policy=policy), pile(0, 2), "test")
    if margin == 0.0:
        assert result.plan is not None and result.proof.holds
    else:
        assert result.plan is None and not result.verdict.is_ok


@pytest.mark.parametrize(
    "place", [(0.0, 0.15, 0.02), (0.0, 0.0, -0.3), (0.09, 0.14, 0.01)],
    ids=["in the wall", "under the table", "in the corner"],
)  # fmt: skip
def test_a_part_where_none_can_be_gives_verdicts(place):
    stuck = Detection(PART.name, pose_from_rpy(FLOOR + place, (np.pi / 2, 0, 0.1)))
    result = plan_pick(CELL, (stuck,), "test")
    by_library = [each for each in result.candidates if each.grasp.name.startswith("side-")]
    assert len(by_library) == 30
    assert result.plan is None or result.proof.holds


def test_an_arm_that_stands_in_collision_is_refused_with_the_pair():
    # The bin is where the right hand is at home.
    T_world_bin = CELL.bin.T_world_bin.copy()
    chain = World(CELL, ()).chains["right"]
    T_world_bin.translation = chain.pose(np.asarray(CELL.arm("right").home)).translation
    cell = replace(CELL, bin=replace(CELL.bin, T_world_bin=T_world_bin))
    result = plan_pick(cell, pile(0, 2), "test", strategy="right")
    assert result.plan is None
    assert not result.verdict.is_ok and result.verdict.pair is not None


@pytest.mark.parametrize("value", [np.nan, np.inf])
def test_numbers_that_are_none_do_not_become_poses(value):
    with pytest.raises(InputError):
        Detection(PART.name, pose_from_rpy((0.4, value, 0.0)))
