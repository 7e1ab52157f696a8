"""The path of a scanner on an arm to its view: found and proven, or refused with the reason."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest
from arm_scanner_cell import on_arm_cell, six_axes_cell

from workbench.app.empty_hand.view_plan import plan_view
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.plan_files import read_plan, write_plan
from workbench.gui.shared.playback import in_hands, part_poses, timeline
from workbench.model.candidate import Reason
from workbench.model.cell import Cell, Fixture
from workbench.model.digest import digest_of
from workbench.model.errors import InputError
from workbench.model.geometry import Box, Solid
from workbench.model.plan import NO_PART, PlanResult
from workbench.planning.kinematics.robot import Kinematics
from workbench.plugins.misfit import misfit
from workbench.plugins.robot_link import controller_by


@pytest.fixture(scope="module")
def cell() -> Cell:
    return on_arm_cell()


@pytest.fixture(scope="module")
def result(cell: Cell) -> PlanResult:
    return plan_view(cell)


def with_wall(cell: Cell, at: tuple[float, float, float], size: tuple[float, ...]) -> Cell:
    wall = Solid("wall", Box(np.array(size)), pin.SE3.Identity())
    fixture = Fixture("wall", pin.SE3(np.eye(3), np.array(at)), (wall,))
    return replace(cell, fixtures=(*cell.fixtures, fixture))


def test_one_proven_leg_goes_from_home_to_the_view_with_an_empty_open_hand(
    cell: Cell, result: PlanResult
) -> None:
    plan, proof, carrier = result.plan, result.proof, cell.scanner.on_arm
    assert plan is not None and proof is not None and carrier is not None
    assert proof.holds
    (arm,) = plan.arms
    (leg,) = arm.legs
    assert (arm.arm, arm.detection, leg.name, leg.holding) == ("left", NO_PART, "view", False)
    step = cell.controller.motion.quantum
    assert np.abs(leg.q[0] - carrier.home).max() <= step
    assert np.abs(leg.q[-1] - carrier.view.q).max() <= step
    assert leg.opening == cell.arm("left").tool.stroke[1]
    assert plan.is_view_plan and not plan.picks and not plan.detections
    assert arm.loads is not None and arm.loads.part is None


def test_one_proven_leg_goes_back_home_from_the_view(cell: Cell, result: PlanResult) -> None:
    back, carrier = plan_view(cell, view="home"), cell.scanner.on_arm
    assert back.plan is not None and back.proof is not None and carrier is not None
    assert back.proof.holds and back.plan.is_view_plan
    (leg,) = back.plan.arms[0].legs
    step = cell.controller.motion.quantum
    assert np.abs(leg.q[0] - carrier.view.q).max() <= step
    assert np.abs(leg.q[-1] - carrier.home).max() <= step
    assert carrier.leads_home(leg.q) and digest_of(back.obstacles) == digest_of(result.obstacles)
    assert result.plan is not None and not carrier.leads_home(result.plan.arms[0].legs[0].q)


def test_the_bin_counts_as_full_with_a_part_upright_on_top(cell: Cell, result: PlanResult) -> None:
    (box,) = result.obstacles
    longest = max(np.linalg.norm(np.ptp(part.mesh.points, axis=0)) for part in cell.parts)
    top = (cell.bin.T_world_bin.actInv(box.T_world_box)).translation[2] + box.size[2] / 2
    assert top == pytest.approx(cell.bin.size[2] + longest)


def test_the_same_seed_brings_the_same_plan(cell: Cell, result: PlanResult) -> None:
    again = plan_view(cell, view="bin").plan
    assert again is not None and result.plan is not None
    assert again.digest == result.plan.digest


def test_a_camera_inside_a_wall_is_refused_with_the_wall(cell: Cell) -> None:
    T = cell.scanner.T_world_scanner
    walled = with_wall(cell, tuple(T.translation), (0.3, 0.3, 0.02))
    verdict = plan_view(walled).verdict
    assert verdict.reason is Reason.NO_PATH and verdict.pair is not None
    assert "wall" in verdict.pair and "at the end of the leg" in str(verdict)


def test_a_way_that_is_walled_up_is_refused(cell: Cell) -> None:
    boxed = with_wall(cell, (0.25, 0.0, 0.6), (0.01, 3.0, 3.0))
    result = plan_view(boxed)
    assert result.plan is None and result.verdict.reason is Reason.NO_PATH


def test_a_scanner_that_stands_and_another_view_are_refused(cell: Cell) -> None:
    with pytest.raises(InputError, match="hangs on no arm"):
        plan_view(read_cell("yumi"))
    with pytest.raises(InputError, match="no view 'deep'; it has bin"):
        plan_view(cell, view="deep")


def test_a_plan_file_holds_it_to_the_last_digit(tmp_path, result: PlanResult) -> None:
    assert result.plan is not None
    write_plan(tmp_path / "view.json", result.plan, result.proof)
    plan, stated = read_plan(tmp_path / "view.json")
    assert plan.digest == stated == result.plan.digest


def test_its_film_knows_no_part(cell: Cell, result: PlanResult) -> None:
    plan = result.plan
    assert plan is not None
    runs = timeline(plan)
    assert [(run.arm, run.words) for run in runs] == [("left", "view")]
    assert part_poses(cell, Kinematics(cell), (plan,), runs, 0.5) == ()
    assert in_hands(cell, (plan,), runs, 0.5) == {}


def test_a_link_that_sends_poses_alone_sends_no_path_to_a_view() -> None:
    cell = six_axes_cell("pick-server")
    plan = plan_view(cell).plan
    assert plan is not None and misfit(plan, cell) is None
    options = {"poses": "staubli", "longest": 128}
    there = replace(cell, controller=controller_by("pick-server", options=options))
    assert "no path without a part goes out" in str(misfit(plan, there))
