"""The public description of the YuMi, real meshes and all, and poses as HALCON writes them."""

from pathlib import Path

import numpy as np
import pytest
from stand_ins import public_yumi, sources

from workbench.app.picking.pipeline import plan_pick
from workbench.app.picking.proving import prove
from workbench.formats.cells.reading import read_cell
from workbench.formats.plans.pose_files import read_poses
from workbench.model.candidate import Reason
from workbench.model.cell import Cell
from workbench.model.plan import PlanResult
from workbench.planning.kinematics.robot import Kinematics


@pytest.fixture(scope="module", params=sources("yumi"))
def folder(request, tmp_path_factory) -> Path:
    """A cell around a description that others made, or around its stand-in."""
    return public_yumi(request.param, tmp_path_factory.mktemp("public_yumi"))


@pytest.fixture(scope="module")
def cell(folder: Path) -> Cell:
    return read_cell(folder)


@pytest.fixture(scope="module")
def result(cell: Cell, folder: Path) -> PlanResult:
    return plan_pick(cell, read_poses(folder / "Poses.txt", "keyed_cylinder"), "poses", seed=0)


def test_both_parts_are_taken_and_the_plan_is_proven(cell: Cell, result: PlanResult) -> None:
    assert result.plan is not None, result.verdict
    assert {arm.arm for arm in result.plan.arms} == {"right", "left"}
    proof = prove(cell, result.plan)
    assert proof.holds, proof.violations
    assert proof.digest == result.proof.digest


def test_every_candidate_has_a_verdict(result: PlanResult) -> None:
    assert len(result.candidates) == 2 * 2 * 15
    assert all(isinstance(candidate.verdict.reason, Reason) for candidate in result.candidates)


def test_ours_is_the_same_machine(cell: Cell) -> None:
    ours = read_cell("yumi")
    theirs, mine = Kinematics(cell), Kinematics(ours)
    draw = np.random.default_rng(1)
    for arm, same in zip(cell.arms, ours.arms, strict=True):
        lower, upper, velocity = cell.robot.limits(arm.joints)
        np.testing.assert_allclose(
            np.stack(ours.robot.limits(same.joints)), [lower, upper, velocity], atol=1e-3
        )
        for q in draw.uniform(lower, upper, (20, 7)):
            off = theirs.tcp_pose(arm, q).translation - mine.tcp_pose(same, q).translation
            assert np.linalg.norm(off) < 2e-4  # their fingers are 0.1 mm shorter
