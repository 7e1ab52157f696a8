"""Both plans over a station, as a judge sees them who reads the files anew and asks physics."""

from dataclasses import replace

import numpy as np
import pytest
from judge import Judge
from judge_stations import stood_on
from judge_studies import cell_and_files

from workbench.app.picking.row import plan_row
from workbench.model.digest import digest_of
from workbench.model.geometry import pose_from_rpy
from workbench.model.scan import Detection, Scene
from workbench.proof.claims.prove import scene_after
from workbench.proof.claims.stages import tcp
from workbench.proof.engine.robot import tree_of


@pytest.fixture(scope="module")
def known():
    return cell_and_files("yumi", "regrasp.toml")


def lying(cell, x, y, yaw):
    place = cell.bin.T_world_bin.translation + np.array([x, y, 0.0191])
    return Detection("keyed_cylinder", pose_from_rpy(place, (np.pi / 2, 0.0, yaw)), 0.9)


@pytest.fixture(scope="module", params=[(0, 1), (1, 0)])
def row(known, request):
    """One of two parts, while the other one stays."""
    cell, _ = known
    both = lying(cell, 0.03, -0.05, 0.4), lying(cell, -0.05, 0.09, 2.0)
    parts = tuple(both[number] for number in request.param)
    planned = plan_row(cell, parts, digest_of(parts), avoided={1: "stays"})
    assert planned.plan.stations == ("post",)
    return parts, planned


@pytest.mark.extensive
def test_the_judge_finds_nothing_in_either_plan(known, row):
    cell, files = known
    parts, planned = row
    judge = Judge()
    first, second = planned.plans
    assert judge.refusal(files, Scene(digest_of(parts), parts), first) is None
    assert judge.refusal(files, scene_after(cell, first), second) is None


def put(cell, plan):
    """Where the part is when the hand lets go of it."""
    (one,), tree = plan.arms, tree_of(cell)
    T = tcp(tree, tree.rest, cell.arm(one.arm), np.asarray(one.leg("place").q[-1]))
    return T * one.T_tcp_part


def test_where_the_part_stands_afterwards_is_where_physics_brings_it(known, row):
    cell, files = known
    first = row[1].plan
    stands = scene_after(cell, first).detections[-1]
    fell = stood_on(files, "post", "keyed_cylinder", put(cell, first).homogeneous)
    off = stands.T_world_part.inverse().homogeneous @ fell
    assert np.linalg.norm(off[:3, 3]) < 0.002
    assert np.arccos(np.clip((np.trace(off[:3, :3]) - 1) / 2, -1, 1)) < np.deg2rad(2)


def test_the_judge_refuses_what_has_no_station_or_falls_over(known, row):
    _, files = known
    first = row[1].plan
    gone = files.copied()
    del gone.cell["station"]
    assert "no such station" in Judge().refusal(gone, first.scene, first).why
    aside = files.copied()
    aside.cell["station"][0]["position_mm"] = [45, 0, 0]
    assert Judge().refusal(aside, first.scene, first) is not None
    elsewhere = replace(first, arms=(replace(first.arms[0], station=""),))
    assert "no place is there" in Judge().refusal(files, first.scene, elsewhere).why
