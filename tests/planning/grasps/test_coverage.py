"""Coverage: what works where, the same every time, and advice that helps."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from workbench.formats.cells.reading import read_cell
from workbench.formats.parts.reading import read_part
from workbench.model.cell import Cell
from workbench.model.geometry import spread_directions
from workbench.model.part import GraspLibrary, Part
from workbench.model.scan import Detection
from workbench.planning.collision.world import World
from workbench.planning.grasps.coverage import Coverage, coverage, rank_for_bin
from workbench.planning.grasps.grasp_suggestions import suggest
from workbench.planning.grasps.grasp_trial import Trial
from workbench.planning.picking.propose import propose

COARSE = {"directions": 16, "turns": 2, "places": ((0.0, 0.0),)}


@pytest.fixture(scope="module")
def yumi() -> Cell:
    return read_cell("yumi")


@pytest.fixture(scope="module")
def part() -> Part:
    return read_part("keyed_cylinder")


@pytest.fixture(scope="module")
def covered(yumi, part) -> Coverage:
    return coverage(yumi, part, **COARSE)


def with_grasps(part: Part, library: GraspLibrary) -> Part:
    return Part(part.name, part.mesh, part.pieces, part.mass, part.symmetry, library)


def test_the_shipped_grasps_cover_most_and_the_same_every_time(yumi, part, covered):
    assert covered.poses == 32 and covered.directions.shape == (16, 3)
    assert covered.share > 0.8
    assert covered.grasp_shares.shape == (15, 2)
    assert (covered.arm_shares.max(axis=1) <= covered.shares + 1e-12).all()
    again = coverage(yumi, part, **COARSE)
    assert np.array_equal(again.grasp_shares, covered.grasp_shares)
    assert np.array_equal(again.shares, covered.shares)


def test_what_works_is_what_planning_proposes(yumi, part):
    trial = Trial(yumi, part)
    grasps = part.library.grasps
    usable = trial.usable(grasps)
    assert usable.all()
    for k, up in enumerate(spread_directions(5)):
        for T in trial.poses(up, k, 1, ((0.0, 0.0),)):
            works = trial.works([T], grasps, usable)[0]
            admitted = {
                (c.grasp.name, c.arm)
                for c in propose(World(yumi, (Detection(part.name, T),)))
                if c.verdict.is_ok
            }
            found = {(grasps[g].name, yumi.arms[a].name) for g, a in np.argwhere(works).tolist()}
            assert found <= admitted


def test_the_part_stands_on_the_floor_between_the_walls(yumi, part):
    trial = Trial(yumi, part)
    for k, up in enumerate(spread_directions(9)):
        for T in trial.poses(up, k, 2, ((-0.5, -0.5), (0.5, 0.5))):
            points = yumi.bin.T_world_bin.actInv(T)
            inside = np.asarray(part.mesh.points) @ points.rotation.T + points.translation
            assert inside[:, 2].min() == pytest.approx(0.0, abs=1e-9)
            assert (np.abs(inside[:, :2]).max(axis=0) <= yumi.bin.size[:2] / 2 + 1e-9).all()
            assert T.rotation @ up == pytest.approx([0, 0, 1], abs=1e-9)


def test_without_grasps_all_is_missing_and_the_advice_helps(yumi, part):
    bare = with_grasps(part, GraspLibrary())
    found = coverage(yumi, bare, **COARSE)
    assert found.share == 0.0 and found.missing is not None
    missing = found.missing
    assert missing.suggestion is not None and missing.would_work > 0.3
    helped = with_grasps(part, GraspLibrary((missing.suggestion.grasp,)))
    assert coverage(yumi, helped, **COARSE, advise=False).share > 0.1


def test_grasps_that_may_not_be_used_cover_nothing(yumi, part):
    grasps = part.library.grasps
    off = with_grasps(part, GraspLibrary(tuple(replace(g, is_enabled=False) for g in grasps)))
    assert coverage(yumi, off, **COARSE, advise=False).share == 0.0
    left = with_grasps(part, GraspLibrary(tuple(replace(g, arms=("left",)) for g in grasps)))
    shares = coverage(yumi, left, **COARSE, advise=False).arm_shares.mean(axis=0)
    assert shares[0] == 0.0 and shares[1] > 0.5


def test_it_reports_and_can_be_ended(yumi, part):
    said: list[float] = []
    found = coverage(
        yumi,
        part,
        **COARSE,
        report=lambda done, note: said.append(done),
        cancelled=lambda: len(said) >= 4,
    )
    assert found.poses == 8 and found.missing is None
    assert said == sorted(said)
    nothing = coverage(yumi, part, **COARSE, cancelled=lambda: True)
    assert nothing.poses == 0 and nothing.share == 0.0


def test_directions_are_spread_evenly():
    ups = spread_directions(100)
    assert np.linalg.norm(ups, axis=1) == pytest.approx(np.ones(100))
    assert np.linalg.norm(ups.mean(axis=0)) < 0.02
    nearest = np.sort(ups @ ups.T, axis=1)[:, -2]
    assert np.rad2deg(np.arccos(nearest)).min() > 12


def test_a_pose_is_a_pose(yumi, part):
    T = Trial(yumi, part).poses(np.array([0.0, 0.0, -1.0]), 0, 1, ((0.0, 0.0),))[0]
    assert isinstance(T, pin.SE3) and np.linalg.det(T.rotation) == pytest.approx(1.0)


def test_suggestions_are_ranked_by_the_ways_to_lie_that_the_bin_admits():
    cell = read_cell("yumi")
    part, tool = cell.parts[0], cell.arms[0].tool
    found = suggest(part, tool, most=12, seed=0)
    ranked = rank_for_bin(cell, part, tool, found)
    shares = [share for _, share in ranked]
    assert shares == sorted(shares, reverse=True) and 0 <= shares[-1] < shares[0] <= 1
    assert sorted(one.grasp.name for one, _ in ranked) == sorted(one.grasp.name for one in found)
    far = replace(cell.bin, T_world_bin=pin.SE3(np.eye(3), np.array([9.0, 0.0, 0.0])))
    assert all(share == 0 for _, share in rank_for_bin(replace(cell, bin=far), part, tool, found))
    assert rank_for_bin(cell, part, tool, ()) == ()
