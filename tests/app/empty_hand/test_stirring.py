"""A hand that stirs the parts in the bin: planned, proven, read from a file, or refused."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.app.empty_hand.stirring import plan_stir
from workbench.app.picking.sightlines import sees_from
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.gui.shared.playback import in_hands, part_poses, timeline
from workbench.model.candidate import Reason
from workbench.model.cell import Cell, Fixture
from workbench.model.digest import digest_of
from workbench.model.geometry import Box, Solid
from workbench.model.plan import PlanResult
from workbench.model.scan import Scene
from workbench.perception.simulation.piles import pile_of
from workbench.planning.collision.legs import stretches
from workbench.planning.kinematics.chain import chain_of
from workbench.planning.kinematics.robot import Kinematics
from workbench.plugins.misfit import misfit
from workbench.plugins.robot_link import controller_by


@pytest.fixture(scope="module")
def cell() -> Cell:
    return read_cell("robots/yumi/kits.toml")


@pytest.fixture(scope="module")
def scene(cell: Cell) -> Scene:
    pile = pile_of(cell, "", 5, seed=3)
    return Scene(digest_of(pile), pile)


@pytest.fixture(scope="module")
def result(cell: Cell, scene: Scene) -> PlanResult:
    return plan_stir(cell, scene)


def test_a_closed_hand_goes_slowly_around_the_bin_just_above_its_floor(
    cell: Cell, scene: Scene, result: PlanResult
) -> None:
    plan, proof = result.plan, result.proof
    assert plan is not None and proof is not None and proof.holds
    assert plan.is_stir_plan and not plan.is_view_plan and not plan.picks
    assert plan.detections == scene.detections and plan.obstacles == scene.obstacles
    (arm,) = plan.arms
    assert [leg.name for leg in arm.legs] == ["reach", "stir", "home"]
    assert {leg.opening for leg in arm.legs} == {cell.arm(arm.arm).tool.stroke[0]}
    speeds = {bound.leg: bound for bound in proof.speeds}
    assert 0.05 < speeds["stir"].tcp <= cell.policy.stir_speed * 1.001
    chain = chain_of(cell, cell.arm(arm.arm))
    way = [cell.bin.T_world_bin.actInv(chain.pose(q).translation) for q in arm.leg("stir").q]
    low = np.array([p for p in way if p[2] < 0.05])
    assert len(low) > 10 and np.ptp(low[:, 0]) > 0.08 and np.ptp(low[:, 1]) > 0.15


def test_the_same_seed_brings_the_same_plan(cell: Cell, scene: Scene, result: PlanResult) -> None:
    again = plan_stir(cell, scene).plan
    assert again is not None and result.plan is not None and again.digest == result.plan.digest


def test_a_plan_file_holds_it_to_the_last_digit(tmp_path, result: PlanResult) -> None:
    assert result.plan is not None
    write_plan(tmp_path / "stir.json", result.plan, result.proof)
    plan, stated = read_plan(tmp_path / "stir.json")
    assert plan.digest == stated == result.plan.digest


def test_its_preview_leaves_the_parts_where_they_were_found(cell: Cell, result: PlanResult) -> None:
    plan = result.plan
    assert plan is not None
    runs = timeline(plan)
    assert [run.words for run in runs] == ["reach", "stir", "home"]
    poses = part_poses(cell, Kinematics(cell), (plan,), runs, runs[1].end)
    assert all(found.T_world_part == T for T, found in zip(poses, plan.detections, strict=True))
    assert in_hands(cell, (plan,), runs, runs[1].end) == {}


def test_where_something_stands_in_the_way_everywhere_the_reason_is_reported(
    cell: Cell, scene: Scene
) -> None:
    T = cell.bin.T_world_bin * pin.SE3(np.eye(3), np.array([0.0, 0.0, 0.3]))
    lid = Solid("lid", Box(np.array([0.6, 0.8, 0.02])), pin.SE3.Identity())
    covered = replace(cell, fixtures=(*cell.fixtures, Fixture("lid", T, (lid,))))
    found = plan_stir(covered, scene)
    assert found.plan is None and found.verdict.reason in (Reason.NO_PATH, Reason.IN_COLLISION)


def test_a_link_that_sends_no_times_or_poses_alone_is_not_sent_it(
    cell: Cell, result: PlanResult
) -> None:
    assert result.plan is not None and misfit(result.plan, cell) is None
    there = replace(cell, controller=controller_by("abb-socket"))
    assert "no path that has to be slow goes out" in str(misfit(result.plan, there))


def test_a_hand_whose_opening_the_link_cannot_say_is_wide_open(cell: Cell, scene: Scene) -> None:
    motion = replace(cell.controller.motion, takes_openings=False)
    there = replace(cell, controller=replace(cell.controller, motion=motion))
    plan = plan_stir(there, scene).plan
    if plan is not None:
        arm = there.arm(plan.arms[0].arm)
        assert plan.arms[0].leg("stir").opening == arm.tool.stroke[1]


def test_the_scanner_sees_past_the_arms_once_the_hand_has_left_the_parts(
    cell: Cell, result: PlanResult
) -> None:
    assert result.plan is not None
    seeing = replace(cell, scanner=replace(cell.scanner, while_moving=True))
    assert sees_from(seeing, result.plan) in (0, 3)
    phases = [stretch.phase for stretch in stretches(result.plan)]
    assert len(phases) == 3 and not any(phase.held or phase.placed for phase in phases)
